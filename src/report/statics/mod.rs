//! The statics of a grasp: one document, printed for people or as JSON.
//!
//! | file | job |
//! |---|---|
//! | `document` | figures with units in their names |
//! | `closure` | form closure with its certificate, by the names of its constraints |
//! | `words` | which motion is free, in words |
//! | `text` | tables |

mod closure;
mod document;
mod motion;
mod text;
mod words;

pub use closure::{ClosureReport, MultiplierReport, NecessaryReport};
pub use document::{
    BirglenReport, ContactPlaceReport, DriveReport, FinalPostureReport, ForcesReport, SpringReport, StaticsReport,
};
pub use motion::{FingerMotionReport, MotionReport, RateReport};
pub use text::statics_text;

use super::document_text;

/// The report as one JSON document.
pub fn statics_json(report: &StaticsReport) -> String {
    document_text(report)
}
