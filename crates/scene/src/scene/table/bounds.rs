//! `[validate]`: how far the engine model may be from the analytic one before `phalanx validate` says no.

use super::{Table, lines};
use crate::scene::check::POSITIVE;
use crate::scene::kinds::{Angle, Length, Number, Time};

use crate::scene::words::SceneKind;

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
            until_s: duration_s,
        };
        match kind {
            SceneKind::Finger | SceneKind::Bodies => finger,
            SceneKind::Gripper => Self { angle_rad: 1e-4, final_force: 5e-3, ..finger },
        }
    }
}

/// Bounds as the scenes of a kind say them.
pub trait Said: Table + From<Bounds> {
    const KIND: SceneKind;

    fn bounds(self) -> Bounds;
}

macro_rules! said {
    ($($(#[$doc:meta])* $name:ident of $kind:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name(Bounds);

        impl From<Bounds> for $name {
            fn from(bounds: Bounds) -> Self {
                Self(bounds)
            }
        }

        impl Said for $name {
            const KIND: SceneKind = SceneKind::$kind;

            fn bounds(self) -> Bounds {
                self.0
            }
        }
    )*};
}

said! {
    /// Of a finger.
    FingerBounds of Finger;
    /// Of discs.
    DiscBounds of Bodies;
    /// Of a gripper.
    GripperBounds of Gripper;
}

lines! {
    /// How far the engine model may be from the analytic one before `phalanx validate` says no.
    FingerBounds = Self(Bounds::over(SceneKind::Finger, f64::NAN)), b;
    /// Difference of any joint angle, over the run up to `until`.
    "angle": Angle = Some(&mut b.0.angle_rad), allowed(POSITIVE);
    /// Difference of the times a phalanx first touches the object.
    "contact_time": Time = Some(&mut b.0.contact_time_s), allowed(POSITIVE);
    /// Relative difference of a normal force at the end.
    "final_force": Number = Some(&mut b.0.final_force), allowed(POSITIVE);
    /// Relative difference of the normal impulse of an impact.
    "impulse": Number = Some(&mut b.0.impulse), allowed(POSITIVE);
    /// Opening of a joint of the engine model.
    "loop_gap": Length = Some(&mut b.0.loop_gap_m), allowed(POSITIVE), said("1e-4 mm");
    /// End of the comparison of trajectories, at most the duration: rebounds beyond may be chaotic. Default: the
    /// duration.
    "until": Time = Some(&mut b.0.until_s), allowed(POSITIVE);
}

lines! {
    /// How far the engine model may be from the analytic one before `phalanx validate` says no.
    DiscBounds = Self(Bounds::over(SceneKind::Bodies, f64::NAN)), b;
    /// Distance between the centres of a disc in both models, over the run up to `until`.
    "position": Length = Some(&mut b.0.position_m), allowed(POSITIVE);
    /// Difference of the times two surfaces first touch.
    "contact_time": Time = Some(&mut b.0.contact_time_s), allowed(POSITIVE);
    /// Relative difference of the normal impulse of a pair, over the run up to `until`.
    "impulse": Number = Some(&mut b.0.impulse), allowed(POSITIVE);
    /// Relative difference of the largest normal force of a pair.
    "peak_force": Number = Some(&mut b.0.peak_force), allowed(POSITIVE);
    /// End of the comparison, at most the duration: rebounds beyond may be chaotic. Default: the duration.
    "until": Time = Some(&mut b.0.until_s), allowed(POSITIVE);
}

lines! {
    /// How far the engine model may be from the analytic one before `phalanx validate` says no.
    GripperBounds = Self(Bounds::over(SceneKind::Gripper, f64::NAN)), b;
    /// Difference of any joint angle of either finger, over the run up to `until`.
    "angle": Angle = Some(&mut b.0.angle_rad), allowed(POSITIVE), said("1e-4 rad");
    /// Distance between the object's centres in both models, over the run up to `until`.
    "position": Length = Some(&mut b.0.position_m), allowed(POSITIVE);
    /// Difference of the times two surfaces first touch.
    "contact_time": Time = Some(&mut b.0.contact_time_s), allowed(POSITIVE);
    /// Relative difference of a normal force at the end.
    "final_force": Number = Some(&mut b.0.final_force), allowed(POSITIVE);
    /// Relative difference of the normal impulse of an impact.
    "impulse": Number = Some(&mut b.0.impulse), allowed(POSITIVE);
    /// Opening of a joint of the engine model.
    "loop_gap": Length = Some(&mut b.0.loop_gap_m), allowed(POSITIVE), said("1e-4 mm");
    /// End of the comparison of trajectories, at most the duration: rebounds beyond may be chaotic. Default: the
    /// duration.
    "until": Time = Some(&mut b.0.until_s), allowed(POSITIVE);
}
