//! What a run or a grasp at rest is reported as: one document of plain figures, printed for people or as JSON.
//!
//! | file | job |
//! |---|---|
//! | `document` | figures of a run, with their units in their keys |
//! | `contacts`, `discs`, `grasp`, `named` | parts of it |
//! | `check` | what a check found |
//! | `text`, `tables` | the summary for people |
//! | `csv`, `samples` | samples as comma-separated values |
//! | `statics` | the grasp at rest |

pub mod check;
pub mod contacts;
pub mod csv;
pub mod discs;
pub mod document;
pub mod grasp;
pub mod named;
mod samples;
mod statics;
pub mod tables;
pub mod text;

pub use check::RunCheckReport;
pub use contacts::{Contacts, FingerContacts, LimitReport, PairReport, PhalanxReport, PlaceReport};
pub use discs::DiscReport;
pub use document::{Came, Dynamics, Energies, Failure, Final, RunReport, Used, WorkReport};
pub use grasp::{CycleReport, ForceClosureReport, GraspReport, HeldContactReport, TravelReport};
pub use named::Named;
pub use samples::{csv_head, csv_sample, is_samples};
pub use statics::{
    AnglesReport, BalanceReport, BirglenReport, ClosureReport, ContactPlaceReport, DirectionReport, DriveReport,
    FinalPostureReport, FingerMotionReport, ForceReport, ForcesReport, GripperClosureReport, GripperContactReport,
    GripperPostureReport, GripperStaticsReport, HandMotionReport, HoldsReport, MotionReport, MotorReport,
    MultiplierReport, NecessaryReport, RateReport, SpringReport, StaticsReport, gripper_statics_json,
    gripper_statics_text, statics_json, statics_text,
};
pub use text::text;

use serde::Serialize;

/// The report as one JSON document with a line end.
///
/// Floats are printed in the shortest form that reads back to the same double; what is not finite becomes null.
pub fn json(report: &RunReport) -> String {
    document_text(report)
}

/// Any report as one JSON document with a line end.
pub fn document_text(report: &impl Serialize) -> String {
    let mut text = serde_json::to_string_pretty(report).expect("a report is plain data with string keys");
    text.push('\n');
    text
}
