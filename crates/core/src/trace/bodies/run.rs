//! Runs either model of a scene of discs.

use super::analytic::run_analytic;
use super::engine::run_engine;
use super::{BodiesOutcome, BodiesSample};
use crate::integrator::{Failure, Reason};
use crate::scene::BodiesScene;
use crate::trace::{Model, Sink, SinkError};

/// Why a run did not get to its end.
#[derive(Debug, thiserror::Error)]
pub enum BodiesRunError {
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// The simulation could not be completed; `so_far` is the run up to there, which the sink has in full.
    #[error("the simulation could not be completed {failure}")]
    Simulation { failure: Failure, so_far: Box<BodiesOutcome> },
}

impl BodiesRunError {
    /// Whether the run ended because its sink said so, see [`Sink::proceed`].
    pub fn is_stop(&self) -> bool {
        matches!(self, BodiesRunError::Simulation { failure: Failure { reason: Reason::Stopped, .. }, .. })
    }
}

/// Simulates `scene` with one of the models.
pub fn run_bodies(
    model: Model,
    scene: &BodiesScene,
    sink: &mut dyn Sink<BodiesSample>,
) -> Result<BodiesOutcome, BodiesRunError> {
    match model {
        Model::Analytic => run_analytic(scene, sink),
        Model::Engine => run_engine(scene, sink),
    }
}
