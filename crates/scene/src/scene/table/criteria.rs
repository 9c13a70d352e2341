//! `[criteria]`: thresholds for a loss of contact and for a held object.

use super::settings;
use crate::scene::check::NOT_NEGATIVE;
use crate::scene::keywords::TWO_FINGERS;
use crate::scene::value_kinds::{Force, Time};

/// Thresholds of the grasp criteria of a gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// Shortest duration of a loss of contact, s.
    pub loss_time_s: f64,
    /// Largest normal force of a lost contact, N.
    pub loss_force_n: f64,
    /// Shortest time for which an object must be held to count as held, s.
    pub held_time_s: f64,
}

/// Default of [`Thresholds::loss_time_s`] in runs of at least 20 ms, s.
const LOSS_TIME_S: f64 = 1e-4;
/// Default of [`Thresholds::loss_time_s`] in shorter runs, as a fraction of the duration.
const LOSS_TIME_FRACTION: f64 = 0.005;
/// Default of [`Thresholds::held_time_s`] as a multiple of the loss time.
const HELD_TIME_IN_LOSS_TIMES: f64 = 10.0;
/// Default of [`Thresholds::loss_force_n`] as a fraction of the largest motor torque over the length of the proximal
/// phalanx.
const LOSS_FORCE_FRACTION: f64 = 1e-4;

impl Thresholds {
    /// No thresholds, for scenes without a gripper: every loss of contact counts, and an object is held at once.
    pub const NONE: Self = Self { loss_time_s: 0.0, loss_force_n: 0.0, held_time_s: 0.0 };

    /// Defaults for a run of this duration; `motor_force_n` is the largest motor torque over the length of the proximal
    /// phalanx.
    pub fn defaults_for_run(duration_s: f64, motor_force_n: f64) -> Self {
        let loss_time_s = LOSS_TIME_S.min(LOSS_TIME_FRACTION * duration_s);
        Self {
            loss_time_s,
            loss_force_n: LOSS_FORCE_FRACTION * motor_force_n,
            held_time_s: HELD_TIME_IN_LOSS_TIMES * loss_time_s,
        }
    }
}

settings! {
    /// Thresholds for a lost contact and a held object. A single finger follows the thesis instead, where every loss of
    /// contact counts.
    Thresholds = Self { loss_time_s: f64::NAN, loss_force_n: f64::NAN, held_time_s: f64::NAN }, t;
    /// Shortest loss of contact: a contact is lost if its force is at or below `loss_force` for at least this time.
    /// Default: 0.1 ms, and at most 0.005 of the duration.
    "loss_time": Time = Some(&mut t.loss_time_s), allowed(NOT_NEGATIVE), only_in(TWO_FINGERS);
    /// Largest normal force of a lost contact. Default: 1e-4 of the largest motor torque over the length of the
    /// proximal phalanx.
    "loss_force": Force = Some(&mut t.loss_force_n), allowed(NOT_NEGATIVE), only_in(TWO_FINGERS);
    /// An object counts as held if it is held without interruption for at least this time. Default: 1 ms, and at most
    /// 0.05 of the duration.
    "held_time": Time = Some(&mut t.held_time_s), allowed(NOT_NEGATIVE), only_in(TWO_FINGERS);
}
