//! What a run of discs is reported as.

mod document;
pub(super) mod text;

pub use document::{BodiesReport, DiscReport, PairReport};
pub(super) use document::{contacts, contacts_of, discs, discs_of};
pub use text::bodies_text;

/// The report as one JSON document with a line end, see [`json`](super::json).
pub fn bodies_json(report: &BodiesReport) -> String {
    super::document_text(report)
}
