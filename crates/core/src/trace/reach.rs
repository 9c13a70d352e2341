//! Region that the fingers of a gripper can reach. A run ends when its object leaves that region.

use super::{BodyState, Sample};
use crate::numeric::elementary::hypot;
use crate::scene::{Hand, Side};
use crate::shape;

/// Tolerance of the boundary, as a fraction of the largest finger reach.
const BOUNDARY_TOLERANCE: f64 = 1e-9;

/// Discs around both ground joints that contain every point of the phalanges at all joint angles, in the palm frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    pub(crate) joints_m: [[f64; 2]; 2],
    /// Length of both phalanges and half their width.
    pub(crate) radii_m: [f64; 2],
    /// Distance of the outermost point of the object from its centre.
    pub(crate) object_m: f64,
}

impl Reach {
    /// Returns the region that the fingers of a hand can reach; `None` if the scene is not a gripper or its object is
    /// fixed.
    pub fn from_hand(hand: &Hand) -> Option<Self> {
        let object = hand.moving_object().filter(|_| hand.fingers.len() == 2)?;
        let half_m = 0.5 * hand.palm_width_m;
        let radius_m = |side| {
            let lengths = &hand.finger(side).linkage.lengths;
            lengths.l21_m + lengths.t22_m + lengths.half_width_m
        };
        Some(Self {
            joints_m: [[half_m, 0.0], [-half_m, 0.0]],
            radii_m: Side::BOTH.map(radius_m),
            object_m: shape::max_radius(&object.shape),
        })
    }

    /// Returns the distance of the object from the region, m, and its rate, m/s. The distance is negative while a
    /// finger can reach the object.
    pub fn clearance(&self, object: &BodyState) -> (f64, f64) {
        let ([x, y], [vx, vy]) = (object.centre_m, object.velocity_m_s);
        let distance_from = |([jx, jy], radius_m): ([f64; 2], f64)| {
            let (dx, dy) = (x - jx, y - jy);
            let distance_m = hypot(dx, dy);
            let rate_m_s = if distance_m > 0.0 { (dx * vx + dy * vy) / distance_m } else { hypot(vx, vy) };
            (distance_m - radius_m - self.object_m, rate_m_s)
        };
        let [right, left] = [0, 1].map(|side| distance_from((self.joints_m[side], self.radii_m[side])));
        if right.0 < left.0 { right } else { left }
    }

    /// Whether no finger can reach the object.
    pub fn is_outside(&self, object: &BodyState) -> bool {
        self.clearance(object).0 >= -self.boundary_m()
    }

    /// Whether the object leaves the region between two samples.
    pub fn leaves(&self, before: &Sample, after: &Sample) -> bool {
        match (before.bodies().next(), after.bodies().next()) {
            (Some(before), Some(after)) => self.is_outside(&after) && !self.is_outside(&before),
            _ => false,
        }
    }

    /// Returns the time in which an object at constant speed covers half of its distance to the boundary, s, or all of
    /// it when close. Steps that end there locate the boundary although the speed changes.
    #[cfg(feature = "engine")]
    pub(super) fn time_to_exit_s(&self, object: &BodyState) -> f64 {
        /// Fraction of the distance covered by one step, unless the object is close.
        const APPROACH_FRACTION: f64 = 0.5;
        /// Within this distance, as a fraction of the largest reach, one step covers the whole distance.
        const CLOSE_DISTANCE: f64 = 1e-6;
        let (clearance_m, rate_m_s) = self.clearance(object);
        if clearance_m >= 0.0 || rate_m_s <= 0.0 {
            return f64::INFINITY;
        }
        let fraction = if -clearance_m > CLOSE_DISTANCE * self.boundary_m() / BOUNDARY_TOLERANCE {
            APPROACH_FRACTION
        } else {
            1.0
        };
        fraction * -clearance_m / rate_m_s
    }

    fn boundary_m(&self) -> f64 {
        BOUNDARY_TOLERANCE * self.radii_m[0].max(self.radii_m[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REACH: Reach = Reach { joints_m: [[0.015, 0.0], [-0.015, 0.0]], radii_m: [0.04, 0.05], object_m: 0.004 };

    fn body(centre_m: [f64; 2], velocity_m_s: [f64; 2]) -> BodyState {
        BodyState { centre_m, velocity_m_s, ..BodyState::default() }
    }

    #[test]
    fn clearance_is_measured_from_the_nearer_finger() {
        let (clearance_m, rate_m_s) = REACH.clearance(&body([0.115, 0.0], [2.0, 1.0]));
        assert!((clearance_m - (0.1 - 0.044)).abs() < 1e-15 && (rate_m_s - 2.0).abs() < 1e-15);
        let (clearance_m, _) = REACH.clearance(&body([-0.015, 0.06], [0.0, 1.0]));
        assert!((clearance_m - 0.006).abs() < 1e-15, "{clearance_m}");
        assert!(
            REACH.is_outside(&body([-0.015, 0.0541], [0.0; 2])) && !REACH.is_outside(&body([-0.015, 0.0539], [0.0; 2]))
        );
    }

    #[test]
    fn object_leaves_only_from_inside() {
        let sample = |y: f64| Sample::of(0.0, &[], &[body([0.0, y], [0.0; 2])], &[]);
        assert!(REACH.leaves(&sample(0.02), &sample(0.1)));
        assert!(!REACH.leaves(&sample(0.1), &sample(0.2)) && !REACH.leaves(&sample(0.1), &sample(0.02)));
        assert!(!REACH.leaves(&Sample::default(), &sample(0.2)));
    }

    #[cfg(feature = "engine")]
    #[test]
    fn steps_to_the_exit_locate_the_boundary_for_an_accelerated_object() {
        let (mut y, mut speed, acceleration) = (0.05, 0.1, 320.0);
        for _ in 0..1000 {
            let object = body([-0.015, y], [0.0, speed]);
            if REACH.is_outside(&object) {
                break;
            }
            let dt = REACH.time_to_exit_s(&object).min(1e-4);
            (y, speed) = (y + dt * (speed + 0.5 * dt * acceleration), speed + dt * acceleration);
        }
        assert!((y - 0.054).abs() < 1e-9, "{y}");
        assert_eq!(REACH.time_to_exit_s(&body([-0.015, 0.05], [0.0, -1.0])), f64::INFINITY);
    }
}
