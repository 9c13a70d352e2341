//! Errors of a run.

use super::{Outcome, SinkError};
use crate::integrator::{Failure, Reason};

/// Reason why a run did not complete.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// The simulation failed; `partial_outcome` summarises the run up to the failure. The sink has received all of it.
    #[error("the simulation could not be completed {failure}")]
    Simulation { failure: Failure, partial_outcome: Box<Outcome> },
}

impl RunError {
    /// Whether the run was cancelled by its sink, see [`Sink::should_continue`](super::Sink::should_continue).
    pub fn is_stop(&self) -> bool {
        matches!(self, RunError::Simulation { failure: Failure { reason: Reason::Stopped, .. }, .. })
    }
}
