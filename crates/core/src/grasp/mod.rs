//! Static grasps of fingers and grippers: forces, closures and balanced accelerations.
//!
//! | file | job |
//! |---|---|
//! | `finger` | grasp of one finger, its mirror image and the palm |
//! | `gripper` | grasp of a gripper, and the accelerations that it balances |
//! | `geometric_posture` | geometric posture of a gripper around its object |
//! | `simulate` | run of a scene for its criteria |

pub mod finger;
mod geometric_posture;
pub mod gripper;
mod simulate;

pub use geometric_posture::geometric_posture;
pub use simulate::run;
