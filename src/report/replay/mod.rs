//! What a log is reported as.

mod against;
mod document;
mod heard;
mod recover;
mod summary;
mod text;
mod verify;

pub use against::{AgainstReport, ApartReport, FigureReport, WordReport, against_json, against_text, side_by_side};
pub use document::{Lost, ReplayReport};
pub use heard::{Heard, attached};
pub use recover::{GapReport, RecoveryReport, recovery_json, recovery_text};
pub use summary::Summary;
pub use text::replay_text;
pub use verify::{DifferenceReport, EntryReport, FieldReport, VerificationReport};

/// The report as one JSON document with a line end, see [`json`](super::json).
pub fn replay_json(report: &ReplayReport) -> String {
    super::document_text(report)
}
