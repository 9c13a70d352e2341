//! Reports of commands: documents for JSON and CSV, and text.
//!
//! The crate `phalanx-show` reports runs and grasps; this module adds the reports of studies and logs.

pub mod capture;
pub mod hold;
pub mod replay;
pub mod reproduce;
mod rows;
pub mod select;
pub mod simulation;
pub mod sizing;
pub mod sweep;
pub mod validation;

pub use phalanx_show::report::*;
