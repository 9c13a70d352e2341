//! Static grasps of fingers, grippers and mechanisms: forces, closures and balanced accelerations.

pub mod finger;
pub mod gripper;
pub mod mechanism;

pub use gripper::{geometric_posture, run};
