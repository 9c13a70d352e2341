//! The statics of the grasp of a finger or of a gripper: one document, printed as text or as JSON.
//!
//! | file | job |
//! |---|---|
//! | `document` | figures of a finger, with units in their keys |
//! | `closure` | form closure with its certificate, by the names of its constraints |
//! | `motion` | figures of a free motion |
//! | `motion_text` | description of a free motion |
//! | `text` | its tables |
//! | `gripper` | figures of a gripper |
//! | `gripper_text` | its tables |

mod closure;
mod document;
mod gripper;
mod gripper_text;
mod motion;
mod motion_text;
mod text;

pub use document::StaticsReport;
pub use gripper::GripperStaticsReport;
