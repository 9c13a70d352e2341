//! Scenes of discs as subjects of a validation.
//!
//! The time after `until` is not run at all, so every figure of a run, its peaks and impulses too, is of what is compared.

mod difference;
mod subject;

pub use difference::{BodiesComparison, BodiesDifferences};
