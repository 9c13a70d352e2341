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
    /// Since it presses without a break. Which contact of those that press at the end is the last is known only then, so that every one
    /// watches how far the object goes.
    pub presses: Option<Onset>,
    has_pressed: bool,
    pub times_lost: u32,
    pub lost_s: f64,
}

impl History {
    pub fn judge(&mut self, (touched, pressing): (bool, bool), [from_s, to_s]: [f64; 2], [from, to]: &[Pose; 2]) {
        if touched {
            self.first_touch_s.get_or_insert(from_s);
        }
        if pressing {
            self.has_pressed = true;
            self.presses.get_or_insert(Onset::new(from_s, *from)).reach(to);
        } else if self.has_pressed {
            self.times_lost += u32::from(self.presses.take().is_some());
            self.lost_s += to_s - from_s;
        }
    }
}
