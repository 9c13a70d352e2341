//! When a gripper carries: from when its palm moves until nothing closes its fingers any more.

use super::{Actuation, Motor, Scene, torque};

/// Times of a cycle, s; `None` of what a scene does not have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cycle {
    /// When the brakes of both fingers have gripped.
    pub blocked_s: [Option<f64>; 2],
    /// When the palm begins to move.
    pub carries_s: Option<f64>,
    /// When what closes the fingers lets go: neither a motor closes nor a brake holds.
    pub releases_s: Option<f64>,
}

impl Scene {
    /// Of a gripper.
    pub fn cycle(&self) -> Cycle {
        let input = self.system.differential.as_ref().map(|differential| &differential.motor);
        let motors: Vec<&Motor> =
            input.into_iter().chain(self.system.fingers.iter().map(|finger| &finger.motor)).collect();
        let gripped = |motor: &Motor| motor.brake.map(|brake| brake.start_s + brake.rise_s);
        let blocked_s = [0, 1].map(|side: usize| gripped(input.unwrap_or(&self.system.fingers[side].motor)));
        let motion = self.system.palm_motion.as_ref();
        let carries_s = motion.map(|motion| motion.starts_s()).filter(|start| *start < self.duration_s);
        let closes = |t: f64| {
            motors.iter().any(|motor| {
                let held =
                    motor.brake.is_some_and(|brake| t >= brake.start_s && brake.release_s.is_none_or(|end| t < end));
                held || torque(&motor.actuation, t).0 > 0.0
            })
        };
        let ends = motors.iter().flat_map(|motor| {
            let release = motor.brake.and_then(|brake| brake.release_s);
            changes(&motor.actuation).into_iter().chain(release)
        });
        let mut ends: Vec<f64> = ends.filter(|end| *end > 0.0 && *end < self.duration_s).collect();
        ends.sort_by(f64::total_cmp);
        let first = ends.iter().position(|end| closes(end.next_down()) && !closes(*end));
        let releases_s = first.map(|index| ends[index]);
        Cycle { blocked_s, carries_s, releases_s }
    }
}

/// Times at which a motor may cease to close.
fn changes(actuation: &Actuation) -> Vec<f64> {
    match actuation {
        Actuation::Constant { .. } | Actuation::Ramp { .. } => Vec::new(),
        Actuation::HalfSine { length_s, .. } => vec![*length_s],
        Actuation::Reversal { at_s, .. } => vec![*at_s],
        Actuation::Table { points, .. } => {
            // Where a straight line crosses 0, and every point.
            let crossings = points.windows(2).filter(|pair| pair[0].1 > 0.0 && pair[1].1 < 0.0).map(|pair| {
                let ((t0, a), (t1, b)) = (pair[0], pair[1]);
                t0 + (t1 - t0) * a / (a - b)
            });
            crossings.chain(points.iter().map(|point| point.0)).collect()
        }
    }
}
