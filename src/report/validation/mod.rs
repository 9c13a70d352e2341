//! Report of a validation: one document, printed as text or JSON, and the time series of both models side by side.

mod differences;
mod document;
mod errors;
mod invariants;
mod numbers;
mod series;
mod side_by_side;
mod statistics;
mod text;

pub use document::ValidationReport;
pub use series::{COLUMNS, write_series};
