//! Errors in the sizing.

use crate::gripper::GraspError;

/// Error for a finger that cannot be sized.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SizingError {
    #[error(transparent)]
    Grasp(#[from] GraspError),
    #[error("{name} is {value}, but must be a finite number above 0: give another value")]
    NotPositive { name: &'static str, value: f64 },
    #[error(
        "the finger starts {:.4} deg before the proximal contact, but must start more than 0 deg before it: open it further \
         (raise the offset, or lower q21)",
        .opening_rad.to_degrees()
    )]
    Opening { opening_rad: f64 },
    #[error(
        "the test trajectory moves l11 by {:.4} deg in total, but the finger swings {:.4} deg before it reaches the object: \
         its distal phalanx would have to bend backwards, so make l21 longer, or phi22 or arm_ratio larger",
        .stroke_rad.to_degrees(), .rigid_stroke_rad.to_degrees()
    )]
    NoBendingStroke { stroke_rad: f64, rigid_stroke_rad: f64 },
    #[error(
        "sizing requires the straight configuration, which the assembly \"other\" does not have: use \"reference\""
    )]
    OtherAssembly,
    #[error(
        "l12 and l22 are in line on the test trajectory (l21 at {:.4} deg), where no torque moves the distal phalanx: change phi22, \
         arm_ratio or l21",
        .q21_rad.to_degrees()
    )]
    Singular { q21_rad: f64 },
}
