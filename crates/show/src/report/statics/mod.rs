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

pub use closure::{ClosureReport, MultiplierReport, NecessaryReport};
pub use document::{
    BirglenReport, ContactPlaceReport, DriveReport, FinalPostureReport, ForcesReport, SpringReport, StaticsReport,
};
pub use gripper::{
    AnglesReport, BalanceReport, DirectionReport, ForceReport, GripperClosureReport, GripperContactReport,
    GripperPostureReport, GripperStaticsReport, HandMotionReport, HoldsReport, MotorReport,
};
pub use gripper_text::gripper_statics_text;
pub use motion::{FingerMotionReport, MotionReport, RateReport};
pub use text::statics_text;

use super::document_text;

/// The report as one JSON document.
pub fn statics_json(report: &StaticsReport) -> String {
    document_text(report)
}

/// That of a gripper.
pub fn gripper_statics_json(report: &GripperStaticsReport) -> String {
    document_text(report)
}
