//! Runs a scene with a sink that evaluates its criteria.

use crate::scene::Scene;
use crate::trace::Cancellable;
use crate::trace::{self, Model, Outcome, RunError, Sink};

/// Runs a scene with a sink that receives all steps. Returns the outcome or the failure; `None` if the run was
/// interrupted.
pub fn run(
    model: Model,
    scene: &Scene,
    sink: &mut impl Sink,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Result<Outcome, String>> {
    let scene = Scene { log: scene.log.without_sample_grid(scene.duration_s), ..scene.clone() };
    match trace::run(model, &scene, &mut Cancellable { sink, keep_running }) {
        Ok(outcome) => Some(Ok(outcome)),
        Err(error) if error.is_stop() => None,
        Err(RunError::Simulation { failure, .. }) => Some(Err(failure.to_string())),
        Err(RunError::Sink(error)) => Some(Err(error.to_string())),
    }
}
