//! Reports of logs: summary, verification, comparison and recovery.

mod comparison;
mod document;
mod observer;
mod recover;
mod summary;
mod text;
mod verify;

pub use comparison::{LogComparisonReport, TrajectoryDifference, compare_summaries};
pub use document::{MissingTopicReport, ReplayReport};
pub use observer::{LogObserver, scene_in_log};
pub use recover::RecoveryReport;
pub use summary::Summary;
pub use verify::VerificationReport;
