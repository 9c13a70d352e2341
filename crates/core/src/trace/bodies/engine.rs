//! Runs the engine model of a scene of discs and tells a sink about it.

use super::engine_recorder::EngineRecorder;
use super::{BodiesOutcome, BodiesRunError, BodiesSample};
use crate::engine::{Motion, build, plan_discs};
use crate::integrator::{Failure, Reason};
use crate::scene::BodiesScene;
use crate::trace::Sink;
use crate::trace::engine::step_through;

/// Simulates `scene` with the engine model, as `scene.engine` says. Samples and events are as in
/// [`run_engine`](crate::trace::run_engine).
pub fn run_engine(scene: &BodiesScene, sink: &mut dyn Sink<BodiesSample>) -> Result<BodiesOutcome, BodiesRunError> {
    let plan = plan_discs(scene);
    let settings = &scene.engine;
    let world = build(&plan, settings.construction, settings.response, settings.iterations);
    let mut motion = Motion::new(&plan, world).map_err(|error| BodiesRunError::Simulation {
        failure: Failure { time_s: 0.0, reason: Reason::Obstacle(error.to_string()) },
        so_far: Box::default(),
    })?;
    let mut recorder = EngineRecorder::new(scene, &motion, sink);
    recorder.begin(&motion)?;
    let broken = step_through(&mut motion, settings, scene.duration_s, &mut recorder)?;
    let time_s = motion.clock.now();
    let outcome = recorder.finish()?;
    match broken {
        None => Ok(outcome),
        Some(reason) => {
            Err(BodiesRunError::Simulation { failure: Failure { time_s, reason }, so_far: Box::new(outcome) })
        }
    }
}
