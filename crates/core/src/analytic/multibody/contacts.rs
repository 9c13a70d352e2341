//! Kinematics of the contacts in one state, without derivatives.

use super::FINGERS;
use super::components::{
    ContactModel, ContactPair, SignedIndex, disc_indices, disc_pair_indices, disc_time_indices, finger_indices,
    phalanx_indices, scatter,
};
use super::contact_kinematics::{self, ContactKinematics};
use super::frame;
use super::model::Multibody;
use crate::fivebar::kinematics::{Directions, PassiveRates};

/// Pose of a finger with its passive rates.
pub type FingerKinematics = (Directions<f64>, PassiveRates<f64>);

/// Placeholder for a finger that the system does not have.
const ABSENT_FINGER: FingerKinematics = {
    let none = [0.0; 2];
    (Directions { e1: none, e2: none, e3: none, e4: none }, PassiveRates { a3: none, a4: none, inverse_sine: 0.0 })
};

impl<const N: usize, const C: usize> Multibody<N, C> {
    /// Pose of a finger with its passive rates.
    #[inline(always)]
    pub(super) fn finger_kinematics(&self, finger: usize, q: &[f64; N]) -> FingerKinematics {
        self.fingers[finger].model.kinematics(Self::finger_coordinates(finger, q))
    }

    /// Kinematics of all fingers; a placeholder for missing ones.
    #[inline(always)]
    pub(super) fn all_finger_kinematics(&self, q: &[f64; N]) -> [FingerKinematics; FINGERS] {
        let mut all_finger_kinematics = [ABSENT_FINGER; FINGERS];
        for (finger, finger_kinematics) in all_finger_kinematics.iter_mut().enumerate().take(self.finger_count()) {
            *finger_kinematics = self.finger_kinematics(finger, q);
        }
        all_finger_kinematics
    }

    /// Like [`Multibody::contact_kinematics`], but compiled only once, for callers that need it rarely.
    #[inline(never)]
    pub(super) fn contact_kinematics_noinline(
        &self,
        q: &[f64; N],
        finger_kinematics: &dyn Fn(usize) -> FingerKinematics,
        contact: &ContactModel,
    ) -> ContactKinematics<f64, N> {
        self.contact_kinematics(q, finger_kinematics, contact)
    }

    /// Kinematics of a contact, with rows over all coordinates.
    #[inline(always)]
    pub(super) fn contact_kinematics(
        &self,
        q: &[f64; N],
        finger_kinematics: impl FnOnce(usize) -> FingerKinematics,
        contact: &ContactModel,
    ) -> ContactKinematics<f64, N> {
        match contact.pair {
            ContactPair::Phalanx { .. } | ContactPair::Stop { .. } if Self::DISCS => {
                unreachable!("systems of this size have no fingers")
            }
            ContactPair::Phalanx { finger, phalanx, disc } => {
                let component = &self.fingers[finger];
                let ((pose, rates), mirror) = (finger_kinematics(finger), component.side.mirror());
                let object = self.disc_in_finger_frame(component.side, disc, q);
                let geometry = component.model.phalanx_geometry(&pose, &rates, phalanx, &object);
                spread(
                    &contact_kinematics::phalanx(&geometry),
                    &phalanx_indices(finger, self.first_coordinate(disc), mirror),
                )
            }
            ContactPair::Stop { finger } => {
                let (pose, rates) = finger_kinematics(finger);
                spread(
                    &contact_kinematics::limit(&self.fingers[finger].model.limit_geometry(&pose, &rates)),
                    &finger_indices(finger),
                )
            }
            ContactPair::Discs { disc, other } => {
                let kinematics = contact_kinematics::discs([&self.placed_disc(disc, q), &self.placed_disc(other, q)]);
                spread(&kinematics, &disc_pair_indices([self.first_coordinate(disc), self.first_coordinate(other)]))
            }
            ContactPair::Plane { disc, plane } => {
                let kinematics =
                    contact_kinematics::plane(&plane, &self.placed_disc(disc, q), self.shares_contact_point());
                spread(&kinematics, &disc_indices(self.first_coordinate(disc)))
            }
            ContactPair::MovingPlane { disc, plane } => {
                let kinematics = frame::table(&plane, &self.pose(q), 0.0, &self.placed_disc(disc, q));
                spread(&kinematics, &disc_time_indices(self.first_coordinate(disc), self.time_index.unwrap_or(N)))
            }
        }
    }
}

/// Expands rows over the coordinates `indices` to rows over all coordinates.
#[inline(always)]
fn spread<const N: usize, const K: usize>(
    kinematics: &ContactKinematics<f64, K>,
    indices: &[SignedIndex; K],
) -> ContactKinematics<f64, N> {
    let expand = |values: &[f64; K]| {
        let mut row = [0.0; N];
        scatter(&mut row, indices, values);
        row
    };
    let (normal_row, tangent_row) = (expand(&kinematics.normal_row), expand(&kinematics.tangent_row));
    ContactKinematics {
        gap: kinematics.gap,
        normal_row,
        tangent_row,
        normal: kinematics.normal,
        point: kinematics.point,
    }
}
