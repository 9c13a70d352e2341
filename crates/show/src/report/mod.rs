//! Reports of a run and of a grasp at rest: one document of plain figures, printed as text or as JSON.
//!
//! | file | job |
//! |---|---|
//! | `document` | a run: figures with units in their keys, and the summary for people |
//! | `states`, `contacts`, `object`, `named` | parts of it |
//! | `check` | the result of a check |
//! | `tables` | tables of the summary |
//! | `samples` | samples as comma-separated values |
//! | `statics` | the grasp at rest |

pub mod check;
pub mod contacts;
pub mod document;
pub mod object;
pub use crate::format::object as named;
pub mod samples;
pub mod states;
pub mod statics;
pub mod tables;
