//! What a validation is reported as: one document of plain figures, printed for people or as JSON, and the series of
//! both models side by side.

mod bodies_document;
mod bodies_text;
mod document;
mod invariants;
mod series;
mod statistics;
mod text;

pub use bodies_document::{
    BodiesModelReport, BodiesValidationReport, DiscDifference, DiscDifferences, DiscErrors, PairDifference,
};
pub use bodies_text::bodies_validation_text;
pub use document::{
    AngleDifference, CheckReport, ContactDifference, DifferencesReport, ImpactReport, JointErrors, ModelReport,
    SettingReport, Status, ValidationReport,
};
pub use invariants::FindingReport;
pub use series::{COLUMNS, bodies_series, series};
pub use statistics::{StatisticReport, StatisticsReport};
pub use text::validation_text;

/// The report as one JSON document with a line end.
pub fn validation_json(report: &ValidationReport) -> String {
    super::document_text(report)
}

/// The same of a scene of discs.
pub fn bodies_validation_json(report: &BodiesValidationReport) -> String {
    super::document_text(report)
}
