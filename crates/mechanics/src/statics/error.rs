//! Why there is no statics.

use crate::gripper::PostureError;

/// Why forces or form closure of a grasp cannot be found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StaticsError {
    #[error("{name} is {value}, but {allowed}: give another value")]
    Number { name: &'static str, value: f64, allowed: &'static str },
    #[error(
        "l12 and l22 are in line in the final posture (the sine of their angle is {sine:.2e}, at least 1e-3 is needed): the \
         motor holds the distal phalanx with any force there, so change phi22, l22 or l12"
    )]
    InLine { sine: f64 },
    #[error(
        "l11 and l12 are in line in the final posture (dq22/dq11 is {slope:.2e}): the motor cannot move the distal phalanx there, so \
         change l11, l12 or phi22"
    )]
    DeadPoint { slope: f64 },
    #[error(
        "the distal phalanx touches the object {:.2e} mm from its joint: no torque of it makes a force there, so make l21 longer or \
         move the object nearer",
        .lever_m * 1e3
    )]
    NoLever { lever_m: f64 },
    #[error(
        "form closure could not be decided: neither a free motion nor the multipliers that exclude one pass their check \
         (residuals {motion_residual:.1e} and {multiplier_residual:.1e}); the grasp is on the boundary, change it a little"
    )]
    Undecided { motion_residual: f64, multiplier_residual: f64 },
    #[error(
        "the linear programme of form closure has no answer ({reason}); the grasp is close to singular, change it a little"
    )]
    Program { reason: String },
    #[error(
        "the linear programme of what contact forces can balance has no answer ({reason}); the posture is close to singular, \
         change it a little"
    )]
    Balance { reason: String },
    #[error(transparent)]
    Loop(#[from] PostureError),
}
