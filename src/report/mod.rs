//! What a run is reported as: one document of plain figures, printed for people or as JSON.

mod document;
mod table;
mod text;

pub use document::{
    Contacts, Dynamics, Energies, EngineUsed, Failure, Final, IntegratorUsed, LimitReport, PhalanxReport, RunReport,
    WorkReport,
};
pub use text::{duration, text};

/// The report as one JSON document with a line end.
///
/// Floats are printed in the shortest form that reads back to the same double; what is not finite becomes null.
pub fn json(report: &RunReport) -> String {
    let mut text = serde_json::to_string_pretty(report).expect("a report is plain data with string keys");
    text.push('\n');
    text
}
