//! Runs the engine model of a scene and tells a sink about it.

use super::engine_recorder::EngineRecorder;
use super::follow::Follow;
use super::grid::Span;
use super::{Outcome, RunError, Sink, SinkError};
use crate::engine::{Motion, StepError, Tolerance, build, next, plan};
use crate::integrator::{Failure, Reason};
use crate::scene::words::SceneKind;
use crate::scene::{Construction, Engine, Scene, Stepping};

/// Contact sub-steps that the step budget allows, per step: a step of a hard contact may take 100,000 of them, so that a
/// budget of steps alone would not bound the time a run takes. Ordinary runs need one to four.
const SUBSTEPS_PER_STEP: u64 = 10;

/// The shortest part of a step that is tried where the step would tear joints apart.
const SHORTEST_PART: f64 = 1e-9;

/// Simulates `scene` with the engine model, as `scene.engine` says.
///
/// `scene.engine.max_steps` is a budget of steps, and of ten times as many contact sub-steps.
///
/// The sink gets a sample at every point of the grid `scene.log.numeric_hz` (interpolated between steps: what is logged does
/// not change the run), at every step shorter than its interval, and at both ends; and every event, in order of time.
pub fn run_engine(scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    if let Some(why) = scene.system.objection() {
        return Err(unstarted(why.to_string(), Outcome::default()));
    }
    let Scene { system, engine, .. } = scene;
    let kind = scene.kind();
    let unmoved = || if kind == SceneKind::Finger { Outcome::of_unmoved_finger() } else { Outcome::default() };
    let plan = plan(system).map_err(|side| {
        let reason = match kind {
            SceneKind::Gripper => {
                format!("the links of the {} finger do not close their loop at these initial angles", side.word())
            }
            _ => "the links do not close the loop at these initial angles; choose others".to_string(),
        };
        unstarted(reason, unmoved())
    })?;
    if kind == SceneKind::Gripper && engine.construction == Construction::Reduced {
        let reason = "joint coordinates (construction \"reduced\") are for one finger, not for grippers".to_string();
        return Err(unstarted(reason, unmoved()));
    }
    let world = build(&plan, engine.construction, engine.response, engine.iterations);
    match Motion::new(&plan, world) {
        Ok(motion) => simulate(motion, scene, sink),
        Err(error) => Err(unstarted(error.to_string(), unmoved())),
    }
}

/// A run that could not be started, and all there is of it.
fn unstarted(reason: String, so_far: Outcome) -> RunError {
    let failure = Failure { time_s: 0.0, reason: Reason::Obstacle(reason) };
    RunError::Simulation { failure, so_far: Box::new(so_far) }
}

/// Simulates the motion of a scene.
fn simulate(mut motion: Motion, scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let span = Span::of(scene);
    let mut recorder = EngineRecorder::new(scene, &motion, span, sink);
    recorder.begin(&motion)?;
    let broken = step_through(&mut motion, &scene.engine, span.end_s, &mut recorder)?;
    let time_s = motion.clock.now();
    let outcome = recorder.finish()?;
    match broken {
        Some(reason) if outcome.ejected_s.is_none() => {
            Err(RunError::Simulation { failure: Failure { time_s, reason }, so_far: Box::new(outcome) })
        }
        _ => Ok(outcome),
    }
}

/// Steps to the end of the run, and shows every step to `follow`; says why where it does not get there.
fn step_through(
    motion: &mut Motion,
    settings: &Engine,
    end_s: f64,
    follow: &mut impl Follow,
) -> Result<Option<Reason>, SinkError> {
    motion.contact.tolerance = Tolerance::of(settings.stepping);
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
        let stop_s = end_s.min(motion.clock.now() + follow.exit_in_s());
        let dt = next(motion, settings.stepping, stop_s);
        if let Err(error) = advance(motion, dt, &|| follow.proceed()) {
            return Ok(Some(match follow.proceed() {
                true => Reason::Obstacle(error.to_string()),
                false => Reason::Stopped,
            }));
        }
        steps += 1;
        substeps += u64::from(motion.contact.substeps);
        follow.step(motion)?;
        if let Some(reason) = follow.broken() {
            return Ok(Some(Reason::Obstacle(reason.to_string())));
        }
        if !follow.proceed() {
            return Ok(Some(Reason::Stopped));
        }
    }
    Ok(None)
}

/// One step, shorter than `dt` where that would tear the joints apart.
fn advance(motion: &mut Motion, dt: f64, go_on: &dyn Fn() -> bool) -> Result<(), StepError> {
    let mut tried = dt;
    loop {
        match motion.advance_while(tried, go_on) {
            Err(StepError::TooLong { .. }) if tried > SHORTEST_PART * dt => tried *= 0.25,
            result => return result,
        }
    }
}
