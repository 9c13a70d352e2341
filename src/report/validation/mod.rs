//! What a validation is reported as: one document of plain figures, printed for people or as JSON, and the series of
//! both models side by side.

mod differences;
mod document;
mod figures;
mod invariants;
mod series;
mod side_by_side;
mod statistics;
mod text;

pub use differences::{
    AngleDifference, ContactDifference, DifferencesReport, DiscDifference, DiscDifferences, DiscErrors, Errors,
    JointDifferences, JointErrors, PairDifference,
};
pub use document::{CheckReport, ImpactReport, ModelReport, SettingReport, Status, ValidationReport};
pub use invariants::FindingReport;
pub use series::{COLUMNS, series};
pub use statistics::{StatisticReport, StatisticsReport};
pub use text::validation_text;

/// The report as one JSON document with a line end.
pub fn validation_json(report: &ValidationReport) -> String {
    super::document_text(report)
}
