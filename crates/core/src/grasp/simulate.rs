//! A run of a gripper for what its criteria say.

use crate::scene::Scene;
use crate::trace::While;
use crate::trace::{self, Model, Outcome, RunError, Sink};

/// Runs a scene into a sink that follows its steps; `None` if it was told to stop, and otherwise what it came to, or why it did not.
pub fn run(
    model: Model,
    scene: &Scene,
    sink: &mut impl Sink,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Option<Result<Outcome, String>> {
    let scene = Scene { log: scene.log.without_grid(scene.duration_s), ..scene.clone() };
    match trace::run(model, &scene, &mut While { sink, go_on }) {
        Ok(outcome) => Some(Ok(outcome)),
        Err(error) if error.is_stop() => None,
        Err(RunError::Simulation { failure, .. }) => Some(Err(failure.to_string())),
        Err(RunError::Sink(error)) => Some(Err(error.to_string())),
    }
}
