//! When an object has left its hand, which ends a run: it is outside the region that the fingers of a gripper can reach, or its
//! gaps to the hand of a mechanism with a section `[grasp]` exceed its extent.

use super::{BodyState, Sample};
use crate::numeric::elementary::hypot;
use crate::scene::{Hand, Scene, Side};
use crate::shape;

/// Condition that decides whether an object has left its hand.
#[derive(Clone, Debug, PartialEq)]
pub enum Exit {
    Reach(Reach),
    Gaps(GapExit),
}

/// Contacts of an object of a mechanism. The object has left the hand when all gaps to the hand exceed its extent, the
/// smallest of them grows, and nothing else presses on the object.
#[derive(Clone, Debug, PartialEq)]
pub struct GapExit {
    hand: Vec<usize>,
    surroundings: Vec<usize>,
    extent_m: f64,
}

impl Exit {
    /// Returns the condition that ends runs of a scene; `None` if nothing ends them early.
    pub fn from_scene(scene: &Scene) -> Option<Self> {
        let Some(roles) = scene.grasp.as_ref().and_then(|_| scene.grasp_roles().ok()) else {
            return Reach::from_hand(&scene.hand).map(Exit::Reach);
        };
        let points = |is_hand: bool| {
            let pairs = roles.pairs.iter().filter(move |pair| pair.is_hand == is_hand);
            pairs.flat_map(|pair| pair.points.iter().copied()).collect()
        };
        Some(Exit::Gaps(GapExit { hand: points(true), surroundings: points(false), extent_m: 2.0 * roles.radius_m }))
    }

    /// Whether a touch of this contact of a sample is one of the hand, which has to precede the exit.
    pub(super) fn counts(&self, contact: usize, sample: &Sample) -> bool {
        match self {
            Exit::Reach(_) => !sample.is_stop(contact),
            Exit::Gaps(gaps) => gaps.hand.contains(&contact),
        }
    }

    /// Whether the object has left the hand in a sample.
    pub fn is_outside(&self, sample: &Sample) -> bool {
        match self {
            Exit::Reach(reach) => sample.bodies().next().is_some_and(|object| reach.is_outside(&object)),
            Exit::Gaps(gaps) => gaps.is_outside(sample),
        }
    }

    /// Whether the object leaves the hand between two samples.
    pub fn leaves(&self, before: &Sample, after: &Sample) -> bool {
        match self {
            Exit::Reach(reach) => reach.leaves(before, after),
            Exit::Gaps(gaps) => gaps.is_outside(after) && !gaps.is_outside(before),
        }
    }

    /// Upper bound of the next step, s, so that steps locate the exit.
    #[cfg(feature = "engine")]
    pub(super) fn time_to_exit_s(&self, sample: &Sample) -> f64 {
        match self {
            Exit::Reach(reach) => sample.bodies().next().map_or(f64::INFINITY, |object| reach.time_to_exit_s(&object)),
            Exit::Gaps(gaps) => gaps.nearest(sample).map_or(f64::INFINITY, |(gap_m, rate_m_s)| {
                time_to_boundary_s((gap_m - gaps.extent_m, rate_m_s), gaps.extent_m)
            }),
        }
    }
}

impl GapExit {
    /// Smallest gap to the hand, and its rate.
    fn nearest(&self, sample: &Sample) -> Option<(f64, f64)> {
        let contacts = self.hand.iter().map(|index| sample.contact(*index));
        contacts.map(|contact| (contact.gap_m, contact.gap_rate_m_s)).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn is_outside(&self, sample: &Sample) -> bool {
        let leaves =
            |(gap_m, rate_m_s): (f64, f64)| gap_m >= (1.0 - BOUNDARY_TOLERANCE) * self.extent_m && rate_m_s >= 0.0;
        self.nearest(sample).is_some_and(leaves)
            && self.surroundings.iter().all(|index| sample.contact(*index).normal_n == 0.0)
    }
}

/// Returns the time in which half of a distance to a boundary is covered at constant speed, s, or all of it when close. Steps
/// that end there locate the boundary although the speed changes. The distance is negative before the boundary.
#[cfg(feature = "engine")]
fn time_to_boundary_s((clearance_m, rate_m_s): (f64, f64), size_m: f64) -> f64 {
    /// Fraction of the distance covered by one step, unless it is close.
    const APPROACH_FRACTION: f64 = 0.5;
    /// Within this distance, as a fraction of the size, one step covers the whole distance.
    const CLOSE_DISTANCE: f64 = 1e-6;
    if clearance_m >= 0.0 || rate_m_s <= 0.0 {
        return f64::INFINITY;
    }
    let fraction = if -clearance_m > CLOSE_DISTANCE * size_m { APPROACH_FRACTION } else { 1.0 };
    fraction * -clearance_m / rate_m_s
}

/// Tolerance of the boundary, as a fraction of the largest finger reach or of the extent of the object.
pub(crate) const BOUNDARY_TOLERANCE: f64 = 1e-9;

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

    /// Returns the distance of the object from the region, m, and the rate of this distance, m/s. The distance is
    /// negative while a finger can reach the object.
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

    /// Upper bound of the next step, s, so that steps locate the boundary.
    #[cfg(feature = "engine")]
    pub(super) fn time_to_exit_s(&self, object: &BodyState) -> f64 {
        time_to_boundary_s(self.clearance(object), self.boundary_m() / BOUNDARY_TOLERANCE)
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
