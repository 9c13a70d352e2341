//! `[validate]`: how far the engine model may be from the analytic one before `phalanx validate` says no.

use super::lines;
use crate::scene::check::POSITIVE;
use crate::scene::kinds::{Angle, Length, Number, Time};

/// Bounds of a finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Largest difference of any joint angle over the run.
    pub angle_rad: f64,
    /// Largest difference of a first touch-down.
    pub contact_time_s: f64,
    /// Largest relative difference of a normal force at the end.
    pub final_force: f64,
    /// Largest relative difference of the normal impulse of an impact.
    pub impulse: f64,
    /// Largest opening of a joint of the engine model.
    pub loop_gap_m: f64,
    /// Trajectories are compared up to here (rebounds beyond may be chaotic); the run's duration unless said.
    pub until_s: f64,
}

/// Bounds of discs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodiesBounds {
    /// Largest difference of a disc's centre over the run.
    pub position_m: f64,
    /// Largest difference of a first touch-down.
    pub contact_time_s: f64,
    /// Largest relative difference of the normal impulse of a pair over the run.
    pub impulse: f64,
    /// Largest relative difference of the largest normal force of a pair.
    pub peak_force: f64,
    /// Compared up to here; the run's duration unless said.
    pub until_s: f64,
}

/// Bounds of a gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GripperBounds {
    /// Largest difference of any joint angle over the run.
    pub angle_rad: f64,
    /// Largest difference of the object's centre over the run.
    pub position_m: f64,
    /// Largest difference of a first touch-down.
    pub contact_time_s: f64,
    /// Largest relative difference of a normal force at the end.
    pub final_force: f64,
    /// Largest relative difference of the normal impulse of an impact.
    pub impulse: f64,
    /// Largest opening of a joint of the engine model.
    pub loop_gap_m: f64,
    /// Trajectories are compared up to here (rebounds beyond may be chaotic); the run's duration unless said.
    pub until_s: f64,
}

impl GripperBounds {
    /// What every gripper is held to unless its scene says otherwise.
    pub const fn over(duration_s: f64) -> Self {
        let Bounds { contact_time_s, impulse, loop_gap_m, until_s, .. } = Bounds::over(duration_s);
        Self { angle_rad: 1e-4, position_m: 1e-6, contact_time_s, final_force: 5e-3, impulse, loop_gap_m, until_s }
    }
}

impl Bounds {
    /// What every scene is held to unless it says otherwise.
    pub const fn over(duration_s: f64) -> Self {
        Self {
            angle_rad: 2e-5,
            contact_time_s: 5e-7,
            final_force: 1e-4,
            impulse: 5e-3,
            loop_gap_m: 1e-7,
            until_s: duration_s,
        }
    }
}

impl BodiesBounds {
    /// What every scene of discs is held to unless it says otherwise.
    pub const fn over(duration_s: f64) -> Self {
        Self { position_m: 1e-6, contact_time_s: 5e-7, impulse: 5e-3, peak_force: 1e-2, until_s: duration_s }
    }
}

lines! {
    /// How far the engine model may be from the analytic one before `phalanx validate` says no.
    Bounds = Self::over(f64::NAN), b;
    /// Difference of any joint angle, over the run up to `until`.
    "angle": Angle = Some(&mut b.angle_rad), allowed(POSITIVE);
    /// Difference of the times a phalanx first touches the object.
    "contact_time": Time = Some(&mut b.contact_time_s), allowed(POSITIVE);
    /// Relative difference of a normal force at the end.
    "final_force": Number = Some(&mut b.final_force), allowed(POSITIVE);
    /// Relative difference of the normal impulse of an impact.
    "impulse": Number = Some(&mut b.impulse), allowed(POSITIVE);
    /// Opening of a joint of the engine model.
    "loop_gap": Length = Some(&mut b.loop_gap_m), allowed(POSITIVE), said("1e-4 mm");
    /// End of the comparison of trajectories, at most the duration: rebounds beyond may be chaotic. Default: the
    /// duration.
    "until": Time = Some(&mut b.until_s), allowed(POSITIVE);
}

lines! {
    /// How far the engine model may be from the analytic one before `phalanx validate` says no.
    BodiesBounds = Self::over(f64::NAN), b;
    /// Distance between the centres of a disc in both models, over the run up to `until`.
    "position": Length = Some(&mut b.position_m), allowed(POSITIVE);
    /// Difference of the times two surfaces first touch.
    "contact_time": Time = Some(&mut b.contact_time_s), allowed(POSITIVE);
    /// Relative difference of the normal impulse of a pair, over the run up to `until`.
    "impulse": Number = Some(&mut b.impulse), allowed(POSITIVE);
    /// Relative difference of the largest normal force of a pair.
    "peak_force": Number = Some(&mut b.peak_force), allowed(POSITIVE);
    /// End of the comparison, at most the duration: rebounds beyond may be chaotic. Default: the duration.
    "until": Time = Some(&mut b.until_s), allowed(POSITIVE);
}

lines! {
    /// How far the engine model may be from the analytic one before `phalanx validate` says no.
    GripperBounds = Self::over(f64::NAN), b;
    /// Difference of any joint angle of either finger, over the run up to `until`.
    "angle": Angle = Some(&mut b.angle_rad), allowed(POSITIVE), said("1e-4 rad");
    /// Distance between the object's centres in both models, over the run up to `until`.
    "position": Length = Some(&mut b.position_m), allowed(POSITIVE);
    /// Difference of the times two surfaces first touch.
    "contact_time": Time = Some(&mut b.contact_time_s), allowed(POSITIVE);
    /// Relative difference of a normal force at the end.
    "final_force": Number = Some(&mut b.final_force), allowed(POSITIVE);
    /// Relative difference of the normal impulse of an impact.
    "impulse": Number = Some(&mut b.impulse), allowed(POSITIVE);
    /// Opening of a joint of the engine model.
    "loop_gap": Length = Some(&mut b.loop_gap_m), allowed(POSITIVE), said("1e-4 mm");
    /// End of the comparison of trajectories, at most the duration: rebounds beyond may be chaotic. Default: the
    /// duration.
    "until": Time = Some(&mut b.until_s), allowed(POSITIVE);
}
