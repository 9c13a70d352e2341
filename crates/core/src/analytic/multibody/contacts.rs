//! Contacts in one state, with plain numbers.

use super::FINGERS;
use super::coordinates::{Where, of_disc, of_disc_in_time, of_discs, of_finger, of_phalanx, scatter};
use super::frame;
use super::model::Multibody;
use super::parts::{Joined, Meet};
use super::touch::{self, Touch};
use crate::fivebar::kinematics::{Directions, PassiveRates};

/// Pose of a finger with its passive rates.
pub type Posture = (Directions<f64>, PassiveRates<f64>);

/// That of a finger which is not there.
const NONE: Posture = {
    let none = [0.0; 2];
    (Directions { e1: none, e2: none, e3: none, e4: none }, PassiveRates { a3: none, a4: none, inverse_sine: 0.0 })
};

impl<const N: usize, const C: usize> Multibody<N, C> {
    /// Pose of a finger with its passive rates.
    #[inline(always)]
    pub(super) fn posture(&self, finger: usize, q: &[f64; N]) -> Posture {
        self.fingers[finger].model.place(Self::own(finger, q))
    }

    /// Those of all that there are, of others anything.
    #[inline(always)]
    pub(super) fn postures(&self, q: &[f64; N]) -> [Posture; FINGERS] {
        let mut postures = [NONE; FINGERS];
        for (finger, posture) in postures.iter_mut().enumerate().take(self.count()) {
            *posture = self.posture(finger, q);
        }
        postures
    }

    /// A contact, its rows among all coordinates. Compiled once for all who ask now and then.
    #[inline(never)]
    pub(super) fn touch_apart(
        &self,
        q: &[f64; N],
        posture: &dyn Fn(usize) -> Posture,
        contact: &Joined,
    ) -> Touch<f64, N> {
        self.touch(q, posture, contact)
    }

    /// The same.
    #[inline(always)]
    pub(super) fn touch(
        &self,
        q: &[f64; N],
        posture: impl FnOnce(usize) -> Posture,
        contact: &Joined,
    ) -> Touch<f64, N> {
        match contact.meet {
            Meet::Phalanx { .. } | Meet::Stop { .. } if Self::DISCS => unreachable!("there are no fingers"),
            Meet::Phalanx { finger, site, disc } => {
                let part = &self.fingers[finger];
                let ((pose, rates), mirror) = (posture(finger), part.side.mirror());
                let geometry = part.model.phalanx(&pose, &rates, site, &self.in_finger(part.side, disc, q));
                spread(&touch::phalanx(&geometry), &of_phalanx(finger, self.first_of(disc), mirror))
            }
            Meet::Stop { finger } => {
                let (pose, rates) = posture(finger);
                spread(&touch::limit(&self.fingers[finger].model.limit_geometry(&pose, &rates)), &of_finger(finger))
            }
            Meet::Discs { disc, other } => {
                let touch = touch::discs([&self.placed(disc, q), &self.placed(other, q)]);
                spread(&touch, &of_discs([self.first_of(disc), self.first_of(other)]))
            }
            Meet::Plane { disc, plane } => {
                let touch = touch::plane(&plane, &self.placed(disc, q), self.meets_in_one_point());
                spread(&touch, &of_disc(self.first_of(disc)))
            }
            Meet::PassingPlane { disc, plane } => {
                let touch = frame::table(&plane, &self.pose(q), 0.0, &self.placed(disc, q));
                spread(&touch, &of_disc_in_time(self.first_of(disc), self.time.unwrap_or(N)))
            }
        }
    }
}

/// Rows of a part as rows of all coordinates.
#[inline(always)]
fn spread<const N: usize, const K: usize>(touch: &Touch<f64, K>, at: &[Where; K]) -> Touch<f64, N> {
    let row = |part: &[f64; K]| {
        let mut row = [0.0; N];
        scatter(&mut row, at, part);
        row
    };
    let (normal_row, tangent_row) = (row(&touch.normal_row), row(&touch.tangent_row));
    Touch { gap: touch.gap, normal_row, tangent_row, normal: touch.normal, point: touch.point }
}
