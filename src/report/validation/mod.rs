//! Report of a validation: one document, printed as text or JSON, and the time series of both models side by side.
//!
//! | file | content |
//! |---|---|
//! | `document` | the document and its parts |
//! | `differences` | figures of differences: keys of the document and columns of tables |
//! | `text` | the text report |
//! | `series` | time series of both models |

mod differences;
mod document;
mod series;
mod text;

pub use document::ValidationReport;
pub(crate) use series::write_series;
