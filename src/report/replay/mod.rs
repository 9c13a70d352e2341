//! Reports of logs: summary, verification and comparison.

mod comparison;
mod document;
mod observer;
mod verify;

pub use comparison::{LogComparisonReport, TrajectoryDifference, compare_summaries};
pub use document::ReplayReport;
pub use observer::{LogObserver, Summary, scene_in_log};
pub use verify::VerificationReport;
