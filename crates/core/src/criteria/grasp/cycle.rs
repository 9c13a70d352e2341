//! Largest travel of the object, and the cycle of a grasp: motion of the palm, brakes, release.

use super::pose::RelativePose;
use crate::criteria::segments::Segment;
use crate::mechanism::Mechanism;
use crate::numeric::elementary::hypot;
use crate::trace::Sample;
use serde::Serialize;

/// Approximate number of evaluations of the travel per run, and maximum number between two samples: steps of a smooth
/// motion are long.
const TRAVELS_PER_RUN: f64 = 256.0;
const MAX_TRAVELS_PER_SEGMENT: f64 = 7.0;

/// Largest travel of the object from a pose in the frame of the base. It is evaluated at samples and at changes of
/// contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Travel {
    /// Largest displacement of the centre of mass, m.
    pub displacement_m: f64,
    /// Largest rotation in either direction, rad.
    pub rotation_rad: f64,
}

/// Criteria of a cycle, which consists of the motion of the palm and the release.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CycleCriteria {
    /// Time at which the palm begins to move, s; `None` if it does not move.
    pub motion_start_s: Option<f64>,
    /// Time at which the hand releases the object, s; `None` without a release. In a five-bar hand, it is the time at
    /// which the motors stop closing the fingers.
    pub release_s: Option<f64>,
    /// Travel of the object in the hand from `motion_start_s` to `release_s`, or to the end of the run.
    pub motion_travel: Option<Travel>,
    /// Time after the release since which no body of the hand except the base is in active contact with the object, s.
    /// `None` without a release, or if such a body is active at the end.
    pub opened_s: Option<f64>,
    /// Largest rotation of each revolute joint with an actuator between the engagement of its brake and the release,
    /// rad. The order is that of the actuators; `None` without a brake that engages.
    pub brake_slip_rad: Vec<Option<f64>>,
}

/// Pose of the object at an instant, and its largest travel since.
#[derive(Clone, Copy, Debug)]
struct TravelSince {
    pose: RelativePose,
    travel: Travel,
}

impl TravelSince {
    fn new(pose: RelativePose) -> Self {
        TravelSince { pose, travel: Travel::default() }
    }

    /// Extends the travel to a later pose.
    fn extend(&mut self, pose: RelativePose) {
        let [dx, dy, turn] = [0, 1, 2].map(|k: usize| pose[k] - self.pose[k]);
        self.travel.displacement_m = self.travel.displacement_m.max(hypot(dx, dy));
        self.travel.rotation_rad = self.travel.rotation_rad.max(turn.abs());
    }
}

/// A joint with an actuator.
#[derive(Clone, Copy, Debug)]
struct DrivenJoint {
    joint: usize,
    /// Time at which the brake is fully engaged.
    engaged_s: Option<f64>,
    /// Its angle then, and the largest rotation since, rad.
    slip: Option<(f64, f64)>,
}

/// Travel and cycle up to the present.
#[derive(Clone, Debug)]
pub(super) struct CycleHistory {
    motion_start_s: Option<f64>,
    release_s: Option<f64>,
    travel_interval_s: f64,
    driven: Vec<DrivenJoint>,
    since_start: Option<TravelSince>,
    since_motion: Option<TravelSince>,
    opened_s: Option<f64>,
}

impl CycleHistory {
    pub fn new(mechanism: &Mechanism, release_s: Option<f64>, duration_s: f64) -> Self {
        let mut driven: Vec<DrivenJoint> = Vec::new();
        for actuator in &mechanism.actuators {
            let engaged_s = actuator.brake.map(|brake| brake.start_s + brake.rise_s);
            let is_angle = |joint: &usize| mechanism.joints[*joint].kind.is_angle();
            for joint in actuator.on.terms.iter().map(|(joint, _)| *joint).filter(is_angle) {
                match driven.iter_mut().find(|known| known.joint == joint) {
                    Some(known) => known.engaged_s = known.engaged_s.or(engaged_s),
                    None => driven.push(DrivenJoint { joint, engaged_s, slip: None }),
                }
            }
        }
        let motion_start_s = mechanism.palm().map(|(_, motion)| motion.start_s());
        CycleHistory {
            motion_start_s: motion_start_s.filter(|start_s| *start_s < duration_s),
            release_s,
            travel_interval_s: duration_s / TRAVELS_PER_RUN,
            driven,
            since_start: None,
            since_motion: None,
            opened_s: None,
        }
    }

    /// Sets the time from which on the travel during the motion of the palm is measured.
    pub fn set_motion_start(&mut self, start_s: f64) {
        self.motion_start_s = Some(start_s);
    }

    /// Times that divide the evaluation into parts.
    pub fn cuts_s(&self) -> impl Iterator<Item = f64> {
        [self.motion_start_s, self.release_s].into_iter().flatten()
    }

    pub fn begin(&mut self, pose: RelativePose) {
        self.since_start = Some(TravelSince::new(pose));
    }

    /// Adds a segment of the run; `pose` returns the pose of the object as a function of time.
    pub fn add(&mut self, segment: &Segment<'_>, pose: impl Fn(f64) -> RelativePose, is_open: bool) {
        let Segment { from_s, to_s, next, .. } = *segment;
        if self.release_s.is_some_and(|release_s| from_s >= release_s) {
            self.since_start.iter_mut().for_each(|since| since.extend(pose(to_s)));
            self.opened_s = if is_open { self.opened_s.or(Some(from_s)) } else { None };
            return;
        }
        if self.motion_start_s.is_some_and(|start_s| from_s >= start_s) {
            self.since_motion.get_or_insert_with(|| TravelSince::new(pose(from_s)));
        }
        let length_s = to_s - from_s;
        let inner = (length_s / self.travel_interval_s).min(MAX_TRAVELS_PER_SEGMENT) as u32;
        for k in 1..=inner + 1 {
            let time_s = if k > inner { to_s } else { from_s + length_s * f64::from(k) / f64::from(inner + 1) };
            let pose = pose(time_s);
            self.since_start.iter_mut().chain(&mut self.since_motion).for_each(|since| since.extend(pose));
        }
        for driven in self.driven.iter_mut().filter(|driven| driven.engaged_s.is_some_and(|start_s| to_s >= start_s)) {
            let angle_rad = next.joint_state(driven.joint).angle_rad;
            let (first, largest) = driven.slip.get_or_insert((angle_rad, 0.0));
            *largest = largest.max((angle_rad - *first).abs());
        }
    }

    /// Largest travel since the start.
    pub fn travel(&self) -> Travel {
        self.since_start.map_or_else(Travel::default, |since| since.travel)
    }

    /// Returns the criteria of a run that ended with a sample.
    pub fn criteria(&self, end: &Sample) -> CycleCriteria {
        // A run can end before these times, for example when the object is ejected.
        let reached = |time_s: &f64| *time_s <= end.time_s;
        CycleCriteria {
            motion_start_s: self.motion_start_s.filter(reached),
            release_s: self.release_s.filter(reached),
            motion_travel: self.since_motion.map(|since| since.travel),
            opened_s: self.opened_s,
            brake_slip_rad: self.driven.iter().map(|driven| driven.slip.map(|(_, largest)| largest)).collect(),
        }
    }
}
