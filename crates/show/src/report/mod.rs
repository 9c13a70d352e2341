//! What a run or a grasp at rest is reported as: one document of plain figures, printed for people or as JSON.
//!
//! | file | job |
//! |---|---|
//! | `document` | figures of a run, with their units in their keys |
//! | `states`, `contacts`, `grasp`, `named` | parts of it |
//! | `check` | what a check found |
//! | `text`, `tables` | the summary for people |
//! | `csv`, `samples` | samples as comma-separated values |
//! | `statics` | the grasp at rest |

pub mod check;
pub mod contacts;
pub mod csv;
pub mod document;
pub mod grasp;
pub mod named;
pub mod samples;
pub mod states;
pub mod statics;
pub mod tables;
pub mod text;
