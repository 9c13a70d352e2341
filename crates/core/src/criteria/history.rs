//! One contact of a gripper through its run, and how far the object has got since an instant.

use super::grasp::Travel;
use crate::numeric::elementary::hypot;

/// An instant, where the object was, and how far it has got since.
#[derive(Clone, Copy, Debug)]
pub struct Onset {
    pub time_s: f64,
    pub pose: Pose,
    pub travel: Travel,
}

#[derive(Clone, Copy, Debug)]
pub struct Pose {
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
}

impl Pose {
    pub fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        hypot(self.centre_m[0] - x, self.centre_m[1] - y)
    }
}

impl Onset {
    pub fn new(time_s: f64, pose: Pose) -> Self {
        Onset { time_s, pose, travel: Travel::default() }
    }

    pub fn reach(&mut self, pose: &Pose) {
        let Travel { displacement_m, rotation_rad } = &mut self.travel;
        *displacement_m = displacement_m.max(pose.distance(self.pose.centre_m));
        *rotation_rad = rotation_rad.max((pose.angle_rad - self.pose.angle_rad).abs());
    }
}

/// One contact.
#[derive(Clone, Copy, Debug, Default)]
pub struct History {
    pub first_touch_s: Option<f64>,
    /// Since it presses without a loss that counts. Which contact of those that press at the end is the last is known only then, so that every one
    /// watches how far the object goes.
    pub presses: Option<Onset>,
    has_pressed: bool,
    /// Since when it does not press, although it did. While this is shorter than what counts as a loss, [`History::presses`] stays.
    pub lost_from_s: Option<f64>,
    pub times_lost: u32,
    pub lost_s: f64,
}

impl History {
    /// Takes a piece of the run; a loss that lasts less than `loss_time_s` does not count.
    pub fn judge(
        &mut self,
        (touched, pressing): (bool, bool),
        [from_s, to_s]: [f64; 2],
        [from, to]: &[Pose; 2],
        loss_time_s: f64,
    ) {
        if touched {
            self.first_touch_s.get_or_insert(from_s);
        }
        if pressing {
            (self.has_pressed, self.lost_from_s) = (true, None);
            self.presses.get_or_insert(Onset::new(from_s, *from)).reach(to);
        } else if self.has_pressed {
            let lost_from_s = *self.lost_from_s.get_or_insert(from_s);
            match &mut self.presses {
                Some(onset) if to_s - lost_from_s < loss_time_s => onset.reach(to),
                Some(_) => {
                    self.presses = None;
                    self.times_lost += 1;
                    self.lost_s += to_s - lost_from_s;
                }
                None => self.lost_s += to_s - from_s,
            }
        }
    }
}
