//! The region that the fingers of a gripper can reach. A run ends where its object leaves that region.

use super::{BodyState, Sample};
use crate::numeric::elementary::hypot;
use crate::scene::{Side, System};
use crate::shape;

/// Part of the largest reach of a finger below which a distance from the region counts as zero.
const ON_BOUNDARY: f64 = 1e-9;

/// The discs around both ground joints that no point of a phalanx leaves, whatever the joint angles. In the palm's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    pub(crate) joints_m: [[f64; 2]; 2],
    /// Length of both phalanges and half their width.
    pub(crate) radii_m: [f64; 2],
    /// Distance of the outermost point of the object from its centre.
    pub(crate) object_m: f64,
}

impl Reach {
    /// `None` where an object cannot leave: the scene is no gripper, or its object is fixed.
    pub fn of(system: &System) -> Option<Self> {
        let object = system.moving_object().filter(|_| system.fingers.len() == 2)?;
        let half_m = 0.5 * system.palm_width_m;
        let radius_m = |side| {
            let lengths = &system.finger(side).linkage.lengths;
            lengths.l21_m + lengths.t22_m + lengths.half_width_m
        };
        Some(Self {
            joints_m: [[half_m, 0.0], [-half_m, 0.0]],
            radii_m: Side::BOTH.map(radius_m),
            object_m: shape::reach(&object.shape),
        })
    }

    /// Distance of the object from the region, m, and its rate, m/s: negative while a finger can reach the object.
    pub fn clearance(&self, object: &BodyState) -> (f64, f64) {
        let ([x, y], [vx, vy]) = (object.centre_m, object.velocity_m_s);
        let from = |([jx, jy], radius_m): ([f64; 2], f64)| {
            let (dx, dy) = (x - jx, y - jy);
            let distance_m = hypot(dx, dy);
            let rate_m_s = if distance_m > 0.0 { (dx * vx + dy * vy) / distance_m } else { hypot(vx, vy) };
            (distance_m - radius_m - self.object_m, rate_m_s)
        };
        let [right, left] = [0, 1].map(|side| from((self.joints_m[side], self.radii_m[side])));
        if right.0 < left.0 { right } else { left }
    }

    /// Whether no finger can reach the object.
    pub fn is_outside(&self, object: &BodyState) -> bool {
        self.clearance(object).0 >= -self.boundary_m()
    }

    /// Whether the object leaves the region between two samples.
    pub fn leaves(&self, before: &Sample, after: &Sample) -> bool {
        match (before.bodies.first(), after.bodies.first()) {
            (Some(before), Some(after)) => self.is_outside(after) && !self.is_outside(before),
            _ => false,
        }
    }

    /// Time in which an object that keeps its speed covers half of its distance from the boundary, s, or all of it from close by. Steps that
    /// end there land on the boundary although its speed changes.
    #[cfg(feature = "engine")]
    pub(super) fn exit_in_s(&self, object: &BodyState) -> f64 {
        /// Part of the way that a step from further away goes.
        const PART: f64 = 0.5;
        /// Distance, in parts of the largest reach, from which a step goes all the way.
        const CLOSE: f64 = 1e-6;
        let (clearance_m, rate_m_s) = self.clearance(object);
        if clearance_m >= 0.0 || rate_m_s <= 0.0 {
            return f64::INFINITY;
        }
        let part = if -clearance_m > CLOSE * self.boundary_m() / ON_BOUNDARY { PART } else { 1.0 };
        part * -clearance_m / rate_m_s
    }

    fn boundary_m(&self) -> f64 {
        ON_BOUNDARY * self.radii_m[0].max(self.radii_m[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REACH: Reach = Reach { joints_m: [[0.015, 0.0], [-0.015, 0.0]], radii_m: [0.04, 0.05], object_m: 0.004 };

    fn at(centre_m: [f64; 2], velocity_m_s: [f64; 2]) -> BodyState {
        BodyState { centre_m, velocity_m_s, ..BodyState::default() }
    }

    #[test]
    fn the_clearance_is_that_from_the_nearer_of_both_fingers() {
        let (clearance_m, rate_m_s) = REACH.clearance(&at([0.115, 0.0], [2.0, 1.0]));
        assert!((clearance_m - (0.1 - 0.044)).abs() < 1e-15 && (rate_m_s - 2.0).abs() < 1e-15);
        let (clearance_m, _) = REACH.clearance(&at([-0.015, 0.06], [0.0, 1.0]));
        assert!((clearance_m - 0.006).abs() < 1e-15, "{clearance_m}");
        assert!(
            REACH.is_outside(&at([-0.015, 0.0541], [0.0; 2])) && !REACH.is_outside(&at([-0.015, 0.0539], [0.0; 2]))
        );
    }

    #[test]
    fn an_object_leaves_only_from_within() {
        let sample = |y: f64| Sample { bodies: vec![at([0.0, y], [0.0; 2])], ..Sample::default() };
        assert!(REACH.leaves(&sample(0.02), &sample(0.1)));
        assert!(!REACH.leaves(&sample(0.1), &sample(0.2)) && !REACH.leaves(&sample(0.1), &sample(0.02)));
        assert!(!REACH.leaves(&Sample::default(), &sample(0.2)));
    }

    #[cfg(feature = "engine")]
    #[test]
    fn steps_to_the_exit_land_on_the_boundary_of_an_accelerated_object() {
        let (mut y, mut speed, acceleration) = (0.05, 0.1, 320.0);
        for _ in 0..1000 {
            let object = at([-0.015, y], [0.0, speed]);
            if REACH.is_outside(&object) {
                break;
            }
            let dt = REACH.exit_in_s(&object).min(1e-4);
            (y, speed) = (y + dt * (speed + 0.5 * dt * acceleration), speed + dt * acceleration);
        }
        assert!((y - 0.054).abs() < 1e-9, "{y}");
        assert_eq!(REACH.exit_in_s(&at([-0.015, 0.05], [0.0, -1.0])), f64::INFINITY);
    }
}
