//! History of one contact of a gripper over a run, and travel of the object since an instant.

use super::grasp::Travel;
use crate::numeric::elementary::hypot;

/// Pose of the object at an instant, and its largest travel since.
#[derive(Clone, Copy, Debug)]
pub struct TravelSince {
    pub time_s: f64,
    pub pose: Pose,
    pub travel: Travel,
}

/// Pose of the object.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
}

impl Pose {
    /// Returns the distance of the centre from a point, m.
    pub fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        hypot(self.centre_m[0] - x, self.centre_m[1] - y)
    }
}

impl TravelSince {
    pub fn new(time_s: f64, pose: Pose) -> Self {
        TravelSince { time_s, pose, travel: Travel::default() }
    }

    /// Extends the travel to a later pose.
    pub fn update_travel(&mut self, pose: &Pose) {
        let Travel { displacement_m, rotation_rad } = &mut self.travel;
        *displacement_m = displacement_m.max(pose.distance(self.pose.centre_m));
        *rotation_rad = rotation_rad.max((pose.angle_rad - self.pose.angle_rad).abs());
    }
}

/// History of one contact up to the present.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactHistory {
    pub first_contact_s: Option<f64>,
    /// Start of the current active interval, and the travel since; short losses do not end the interval. Each contact
    /// records its own travel, because the contact that became active last is known only at the end of the run.
    pub active_since: Option<TravelSince>,
    was_active: bool,
    /// Start of the current loss. While the loss is shorter than the threshold, [`ContactHistory::active_since`] is
    /// kept.
    pub inactive_since_s: Option<f64>,
    pub times_lost: u32,
    pub lost_s: f64,
}

impl ContactHistory {
    /// Adds a segment of the run. A loss shorter than `loss_time_s` does not count.
    pub fn update(
        &mut self,
        (has_touched, is_active): (bool, bool),
        [from_s, to_s]: [f64; 2],
        [from, to]: &[Pose; 2],
        loss_time_s: f64,
    ) {
        if has_touched {
            self.first_contact_s.get_or_insert(from_s);
        }
        if is_active {
            (self.was_active, self.inactive_since_s) = (true, None);
            self.active_since.get_or_insert(TravelSince::new(from_s, *from)).update_travel(to);
        } else if self.was_active {
            let inactive_since_s = *self.inactive_since_s.get_or_insert(from_s);
            match &mut self.active_since {
                Some(since) if to_s - inactive_since_s < loss_time_s => since.update_travel(to),
                Some(_) => {
                    self.active_since = None;
                    self.times_lost += 1;
                    self.lost_s += to_s - inactive_since_s;
                }
                None => self.lost_s += to_s - from_s,
            }
        }
    }
}
