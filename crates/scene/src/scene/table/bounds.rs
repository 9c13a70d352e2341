//! `[validate]`: how far the engine model may be from the analytic one before `phalanx validate` says no.

use super::lines;
use crate::scene::check::POSITIVE;
use crate::scene::kinds::{Angle, Length, Number, Time};
use crate::scene::words::{FINGERS, NO_FINGER, NOT_ONE, ONE_FINGER, SceneKind, TWO_FINGERS};

/// Bounds of a scene of any kind; each kind looks at those that its section has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Largest difference of any joint angle over the run.
    pub angle_rad: f64,
    /// Largest difference of a disc's centre over the run.
    pub position_m: f64,
    /// Largest difference of a first touch-down.
    pub contact_time_s: f64,
    /// Largest relative difference of a normal force at the end.
    pub final_force: f64,
    /// Largest relative difference of the normal impulse of an impact; of discs, of a pair over the run.
    pub impulse: f64,
    /// Largest relative difference of the largest normal force of a pair.
    pub peak_force: f64,
    /// Largest opening of a joint of the engine model.
    pub loop_gap_m: f64,
    /// Largest difference of the time to stability.
    pub stability_time_s: f64,
    /// Largest difference of a coefficient of restitution.
    pub restitution: f64,
    /// Trajectories are compared up to here (rebounds beyond may be chaotic); the run's duration unless said.
    pub until_s: f64,
}

impl Bounds {
    /// What every scene of a kind is held to unless it says otherwise.
    pub const fn over(kind: SceneKind, duration_s: f64) -> Self {
        let finger = Self {
            angle_rad: 2e-5,
            position_m: 1e-6,
            contact_time_s: 5e-7,
            final_force: 1e-4,
            impulse: 5e-3,
            peak_force: 1e-2,
            loop_gap_m: 1e-7,
            stability_time_s: 1e-5,
            restitution: 1e-2,
            until_s: duration_s,
        };
        match kind {
            SceneKind::Finger | SceneKind::Bodies => finger,
            SceneKind::Gripper => Self { angle_rad: 1e-4, final_force: 5e-3, stability_time_s: 1e-4, ..finger },
        }
    }
}

lines! {
    /// How far the engine model may be from the analytic one before `phalanx validate` says no.
    Bounds = Self::over(SceneKind::Finger, f64::NAN), b, where {
        fn usual_in(kind: SceneKind) -> Self {
            Self::over(kind, f64::NAN)
        }
    };
    /// Difference of any joint angle, over the run up to `until`.
    "angle": Angle = Some(&mut b.angle_rad), allowed(POSITIVE), of(ONE_FINGER);
    /// Difference of any joint angle of either finger, over the run up to `until`.
    "angle": Angle = Some(&mut b.angle_rad), allowed(POSITIVE), said("1e-4 rad"), of(TWO_FINGERS);
    /// Distance between the centres of a disc in both models, over the run up to `until`.
    "position": Length = Some(&mut b.position_m), allowed(POSITIVE), of(NO_FINGER);
    /// Distance between the object's centres in both models, over the run up to `until`.
    "position": Length = Some(&mut b.position_m), allowed(POSITIVE), of(TWO_FINGERS);
    /// Difference of the times a phalanx first touches the object.
    "contact_time": Time = Some(&mut b.contact_time_s), allowed(POSITIVE), of(ONE_FINGER);
    /// Difference of the times two surfaces first touch.
    "contact_time": Time = Some(&mut b.contact_time_s), allowed(POSITIVE), of(NOT_ONE);
    /// Relative difference of a normal force at the end.
    "final_force": Number = Some(&mut b.final_force), allowed(POSITIVE), of(FINGERS);
    /// Relative difference of the normal impulse of an impact.
    "impulse": Number = Some(&mut b.impulse), allowed(POSITIVE), of(FINGERS);
    /// Relative difference of the normal impulse of a pair, over the run up to `until`.
    "impulse": Number = Some(&mut b.impulse), allowed(POSITIVE), of(NO_FINGER);
    /// Relative difference of the largest normal force of a pair.
    "peak_force": Number = Some(&mut b.peak_force), allowed(POSITIVE), of(NO_FINGER);
    /// Opening of a joint of the engine model.
    "loop_gap": Length = Some(&mut b.loop_gap_m), allowed(POSITIVE), said("1e-4 mm"), of(FINGERS);
    /// Difference of the time to stability.
    "stability_time": Time = Some(&mut b.stability_time_s), allowed(POSITIVE), said("10 us"), of(ONE_FINGER);
    /// Difference of the time to stability of the whole grasp.
    "stability_time": Time = Some(&mut b.stability_time_s), allowed(POSITIVE), said("0.1 ms"), of(TWO_FINGERS);
    /// Difference of the coefficient of restitution of a pair.
    "restitution": Number = Some(&mut b.restitution), allowed(POSITIVE), of(NO_FINGER);
    /// End of the comparison of trajectories, at most the duration: rebounds beyond may be chaotic. Default: the
    /// duration.
    "until": Time = Some(&mut b.until_s), allowed(POSITIVE), of(FINGERS);
    /// End of the comparison, at most the duration: rebounds beyond may be chaotic. Default: the duration.
    "until": Time = Some(&mut b.until_s), allowed(POSITIVE), of(NO_FINGER);
}
