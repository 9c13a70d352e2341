//! Times of a grasp cycle of a gripper: the fingers are blocked, the palm moves, the fingers open.

use super::{Actuation, Motor, Scene, torque};

/// Times of a grasp cycle, s; `None` for phases that the scene does not have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cycle {
    /// Time at which the brake of each finger is fully engaged.
    pub blocked_s: [Option<f64>; 2],
    /// Time at which the palm begins to move.
    pub motion_start_s: Option<f64>,
    /// Time from which no motor closes and no brake is engaged.
    pub release_s: Option<f64>,
}

impl Scene {
    /// Returns the grasp cycle of a gripper.
    pub fn cycle(&self) -> Cycle {
        let input = self.system.differential.as_ref().map(|differential| &differential.motor);
        let motors: Vec<&Motor> =
            input.into_iter().chain(self.system.fingers.iter().map(|finger| &finger.motor)).collect();
        let engaged_s = |motor: &Motor| motor.brake.map(|brake| brake.start_s + brake.rise_s);
        let blocked_s = [0, 1].map(|side: usize| engaged_s(input.unwrap_or(&self.system.fingers[side].motor)));
        let motion = self.system.palm_motion.as_ref();
        let motion_start_s = motion.map(|motion| motion.start_s()).filter(|start| *start < self.duration_s);
        let closes = |t: f64| {
            motors.iter().any(|motor| {
                let is_braked =
                    motor.brake.is_some_and(|brake| t >= brake.start_s && brake.release_s.is_none_or(|end| t < end));
                is_braked || torque(&motor.actuation, t).0 > 0.0
            })
        };
        let candidates = motors.iter().flat_map(|motor| {
            let release = motor.brake.and_then(|brake| brake.release_s);
            closing_end_candidates(&motor.actuation).into_iter().chain(release)
        });
        let mut candidates: Vec<f64> = candidates.filter(|end| *end > 0.0 && *end < self.duration_s).collect();
        candidates.sort_by(f64::total_cmp);
        let first = candidates.iter().position(|end| closes(end.next_down()) && !closes(*end));
        let release_s = first.map(|index| candidates[index]);
        Cycle { blocked_s, motion_start_s, release_s }
    }
}

/// Times at which a motor torque may stop closing the finger.
fn closing_end_candidates(actuation: &Actuation) -> Vec<f64> {
    match actuation {
        Actuation::Constant { .. } | Actuation::Ramp { .. } => Vec::new(),
        Actuation::HalfSine { length_s, .. } => vec![*length_s],
        Actuation::Reversal { at_s, .. } => vec![*at_s],
        Actuation::Table { points, .. } => {
            // The zeros of linear interpolation, and all points.
            let crossings = points.windows(2).filter(|pair| pair[0].1 > 0.0 && pair[1].1 < 0.0).map(|pair| {
                let ((t0, a), (t1, b)) = (pair[0], pair[1]);
                t0 + (t1 - t0) * a / (a - b)
            });
            crossings.chain(points.iter().map(|point| point.0)).collect()
        }
    }
}
