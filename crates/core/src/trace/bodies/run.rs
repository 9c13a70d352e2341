//! Runs either model of a scene of discs.

use super::analytic::run_analytic;
use super::engine::run_engine;
use super::{BodiesOutcome, BodiesSample};
use crate::scene::BodiesScene;
use crate::trace::{Model, RunError, Sink};

/// Why a run of discs did not get to its end.
pub type BodiesRunError = RunError<BodiesOutcome>;

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
