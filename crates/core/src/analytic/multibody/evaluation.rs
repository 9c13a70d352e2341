//! Kinematics and forces of the contacts, and the energies, in one state, without derivatives.

use super::components::{
    ContactModel, ContactPair, SignedIndex, disc_indices, disc_pair_indices, disc_time_indices, finger_indices,
    phalanx_indices, scatter,
};
use super::contact_kinematics::{self, ContactKinematics};
use super::frame;
use super::inertia::{Inertia, Inverse};
use super::model::Multibody;
use super::{FINGERS, normal_force_on_branch};
use crate::analytic::ContactState;
use crate::analytic::contact::Geometry;
use crate::analytic::finger::PassiveJoints;
use crate::analytic::mode::row_dot;
use crate::analytic::model::{ContactReading, Energies};
use crate::fivebar::dynamics::Terms;
use crate::fivebar::kinematics::{Directions, PassiveRates};
use crate::law::{elastic_energy, friction_with_state};
use crate::numeric::plane::dot;
use crate::numeric::{map_array, map_same_type};
use crate::shape::Support;

/// Pose of a finger with its passive rates.
pub(crate) type FingerKinematics = (Directions<f64>, PassiveRates<f64>);

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

    fn terms(&self, q: &[f64; N]) -> [Option<Terms<f64>>; FINGERS] {
        let mut all = [None; FINGERS];
        for (finger, terms) in all.iter_mut().enumerate().take(self.finger_count()) {
            *terms = Some(self.fingers[finger].model.terms(Self::finger_coordinates(finger, q)));
        }
        all
    }

    fn inertia(&self, terms: &[Option<Terms<f64>>; FINGERS]) -> Inertia<'_, N, C> {
        Inertia::new(self, map_array(*terms, |terms| terms.map_or([0.0; 3], |terms| terms.mass)))
    }

    /// Inverse of the mass matrix at these coordinates.
    pub(super) fn inverse(&self, q: &[f64; N]) -> Inverse<'_, N, C> {
        self.inertia(&self.terms(q)).inverse()
    }

    /// Evaluates one contact, with point and normal in the palm's frame; `None` where the scene has no such contact.
    ///
    /// The normal of a phalanx points from the object to the phalanx; between two discs it points to the first disc.
    /// The normals of palm and table point out of the disc if there are fingers, and into it otherwise. Slip and
    /// friction are positive along the normal turned counter-clockwise, also for a left phalanx; the signs of mirrored
    /// contacts differ.
    pub fn contact_reading(
        &self,
        q: &[f64; N],
        v: &[f64; N],
        index: usize,
        state: ContactState,
    ) -> Option<ContactReading> {
        let contact = self.contacts.get(index)?.as_ref()?;
        let kinematics = self.contact_kinematics_noinline(q, &|finger| self.finger_kinematics(finger, q), contact);
        let (delta, delta_rate, slip) =
            (-kinematics.gap, -row_dot(&kinematics.normal_row, v), row_dot(&kinematics.tangent_row, v));
        let normal = normal_force_on_branch(&contact.normal, state, delta, delta_rate).force.max(0.0);
        let friction = |law| friction_with_state(law, slip, self.bristle_state(contact, v), normal);
        let tangential = contact.friction.as_ref().map_or(0.0, friction);
        let none = [0.0; 2];
        let (mut sign, [x, y]) = (1.0, kinematics.normal);
        let (point, direction) = match contact.pair {
            ContactPair::Phalanx { finger, .. } => {
                let side = self.fingers[finger].side;
                sign = side.mirror();
                (self.point_in_palm_frame(side, kinematics.point), [sign * x, y])
            }
            ContactPair::Stop { finger } => {
                sign = self.fingers[finger].side.mirror();
                (none, [sign * x, y])
            }
            ContactPair::Discs { .. } => (kinematics.point, kinematics.normal),
            ContactPair::Plane { .. } if !self.shares_contact_point() => (kinematics.point, kinematics.normal),
            ContactPair::Plane { .. } | ContactPair::MovingPlane { .. } => {
                (kinematics.point, map_same_type(kinematics.normal, |component| -component))
            }
        };
        let geometry = Geometry {
            gap: kinematics.gap,
            normal_row: none,
            tangent_row: none,
            normal: direction,
            point,
            support: Support::none(),
        };
        Some(ContactReading { geometry, delta, delta_rate, slip: sign * slip, normal, tangential: sign * tangential })
    }

    /// Angles and rates of a finger's passive joints.
    pub fn passive_joints(&self, finger: usize, q: &[f64; N], v: &[f64; N]) -> PassiveJoints {
        let model = &self.fingers[finger].model;
        let (q, v) = (Self::finger_coordinates(finger, q), Self::finger_coordinates(finger, v));
        let (pose, rates) = model.kinematics(q);
        model.passive_joints(&pose, &rates, q, v)
    }

    /// Energies of a state.
    pub fn energies(&self, q: &[f64; N], v: &[f64; N]) -> Energies {
        let terms = self.terms(q);
        let kinetic = self.inertia(&terms).kinetic(v);
        let mut energies = Energies { elastic: self.bristle_energy(v), kinetic, ..Energies::default() };
        for (component, terms) in self.fingers.iter().zip(terms.iter().flatten()) {
            let [gravity, spring] = component.model.potential_energies(&terms.pose);
            energies.gravity += gravity;
            energies.spring += spring;
        }
        for (index, disc) in self.discs.iter().enumerate().filter(|(_, disc)| disc.first_coordinate < N) {
            let [x, y, _] = self.disc_pose(index, q);
            energies.gravity -= disc.mass * dot(self.gravity, [x, y]);
        }
        let finger_kinematics = |finger: usize| match &terms[finger] {
            Some(terms) => (terms.pose, terms.rates),
            None => self.finger_kinematics(finger, q),
        };
        for contact in self.contacts.iter().flatten() {
            energies.elastic +=
                elastic_energy(&contact.normal, -self.contact_kinematics_noinline(q, &finger_kinematics, contact).gap);
        }
        energies
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
