//! Builds the engine model of a scene, and advances it.

use super::engine_reading::{JointForces, read_state};
use super::engine_recorder::{EngineRecorder, EngineRecorderState, describe_not_finite};
use super::grid::RecordingOptions;
use super::stepper::{Interruption, Stepper};
use super::{Outcome, RunError, Sample, Sink, SinkError};
use crate::drive::Profile;
use crate::engine::{Motion, StepError, Tolerance, build_plan, build_world, next_step};
use crate::integrator::{Failure, Reason};
use crate::scene::{Engine, Scene, Stepping};

/// Contact sub-steps allowed per step of the budget. A step with hard contacts can take 100,000 sub-steps, so a budget
/// of steps alone would not bound the computing time. Ordinary runs need one to four.
const SUBSTEPS_PER_STEP: u64 = 10;

/// Smallest fraction of a step that is tried when longer steps would open the joints too far.
const MIN_STEP_FRACTION: f64 = 1e-9;

/// Builds the engine model of a scene at its start. `scene.engine.max_steps` limits the number of its steps, and ten
/// times as many contact sub-steps.
///
/// # Errors
/// Returns an error if the scene is rejected.
pub(super) fn build_engine(scene: &Scene, recording: RecordingOptions) -> Result<Box<dyn Stepper>, RunError> {
    let initial_outcome = || match scene.finger_count() {
        1 => Outcome::stationary_finger(),
        _ => Outcome::default(),
    };
    let reason = unsupported(scene).map(str::to_owned);
    let plan = reason.map_or_else(|| build_plan(scene), Err);
    let plan = plan.map_err(|reason| RunError::rejected(reason, initial_outcome()))?;
    let engine = &scene.engine;
    let world = build_world(&plan, engine.response, engine.iterations);
    let mut motion =
        Motion::new(plan, world).map_err(|error| RunError::rejected(error.to_string(), initial_outcome()))?;
    let recorder = EngineRecorderState::new(scene, &mut motion, recording);
    // With the forces of joints, which the last sample of a run contains.
    let mut start = recorder.last().clone();
    JointForces::new(true, &mut motion).set(&motion, &mut start);
    if let Some(reason) = describe_not_finite(scene, &start) {
        return Err(RunError::rejected(reason, initial_outcome()));
    }
    motion.contact.tolerance = Tolerance::from_stepping(engine.stepping);
    if let Stepping::Adaptive { tolerance_m, .. } = engine.stepping {
        motion.tolerance_m = tolerance_m;
    }
    Ok(Box::new(EngineStepper { scene: scene.clone(), motion, recorder, steps: 0, substeps: 0 }))
}

/// Returns why the engine model does not simulate the scene.
fn unsupported(scene: &Scene) -> Option<&'static str> {
    let has_unsupported_contact = scene.mechanism.is_some() && scene.has_joints() && !scene.engine.uses_laws();
    has_unsupported_contact.then_some(
        "rapier's own contact (law \"rapier\") is for fingers and free bodies, not for mechanisms with joints",
    )
}

/// The engine model of a scene, and its recorder. Its steps end at the times to which it advances.
#[derive(Clone)]
struct EngineStepper {
    scene: Scene,
    motion: Motion,
    recorder: EngineRecorderState,
    steps: u64,
    substeps: u64,
}

impl EngineStepper {
    fn recorder<'a>(&'a mut self, sink: &'a mut dyn Sink) -> (EngineRecorder<'a>, &'a mut Motion) {
        (EngineRecorder { scene: &self.scene, sink, state: &mut self.recorder }, &mut self.motion)
    }

    /// Takes one step, which ends at `end_s` at the latest; returns the reason if the run cannot continue.
    fn step(&mut self, end_s: f64, sink: &mut dyn Sink) -> Result<Option<Reason>, SinkError> {
        let Engine { max_steps, stepping, .. } = self.scene.engine;
        let (steps, budget) = (self.steps, max_steps.saturating_mul(SUBSTEPS_PER_STEP));
        if steps == max_steps {
            return Ok(Some(Reason::Budget(max_steps)));
        }
        if self.substeps >= budget {
            return Ok(Some(Reason::SubstepBudget { budget, steps }));
        }
        let (mut recorder, motion) = self.recorder(sink);
        let stop_s = end_s.min(motion.clock.now() + recorder.time_to_exit_s());
        let dt = next_step(motion, stepping, stop_s);
        if let Err(error) = advance(motion, dt, &|| recorder.should_continue()) {
            return Ok(Some(match recorder.should_continue() {
                true => Reason::Obstacle(error.to_string()),
                false => Reason::Stopped,
            }));
        }
        recorder.state.joint_forces.update(motion);
        recorder.step(motion)?;
        let obstacle = || recorder.describe_obstacle(motion);
        let reason = match recorder.state.failure.clone().or_else(obstacle) {
            Some(reason) => Some(Reason::Obstacle(reason)),
            None => (!recorder.should_continue()).then_some(Reason::Stopped),
        };
        self.steps += 1;
        self.substeps += u64::from(self.motion.contact.substeps);
        Ok(reason)
    }
}

impl Stepper for EngineStepper {
    fn begin(&mut self, sink: &mut dyn Sink) -> Result<(), SinkError> {
        let (mut recorder, motion) = self.recorder(sink);
        recorder.begin(motion)
    }

    fn advance(&mut self, t: f64, sink: &mut dyn Sink) -> Result<(), Interruption> {
        while self.motion.clock.now() < t {
            if let Some(reason) = self.step(t, sink)? {
                return Err(Failure { time_s: self.motion.clock.now(), reason }.into());
            }
        }
        Ok(())
    }

    fn read(&self, t: f64, sample: &mut Sample) {
        sample.clone_from(self.recorder.last());
        sample.time_s = t;
        read_state(&self.motion, sample);
    }

    fn set_input(&mut self, _: f64, index: usize, input: Profile, _: &mut dyn Sink) -> Result<(), Interruption> {
        self.motion.set_input(index, input);
        Ok(())
    }

    fn remove_contacts(&mut self, _: f64, contacts: &[usize], _: &mut dyn Sink) -> Result<(), Interruption> {
        self.motion.remove_contacts(contacts);
        Ok(())
    }

    fn finish(&mut self, sink: &mut dyn Sink) -> Outcome {
        let (mut recorder, motion) = self.recorder(sink);
        recorder.complete_last(motion);
        recorder.finish()
    }

    fn clone_boxed(&self) -> Box<dyn Stepper> {
        Box::new(self.clone())
    }
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
