//! What a validation needs of a kind of scene: settings to change, runs to record and to compare.

use std::error::Error;
use std::fmt::Debug;

use super::{
    Comparison, Differences, GoOn, Recording, Statistics, Verdict, While, compare, ensemble, record_while, statistics,
    verdicts,
};
use crate::check;
use crate::invariants::{Finding, Invariants};
use crate::scene::{Bounds, Engine, Integrator, LogRates, Preset, Scene};
use crate::trace::{Model, RunError, Sink, run};

/// Samples that the grid of a reference has at most: five references of 350 bytes a sample stay below 200 MB.
const MOST_SAMPLES: f64 = 1e5;
/// Finest grid; beyond, interpolation is exact to rounding.
const FINEST_HZ: f64 = 1e6;

/// A scene that can be validated.
pub trait Subject: Clone + Debug + PartialEq {
    type Bounds: Copy + Debug + PartialEq;
    /// Everything a run said.
    type Recording: Clone + Debug + Default + PartialEq;
    /// In what a run differs from its reference.
    type Differences: Clone + Debug + PartialEq;
    type Error: Error + 'static;

    /// Whether the bodies have joints, of which coordinates can be made.
    const JOINTED: bool;

    fn integrator(&self) -> &Integrator;
    fn engine(&self) -> &Engine;
    fn duration_s(&self) -> f64;
    fn bounds(&self) -> Self::Bounds;
    fn numeric_hz(&self) -> f64;
    fn with_integrator(&self, integrator: Integrator) -> Self;
    fn with_engine(&self, engine: Engine) -> Self;
    fn with_numeric_hz(&self, numeric_hz: f64) -> Self;
    /// The scene as the member `index` of the ensemble has it.
    fn member(&self, index: usize) -> Self;
    /// The scene as far as it is run for a validation.
    fn compared(&self) -> Self {
        self.clone()
    }
    /// Static friction of its contacts; `None` if nothing can touch.
    fn touching_friction(&self) -> Option<f64>;

    /// Steps of a run with nothing listening.
    fn steps(&self, model: Model, go_on: GoOn) -> Result<u64, Self::Error>;
    fn record(&self, model: Model, go_on: GoOn) -> Result<Self::Recording, Self::Error>;
    fn recorded_steps(recording: &Self::Recording) -> u64;
    /// Runs, and compares with the reference on the way.
    fn differences(
        &self,
        model: Model,
        reference: &Self::Recording,
        go_on: GoOn,
    ) -> Result<Self::Differences, Self::Error>;
    /// Whether a run ended because it was told to.
    fn is_stop(error: &Self::Error) -> bool;
    /// Compares a run that was kept.
    fn compare(&self, run: &Self::Recording, reference: &Self::Recording) -> Self::Differences;
    /// The worse of each figure.
    fn worse(a: &Self::Differences, b: &Self::Differences) -> Self::Differences;
    fn judge(&self, found: &Self::Differences) -> Verdict;
    /// What a check of the reference says, as far as trajectories are compared.
    fn check_reference(&self, go_on: GoOn) -> check::Check;
    /// What the engine may be off by along the way, in the unit of the errors of a check.
    fn path_bound(&self) -> f64;
    /// How near a kept run came to breaking each invariant.
    fn invariants(&self, model: Model, run: &Self::Recording) -> Vec<Finding>;
    /// Means over many runs beyond the time up to which trajectories are compared, if there is such a time.
    fn statistics(&self, _go_on: GoOn) -> Result<Option<Statistics>, Self::Error> {
        Ok(None)
    }
}

impl Subject for Scene {
    type Bounds = Bounds;
    type Recording = Recording;
    type Differences = Differences;
    type Error = RunError;

    const JOINTED: bool = true;

    fn integrator(&self) -> &Integrator {
        &self.integrator
    }

    fn engine(&self) -> &Engine {
        &self.engine
    }

    fn duration_s(&self) -> f64 {
        self.duration_s
    }

    fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn numeric_hz(&self) -> f64 {
        self.log.numeric_hz
    }

    fn with_integrator(&self, integrator: Integrator) -> Self {
        Scene { integrator, ..self.clone() }
    }

    fn with_engine(&self, engine: Engine) -> Self {
        Scene { engine, ..self.clone() }
    }

    fn with_numeric_hz(&self, numeric_hz: f64) -> Self {
        Scene { log: LogRates { numeric_hz, ..self.log }, ..self.clone() }
    }

    fn member(&self, index: usize) -> Self {
        ensemble::member(self, index)
    }

    fn touching_friction(&self) -> Option<f64> {
        self.object.map(|_| self.contact.proximal.friction.map_or(0.0, |law| law.mu_static))
    }

    fn steps(&self, model: Model, go_on: GoOn) -> Result<u64, RunError> {
        Ok(run(model, self, &mut While { sink: &mut (), go_on })?.work.steps)
    }

    fn record(&self, model: Model, go_on: GoOn) -> Result<Recording, RunError> {
        record_while(model, self, go_on)
    }

    fn recorded_steps(recording: &Recording) -> u64 {
        recording.outcome.work.steps
    }

    fn differences(&self, model: Model, reference: &Recording, go_on: GoOn) -> Result<Differences, RunError> {
        let mut comparison = Comparison::new(reference, &self.bounds);
        let outcome = run(model, self, &mut While { sink: &mut comparison, go_on })?;
        Ok(comparison.finish(&outcome))
    }

    fn is_stop(error: &RunError) -> bool {
        error.is_stop()
    }

    fn compare(&self, run: &Recording, reference: &Recording) -> Differences {
        compare(run, reference, &self.bounds)
    }

    fn worse(a: &Differences, b: &Differences) -> Differences {
        a.worst(b)
    }

    fn judge(&self, found: &Differences) -> Verdict {
        verdicts(found, &self.bounds)
    }

    fn check_reference(&self, go_on: GoOn) -> check::Check {
        let duration_s = self.bounds.until_s.min(self.duration_s);
        check::check(Model::Analytic, &reference(&Scene { duration_s, ..self.clone() }), go_on)
    }

    fn path_bound(&self) -> f64 {
        self.bounds.angle_rad
    }

    fn invariants(&self, model: Model, run: &Recording) -> Vec<Finding> {
        let mut invariants = Invariants::new(model, self);
        for sample in &run.samples {
            invariants.sample(sample).expect("measuring writes nothing");
        }
        invariants.findings(run.outcome.loop_gap_m)
    }

    fn statistics(&self, go_on: GoOn) -> Result<Option<Statistics>, RunError> {
        (self.bounds.until_s < self.duration_s).then(|| statistics(self, go_on)).transpose()
    }
}

/// The scene as the reference runs it: the tightest settings, on a dense grid.
pub fn reference<S: Subject>(scene: &S) -> S {
    sampled(Model::Analytic, &scene.with_integrator(scene.integrator().with_preset(Preset::Reference)))
}

/// The scene with the samples that a comparison needs. The analytic model is exact between its steps, so a dense grid
/// is read off; of the engine every step is taken, and nothing that is interpolated.
pub fn sampled<S: Subject>(model: Model, scene: &S) -> S {
    match model {
        Model::Analytic => {
            let dense_hz = (MOST_SAMPLES / scene.duration_s()).min(FINEST_HZ);
            scene.with_numeric_hz(dense_hz.max(scene.numeric_hz()))
        }
        Model::Engine => steps_only(scene),
    }
}

/// The scene with a sample at every step and at no other time.
pub fn steps_only<S: Subject>(scene: &S) -> S {
    scene.with_numeric_hz(1.0 / scene.duration_s())
}
