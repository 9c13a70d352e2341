//! Static grasps of fingers and grippers: forces, closures and balanced accelerations.

pub mod finger;
pub mod gripper;

pub use gripper::{geometric_posture, run};
