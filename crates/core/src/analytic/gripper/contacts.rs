//! Contacts in one state, with plain numbers.

use super::coordinates::{Where, of_finger, of_object, of_object_in_time, of_phalanx, scatter};
use super::frame;
use super::model::GripperModel;
use super::touch::{self, Touch};
use crate::analytic::finger::FingerModel;
use crate::fivebar::kinematics::{Directions, PassiveRates};
use crate::gripper::Site;
use crate::numeric::Real;
use crate::numeric::plane::Vector;
use crate::scene::{Place, Side};

/// Pose of a finger with its passive rates.
pub type Posture = (Directions<f64>, PassiveRates<f64>);

impl<const N: usize> GripperModel<N> {
    /// Pose of a finger with its passive rates.
    #[inline(always)]
    pub(super) fn posture(&self, side: Side, q: &[f64; N]) -> Posture {
        self.fingers[side as usize].place(Self::own(side, q))
    }

    /// Those of both.
    #[inline(always)]
    pub(super) fn postures(&self, q: &[f64; N]) -> [Posture; 2] {
        Side::BOTH.map(|side| self.posture(side, q))
    }

    /// Where a phalanx touches the object, whose centre is given in the finger's frame.
    #[inline(always)]
    pub(super) fn phalanx<T: Real>(
        &self,
        finger: &FingerModel,
        (pose, rates): (&Directions<T>, &PassiveRates<T>),
        site: Site,
        centre: Vector<T>,
    ) -> Touch<T, 5> {
        let radius = self.object.radius;
        touch::phalanx(&finger.phalanx(pose, rates, site, (centre, radius)), radius)
    }

    /// A contact at any place, its rows among all coordinates; `None` where the scene has no such contact.
    #[inline(always)]
    pub(super) fn touch(
        &self,
        q: &[f64; N],
        posture: impl FnOnce(Side) -> Posture,
        place: Place,
    ) -> Option<Touch<f64, N>> {
        self.normal_law(place)?;
        let [x, y, _] = self.object_of(q);
        match place {
            Place::Finger(side, site) => {
                let (finger, (pose, rates)) = (&self.fingers[side as usize], posture(side));
                if site == Site::Limit {
                    return Some(spread(&touch::limit(&finger.limit_geometry(&pose, &rates)), &of_finger(side)));
                }
                let centre = self.in_finger(side, [x, y]);
                Some(spread(&self.phalanx(finger, (&pose, &rates), site, centre), &of_phalanx(side)))
            }
            Place::Table if Self::MOVES => {
                let touch = frame::table(self.plane(place)?, &self.pose(q), 0.0, [x, y], self.object.radius);
                Some(spread(&touch, &of_object_in_time()))
            }
            Place::Palm | Place::Table => {
                let touch = touch::plane(self.plane(place)?, [x, y], self.object.radius);
                Some(spread(&touch, &of_object(1.0)))
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
