//! Common interface of the two models.

use super::analytic::build_analytic;
#[cfg(feature = "engine")]
use super::engine::build_engine;
use super::grid::RecordingOptions;
use super::sampled::with_sampled_servos;
use super::stepper::{Interruption, Stepper};
use super::{Outcome, RunError, Sink};
use crate::scene::{Keyword, Scene};

/// One of the two independent models, which simulates a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    Analytic,
    Engine,
}

impl Model {
    /// Name in commands, reports and logs.
    pub fn name(self) -> &'static str {
        match self {
            Model::Analytic => "analytic",
            Model::Engine => "engine",
        }
    }
}

impl Keyword for Model {
    const KEYWORDS: &'static [(&'static str, Self)] = &[("analytic", Model::Analytic), ("engine", Model::Engine)];
}

/// Simulates a scene of any kind with the given model.
///
/// The sink receives, in order of time, all events, and a sample at the start and at the end of every step. If it needs
/// the grid ([`RequiredData::grid`](super::RequiredData::grid)), it also receives a sample at every point of the grid
/// `scene.log.numeric_hz`. In runs of grippers with the analytic model and more than 1000 grid points, longer steps
/// contain samples at only 4 to 7 of their grid points. Samples on the grid are interpolated within steps, so they do
/// not change the run.
///
/// Without the `engine` feature, runs of the engine model are rejected.
///
/// # Errors
/// Returns an error if the scene is rejected, the sink fails, or the simulation does not complete.
pub fn run(model: Model, scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    run_until_removal(model, scene, Removal { at_s: 0.0, contacts: &[] }, sink)
}

/// Contacts between surfaces that end at a given time, because what they touch is removed.
#[derive(Clone, Copy, Debug)]
pub struct Removal<'a> {
    pub at_s: f64,
    /// Indices among the contacts of samples. Samples after `at_s` contain no forces of these contacts.
    pub contacts: &'a [usize],
}

/// Simulates a mechanism, some of whose contacts end at a given time; see [`run`].
///
/// # Errors
/// See [`run`].
pub fn run_until_removal(
    model: Model,
    scene: &Scene,
    removal: Removal<'_>,
    sink: &mut dyn Sink,
) -> Result<Outcome, RunError> {
    check_supported(scene)?;
    let mut stepper = build(model, scene, RecordingOptions::of_run(scene, sink))?;
    stepper.begin(sink)?;
    let Removal { at_s, contacts } = removal;
    let mut advance = || {
        if !contacts.is_empty() {
            stepper.advance(at_s, sink)?;
            stepper.remove_contacts(at_s, contacts, sink)?;
        }
        stepper.advance(scene.duration_s, sink)
    };
    let result = advance();
    if let Err(Interruption::Sink(error)) = result {
        return Err(error.into());
    }
    let outcome = stepper.finish(sink);
    match result {
        Err(Interruption::Failure(failure)) if outcome.ejected_s.is_none() => {
            Err(RunError::Simulation { failure, partial_outcome: Box::new(outcome) })
        }
        _ => Ok(outcome),
    }
}

/// Simulates a scene with the analytic model, see [`run`].
///
/// # Errors
/// See [`run`].
pub fn run_analytic(scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    run(Model::Analytic, scene, sink)
}

/// Returns an error for a system that neither model simulates, whose samples have no schema.
pub(crate) fn check_supported(scene: &Scene) -> Result<(), RunError> {
    let reason = if scene.mechanism.is_some() { None } else { scene.hand.unsupported() };
    reason.map_or(Ok(()), |reason| Err(RunError::rejected(reason.to_string(), Outcome::default())))
}

/// Builds a model of a scene at its start.
///
/// # Errors
/// Returns an error if the model does not simulate the scene.
pub(super) fn build(model: Model, scene: &Scene, recording: RecordingOptions) -> Result<Box<dyn Stepper>, RunError> {
    with_sampled_servos(scene, |scene| match model {
        Model::Analytic => build_analytic(scene, recording),
        #[cfg(feature = "engine")]
        Model::Engine => build_engine(scene, recording),
        #[cfg(not(feature = "engine"))]
        Model::Engine => Err(RunError::rejected("this build has no engine model".to_string(), Outcome::default())),
    })
}
