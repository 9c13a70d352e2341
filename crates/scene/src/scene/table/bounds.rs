//! `[validate]`: tolerances of `phalanx validate` for differences between the engine model and the analytic model.

use super::settings;
use crate::scene::check::POSITIVE;
use crate::scene::keywords::{FINGERS, NO_FINGER, NO_OR_TWO_FINGERS, ONE_FINGER, SceneKind, TWO_FINGERS};
use crate::scene::value_kinds::{Angle, Length, Number, Time};

/// Tolerances for a scene of any kind; each kind uses those that its section has.
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
    /// Largest relative difference of the normal impulse of an impact; in scenes of discs, of a pair over the run.
    pub impulse: f64,
    /// Largest relative difference of the largest normal force of a pair.
    pub peak_force: f64,
    /// Largest opening of a joint of the engine model.
    pub loop_gap_m: f64,
    /// Largest difference of the time to stability.
    pub stability_time_s: f64,
    /// Largest difference of a coefficient of restitution.
    pub restitution: f64,
    /// End of the comparison of trajectories (later rebounds may be chaotic); by default the duration.
    pub until_s: f64,
}

impl Bounds {
    /// Default tolerances of a kind of scene.
    pub const fn defaults_for_run(kind: SceneKind, duration_s: f64) -> Self {
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

settings! {
    /// Tolerances of `phalanx validate` for differences between the engine model and the analytic model.
    Bounds = Self::defaults_for_run(SceneKind::Finger, f64::NAN), b, where {
        fn defaults_for(kind: SceneKind) -> Self {
            Self::defaults_for_run(kind, f64::NAN)
        }
    };
    /// Difference of any joint angle, over the run up to `until`.
    "angle": Angle = Some(&mut b.angle_rad), allowed(POSITIVE), only_in(ONE_FINGER);
    /// Difference of any joint angle of either finger, over the run up to `until`.
    "angle": Angle = Some(&mut b.angle_rad), allowed(POSITIVE), default_text("1e-4 rad"), only_in(TWO_FINGERS);
    /// Distance between the centres of a disc in both models, over the run up to `until`.
    "position": Length = Some(&mut b.position_m), allowed(POSITIVE), only_in(NO_FINGER);
    /// Distance between the object's centres in both models, over the run up to `until`.
    "position": Length = Some(&mut b.position_m), allowed(POSITIVE), only_in(TWO_FINGERS);
    /// Difference of the times of the first contact of a phalanx with the object.
    "contact_time": Time = Some(&mut b.contact_time_s), allowed(POSITIVE), only_in(ONE_FINGER);
    /// Difference of the times of the first contact of two surfaces.
    "contact_time": Time = Some(&mut b.contact_time_s), allowed(POSITIVE), only_in(NO_OR_TWO_FINGERS);
    /// Relative difference of a normal force at the end.
    "final_force": Number = Some(&mut b.final_force), allowed(POSITIVE), only_in(FINGERS);
    /// Relative difference of the normal impulse of an impact.
    "impulse": Number = Some(&mut b.impulse), allowed(POSITIVE), only_in(FINGERS);
    /// Relative difference of the normal impulse of a pair, over the run up to `until`.
    "impulse": Number = Some(&mut b.impulse), allowed(POSITIVE), only_in(NO_FINGER);
    /// Relative difference of the largest normal force of a pair.
    "peak_force": Number = Some(&mut b.peak_force), allowed(POSITIVE), only_in(NO_FINGER);
    /// Opening of a joint of the engine model.
    "loop_gap": Length = Some(&mut b.loop_gap_m), allowed(POSITIVE), default_text("1e-4 mm"), only_in(FINGERS);
    /// Difference of the time to stability.
    "stability_time": Time = Some(&mut b.stability_time_s), allowed(POSITIVE), default_text("10 us"), only_in(ONE_FINGER);
    /// Difference of the time to stability of the whole grasp.
    "stability_time": Time = Some(&mut b.stability_time_s), allowed(POSITIVE), default_text("0.1 ms"), only_in(TWO_FINGERS);
    /// Difference of the coefficient of restitution of a pair.
    "restitution": Number = Some(&mut b.restitution), allowed(POSITIVE), only_in(NO_FINGER);
    /// End of the comparison of trajectories, at most the duration: later rebounds may be chaotic. Default: the
    /// duration.
    "until": Time = Some(&mut b.until_s), allowed(POSITIVE), only_in(FINGERS);
    /// End of the comparison, at most the duration: later rebounds may be chaotic. Default: the duration.
    "until": Time = Some(&mut b.until_s), allowed(POSITIVE), only_in(NO_FINGER);
}
