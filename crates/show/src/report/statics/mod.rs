//! The statics of a grasp, of a finger or of a gripper: one document, printed for people or as JSON.
//!
//! | file | job |
//! |---|---|
//! | `document` | figures with units in their names |
//! | `closure` | form closure with its certificate, by the names of its constraints |
//! | `words` | which motion is free, in words |
//! | `text` | tables |
//! | `gripper` | figures of a gripper |
//! | `gripper_text` | its tables |

mod closure;
mod document;
mod gripper;
mod gripper_text;
mod motion;
mod text;
mod words;

pub use document::StaticsReport;
pub use gripper::GripperStaticsReport;
