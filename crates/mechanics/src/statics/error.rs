//! Errors in the static analysis.

use crate::gripper::PostureError;

/// Error for a grasp whose forces or form closure cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StaticsError {
    #[error("{name} is {value}, but {allowed}: give another value")]
    Number { name: &'static str, value: f64, allowed: &'static str },
    #[error(
        "l12 and l22 are in line in the final posture (the sine of their angle is {sine:.2e}, at least 1e-3 is needed): the \
         motor can resist any force on the distal phalanx there, so change phi22, l22 or l12"
    )]
    InLine { sine: f64 },
    #[error(
        "l11 and l12 are in line in the final posture (dq22/dq11 is {slope:.2e}): the motor cannot move the distal phalanx there, so \
         change l11, l12 or phi22"
    )]
    DeadPoint { slope: f64 },
    #[error(
        "the distal phalanx touches the object {:.2e} mm from its joint: its torque cannot produce a contact force there, so make l21 \
         longer or move the object closer",
        .lever_m * 1e3
    )]
    NoLever { lever_m: f64 },
    #[error(
        "form closure could not be decided: neither a free motion nor the multipliers that exclude one pass their check \
         (residuals {motion_residual:.1e} and {multiplier_residual:.1e}); the grasp is on the boundary, change it slightly"
    )]
    Undecided { motion_residual: f64, multiplier_residual: f64 },
    #[error(
        "the linear programme of form closure has no solution ({reason}); the grasp is close to singular, change it slightly"
    )]
    Program { reason: String },
    #[error(
        "the linear programme of the force balance has no solution ({reason}); the posture is close to singular, change it \
         slightly"
    )]
    Balance { reason: String },
    #[error(transparent)]
    Loop(#[from] PostureError),
}

/// Checks that a number is finite and in its range.
pub(super) fn number(
    name: &'static str,
    value: f64,
    in_range: bool,
    allowed: &'static str,
) -> Result<(), StaticsError> {
    if value.is_finite() && in_range { Ok(()) } else { Err(StaticsError::Number { name, value, allowed }) }
}
