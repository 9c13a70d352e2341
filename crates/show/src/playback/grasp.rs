//! The answer of a grasp, and the states of its object over time.

use serde::Serialize;

/// A grasp as a page shows it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlayedGrasp {
    /// The answer in one sentence.
    pub answer: String,
    /// States in order of time; each lasts up to the next one, the last one up to the end of the run.
    pub states: Vec<PlayedState>,
}

/// A state of the object: `gripped`, `carried`, `resting`, `free`, or `released` after the release, where it is not judged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlayedState {
    pub from_s: f64,
    pub name: &'static str,
}
