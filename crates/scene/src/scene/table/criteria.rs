//! `[criteria]`: which losses of contact count, and how long an object must be held.

use super::lines;
use crate::scene::check::NOT_NEGATIVE;
use crate::scene::kinds::{Force, Time};
use crate::scene::words::TWO_FINGERS;

/// Thresholds of the grasp criteria of a gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thresholds {
    /// Shortest loss of a contact force that counts, s.
    pub loss_time_s: f64,
    /// Largest normal force of a contact that counts as lost, N.
    pub loss_force_n: f64,
    /// Shortest time for which an object must be held, s.
    pub held_time_s: f64,
}

/// Default of [`Thresholds::loss_time_s`], s, in runs of at least 20 ms…
const LOSS_TIME_S: f64 = 1e-4;
/// …and as a part of the duration in shorter runs.
const LOSS_PART: f64 = 0.005;
/// Default of [`Thresholds::held_time_s`] as a multiple of the loss time.
const HELD_LOSSES: f64 = 10.0;
/// Default of [`Thresholds::loss_force_n`] as a part of the largest force that a motor exerts at the end of a proximal phalanx.
const LOSS_FORCE_PART: f64 = 1e-4;

impl Thresholds {
    /// Every loss of contact counts, and an object is held at once: those of scenes that are no gripper.
    pub const NONE: Self = Self { loss_time_s: 0.0, loss_force_n: 0.0, held_time_s: 0.0 };

    /// Defaults of a run of this duration, with motors that exert at most this force at the end of a proximal phalanx.
    pub fn of(duration_s: f64, motor_force_n: f64) -> Self {
        let loss_time_s = LOSS_TIME_S.min(LOSS_PART * duration_s);
        Self { loss_time_s, loss_force_n: LOSS_FORCE_PART * motor_force_n, held_time_s: HELD_LOSSES * loss_time_s }
    }
}

lines! {
    /// When a contact counts as lost, and an object as held. A single finger follows the thesis instead, where every loss counts.
    Thresholds = Self { loss_time_s: f64::NAN, loss_force_n: f64::NAN, held_time_s: f64::NAN }, t;
    /// A contact counts as lost if its force stays at or below `loss_force` for at least this long. Default: 0.1 ms, and at most
    /// 0.005 of the duration.
    "loss_time": Time = Some(&mut t.loss_time_s), allowed(NOT_NEGATIVE), of(TWO_FINGERS);
    /// Normal force at or below which a contact does not press. Default: 1e-4 of the largest motor torque over the length of the
    /// proximal phalanx.
    "loss_force": Force = Some(&mut t.loss_force_n), allowed(NOT_NEGATIVE), of(TWO_FINGERS);
    /// An object counts as held if it has been held without a break for at least this long. Default: 1 ms, and at most 0.05 of the
    /// duration.
    "held_time": Time = Some(&mut t.held_time_s), allowed(NOT_NEGATIVE), of(TWO_FINGERS);
}
