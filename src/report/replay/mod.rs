//! What a log is reported as.

mod against;
mod document;
mod heard;
mod recover;
mod summary;
mod text;
mod verify;

pub use against::{AgainstReport, ApartReport, side_by_side};
pub use document::{MissingReport, ReplayReport};
pub use heard::{Heard, attached};
pub use recover::RecoveryReport;
pub use summary::Summary;
pub use verify::VerificationReport;
