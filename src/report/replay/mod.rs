//! Reports of logs: summary, verification and comparison.

mod comparison;
mod document;
mod observer;
mod summary;
mod verify;

pub(crate) use comparison::{LogComparisonReport, TrajectoryDifference, compare_summaries};
pub use document::ReplayReport;
pub use observer::{LogObserver, scene_in_log};
pub use summary::Summary;
pub use verify::VerificationReport;
