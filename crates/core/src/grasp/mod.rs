//! A grasp at rest, all of it: for a report and a picture.
//!
//! | file | job |
//! |---|---|
//! | `finger` | of one finger, its mirror image and the palm |
//! | `gripper` | how a gripper holds its object, and what acceleration it bears |
//! | `geometric` | where the fingers of a gripper close around its object |
//! | `simulate` | a run of a gripper for what its criteria say |

pub mod finger;
mod geometric;
pub mod gripper;
mod simulate;

pub use geometric::geometric;
pub use simulate::run;
