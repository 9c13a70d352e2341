//! Static grasps of fingers, grippers and mechanisms: forces, closures and balanced accelerations.

pub mod finger;
mod friction;
pub mod gripper;
mod gripper_at_rest;
pub mod mechanism;

pub use friction::FrictionCase;
pub use gripper::{geometric_posture, run, run_until_removal};
pub use gripper_at_rest::{DriveMode, GraspState, GripperAtRest, grasp_state, gripper_at_rest};
