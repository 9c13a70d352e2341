//! Why a run did not get to its end.

use super::{Outcome, SinkError};
use crate::integrator::{Failure, Reason};

/// Why a run did not get to its end.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// The simulation could not be completed; `so_far` is the run up to there, which the sink has in full.
    #[error("the simulation could not be completed {failure}")]
    Simulation { failure: Failure, so_far: Box<Outcome> },
}

impl RunError {
    /// Whether the run ended because its sink said so, see [`Sink::proceed`](super::Sink::proceed).
    pub fn is_stop(&self) -> bool {
        matches!(self, RunError::Simulation { failure: Failure { reason: Reason::Stopped, .. }, .. })
    }
}
