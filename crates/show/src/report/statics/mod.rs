//! The statics of the grasp of a finger or of a gripper: JSON document and text.
//!
//! | file | job |
//! |---|---|
//! | `finger` | a finger |
//! | `gripper` | a gripper |
//! | `closure` | form closure with its certificate, by the names of its constraints |

mod closure;
mod finger;
mod gripper;

pub use finger::StaticsReport;
pub use gripper::GripperStaticsReport;

fn millimetres(length_m: f64) -> String {
    format!("{:.4}", length_m * 1e3)
}
