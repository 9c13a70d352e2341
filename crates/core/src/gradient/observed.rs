//! Runs without derivatives, whose events, criteria and last samples are compared.

use crate::criteria::{Criteria, RunCriteriaTracker};
use crate::scene::Scene;
use crate::trace::{Event, KeepRunning, Model, RequiredData, RunError, Sample, Sink, SinkError, run};

/// Relative tolerance of the runs with derivatives; that of the second one, for the error estimate, is ten times larger.
const RTOL: f64 = 1e-10;

/// The scene at a multiple of the tolerance of runs with derivatives, or of its own if that is smaller.
pub(super) fn at_tolerance(scene: &Scene, factor: f64) -> Scene {
    let rtol = factor * scene.integrator.rtol.min(RTOL);
    Scene { integrator: scene.integrator.with_rtol(rtol), ..scene.clone() }
}

/// Stores events and the largest magnitudes of all numbers, and computes criteria.
pub(super) struct Observation<'a> {
    pub criteria: Option<RunCriteriaTracker>,
    pub events: Vec<Event>,
    pub largest: Vec<f64>,
    pub keep_running: KeepRunning<'a>,
}

impl Sink for Observation<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.largest.resize(sample.values().len(), 0.0);
        for (largest, value) in self.largest.iter_mut().zip(sample.values()).filter(|(_, value)| value.is_finite()) {
            *largest = largest.max(value.abs());
        }
        self.criteria.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.events.push(*event);
        self.criteria.event(event)
    }

    fn required_data(&self) -> RequiredData {
        let of_criteria = self.criteria.as_ref().map_or(RequiredData::NONE, RunCriteriaTracker::required_data);
        RequiredData { passive: true, ..of_criteria }
    }

    fn should_continue(&self) -> bool {
        (self.keep_running)()
    }
}

/// What is compared of two runs.
pub(super) struct Observed {
    pub events: Vec<Event>,
    /// Criteria of a finger.
    pub criteria: Option<Criteria>,
    /// For each number of a sample, its largest magnitude.
    pub largest: Vec<f64>,
    pub last: Sample,
}

pub(super) fn observe(scene: &Scene, keep_running: KeepRunning<'_>) -> Result<Observed, RunError> {
    let criteria = Some(RunCriteriaTracker::for_scene(scene));
    let mut observation = Observation { criteria, events: Vec::new(), largest: Vec::new(), keep_running };
    let outcome = run(Model::Analytic, scene, &mut observation)?;
    let Observation { criteria, events, largest, .. } = observation;
    let criteria = criteria.and_then(|tracker| tracker.finish(true).criteria);
    Ok(Observed { events, criteria, largest, last: outcome.last })
}
