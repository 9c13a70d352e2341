//! Runs the engine model of a scene and reports the run to a sink.

use super::engine_recorder::EngineRecorder;
use super::grid::Span;
use super::{Outcome, RunError, Sink, SinkError};
use crate::engine::{Motion, StepError, Tolerance, build_plan, build_world, next_step};
use crate::integrator::{Failure, Reason};
use crate::scene::keywords::SceneKind;
use crate::scene::{Construction, Engine, Scene, Stepping};

/// Contact sub-steps allowed per step of the budget. A step with hard contacts can take 100,000 sub-steps, so a budget
/// of steps alone would not bound the computing time. Ordinary runs need one to four.
const SUBSTEPS_PER_STEP: u64 = 10;

/// Smallest fraction of a step that is tried when longer steps would open the joints too far.
const MIN_STEP_FRACTION: f64 = 1e-9;

/// Simulates `scene` with the engine model and the settings in `scene.engine`.
///
/// `scene.engine.max_steps` limits the number of steps, and ten times as many contact sub-steps.
///
/// The sink receives a sample at every point of the grid `scene.log.numeric_hz` (interpolated between steps, so logging
/// does not change the run), at every step shorter than the grid interval, and at both ends; and every event, in order
/// of time.
///
/// # Errors
/// Returns an error if the scene is rejected, the sink fails, or the simulation does not complete.
pub fn run_engine(scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let initial_outcome = || match scene.kind() {
        SceneKind::Finger => Outcome::stationary_finger(),
        _ => Outcome::default(),
    };
    let reason = unsupported(scene).map(str::to_owned);
    let plan = reason.map_or_else(|| build_plan(scene), Err);
    let plan = plan.map_err(|reason| RunError::rejected(reason, initial_outcome()))?;
    let engine = &scene.engine;
    let world = build_world(&plan, engine.construction, engine.response, engine.iterations);
    match Motion::new(&plan, world) {
        Ok(motion) => simulate(motion, scene, sink),
        Err(error) => Err(RunError::rejected(error.to_string(), initial_outcome())),
    }
}

/// Returns why the engine model does not simulate the scene.
fn unsupported(scene: &Scene) -> Option<&'static str> {
    let (kind, is_reduced) = (scene.kind(), scene.engine.construction == Construction::Reduced);
    match kind {
        SceneKind::Gripper if is_reduced => {
            Some("joint coordinates (construction \"reduced\") are for one finger, not for grippers")
        }
        SceneKind::Mechanism if is_reduced => {
            Some("joint coordinates (construction \"reduced\") are for one finger, not for mechanisms")
        }
        SceneKind::Mechanism if !scene.engine.uses_laws() => {
            Some("rapier's own contact (law \"rapier\") is for fingers and discs, not for mechanisms")
        }
        SceneKind::Mechanism => None,
        _ => scene.system.unsupported(),
    }
}

/// Simulates a scene from its initial motion.
fn simulate(mut motion: Motion, scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let span = Span::from_scene(scene);
    let mut recorder = EngineRecorder::new(scene, &mut motion, span, sink);
    recorder.begin(&motion)?;
    let failure_reason = step_through(&mut motion, &scene.engine, span.end_s, &mut recorder)?;
    let time_s = motion.clock.now();
    recorder.complete_last(&mut motion);
    let outcome = recorder.finish()?;
    match failure_reason {
        Some(reason) if outcome.ejected_s.is_none() => {
            Err(RunError::Simulation { failure: Failure { time_s, reason }, partial_outcome: Box::new(outcome) })
        }
        _ => Ok(outcome),
    }
}

/// Steps to the end of the run and records every step; returns the reason if the run does not get there.
fn step_through(
    motion: &mut Motion,
    settings: &Engine,
    end_s: f64,
    recorder: &mut EngineRecorder<'_>,
) -> Result<Option<Reason>, SinkError> {
    motion.contact.tolerance = Tolerance::from_stepping(settings.stepping);
    if let Stepping::Adaptive { tolerance_m, .. } = settings.stepping {
        motion.tolerance_m = tolerance_m;
    }
    let (mut steps, mut substeps) = (0, 0);
    let budget = settings.max_steps.saturating_mul(SUBSTEPS_PER_STEP);
    while motion.clock.now() < end_s {
        if steps == settings.max_steps {
            return Ok(Some(Reason::Budget(settings.max_steps)));
        }
        if substeps >= budget {
            return Ok(Some(Reason::SubstepBudget { budget, steps }));
        }
        let stop_s = end_s.min(motion.clock.now() + recorder.time_to_exit_s());
        let dt = next_step(motion, settings.stepping, stop_s);
        if let Err(error) = advance(motion, dt, &|| recorder.should_continue()) {
            return Ok(Some(match recorder.should_continue() {
                true => Reason::Obstacle(error.to_string()),
                false => Reason::Stopped,
            }));
        }
        steps += 1;
        substeps += u64::from(motion.contact.substeps);
        recorder.joint_forces.update(motion);
        recorder.step(motion)?;
        let lifted = || recorder.describe_lifted(motion);
        if let Some(reason) = recorder.failure.clone().or_else(lifted) {
            return Ok(Some(Reason::Obstacle(reason)));
        }
        if !recorder.should_continue() {
            return Ok(Some(Reason::Stopped));
        }
    }
    Ok(None)
}

/// Takes one step, shorter than `dt` if it would open the joints too far.
fn advance(motion: &mut Motion, dt: f64, keep_running: &dyn Fn() -> bool) -> Result<(), StepError> {
    let mut trial_dt = dt;
    loop {
        match motion.advance(trial_dt, keep_running) {
            Err(StepError::TooLong { .. }) if trial_dt > MIN_STEP_FRACTION * dt => trial_dt *= 0.25,
            result => return result,
        }
    }
}
