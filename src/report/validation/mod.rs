//! What a validation is reported as: one document of plain figures, printed for people or as JSON, and the series of
//! both models side by side.

mod differences;
mod document;
mod errors;
mod figures;
mod invariants;
mod series;
mod side_by_side;
mod statistics;
mod text;

pub use document::ValidationReport;
pub use series::{COLUMNS, series};
