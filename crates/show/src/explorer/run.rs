//! A run as playback and figures, and the result of its check.

use serde_json::{Value, json};

use super::figures::{figures, verdict};
use crate::check;
use crate::criteria::{LinkOverlap, RunCriteria, RunCriteriaTracker};
use crate::invariants::EnergyAudit;
use crate::playback::{PlaybackRecorder, json};
use crate::report::check::{self as check_report, RunCheckReport};
use crate::report::document::{Failure, RunData, RunReport};
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::trace::{Decimated, Event, Model, Outcome, RunError, Sample, Sink, SinkError, run_analytic};

/// Runs a scene; `sink` also receives the samples. As on the command line, criteria are evaluated on the samples that a
/// log would contain.
pub fn simulate(scene: &Scene, sink: &mut impl Sink) -> RunReport {
    let audit = EnergyAudit::new(Model::Analytic, scene);
    let mut decimated = Decimated::new(
        scene.log.numeric_hz,
        Listeners { criteria_tracker: RunCriteriaTracker::for_scene(scene), audit, sink },
    );
    let result = run_analytic(scene, &mut decimated);
    // No sink here returns an error.
    let _ = decimated.end();
    let energy = decimated.sink.audit.violation().map(|breach| breach.to_string());
    let RunCriteria { criteria, grasp, rebounds, overlaps } = decimated.sink.criteria_tracker.finish(result.is_ok());
    let (outcome, error) = outcome_and_failure(result);
    let warnings: Vec<String> = energy.into_iter().chain(overlaps.iter().map(LinkOverlap::sentence)).collect();
    let data = RunData {
        wall_s: 0.0,
        outcome: outcome.as_ref(),
        criteria,
        grasp: grasp.as_ref(),
        rebounds: &rebounds,
        warnings: &warnings,
    };
    RunReport::new(scene, Model::Analytic, &data, error)
}

fn outcome_and_failure(result: Result<Outcome, RunError>) -> (Option<Outcome>, Option<Failure>) {
    match result {
        Ok(outcome) => (Some(outcome), None),
        Err(RunError::Simulation { failure, partial_outcome }) => {
            (Some(*partial_outcome), Some(Failure { time_s: failure.time_s, reason: failure.reason.to_string() }))
        }
        Err(RunError::Sink(error)) => (None, Some(Failure { time_s: 0.0, reason: error.to_string() })),
    }
}

/// Returns the playback and the figures of a run.
pub fn run(scene: &Scene, numbers: &mut Vec<f64>) -> Value {
    let mut recorder = PlaybackRecorder::default();
    let report = simulate(scene, &mut recorder);
    let playback = recorder.into_playback(Model::Analytic.name(), scene, "");
    json!({
        "playback": json::append_run(&playback, numbers),
        "figures": figures(&report),
        "verdict": verdict(&report),
        "failed": report.error.as_ref().map(|error| &error.reason),
        "warnings": report.warnings,
        "steps": report.steps,
    })
}

/// Returns the result of the check of a run.
pub fn check(scene: &Scene) -> Value {
    let found = check::check(Model::Analytic, scene, &|| true);
    let report = RunCheckReport::new(&found, scene.kind() != SceneKind::Bodies);
    json!({
        "verdict": found.verdict.name(),
        "text": check_report::summary_line(Some(&report), None),
        "error": found.errors.path,
        "bar": found.max_path_error,
        "report": report,
    })
}

/// Passes samples and events to the judge, the energy audit and one more sink.
struct Listeners<'a, A> {
    criteria_tracker: RunCriteriaTracker,
    audit: EnergyAudit,
    sink: &'a mut A,
}

impl<A: Sink> Sink for Listeners<'_, A> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.criteria_tracker.sample(sample)?;
        self.audit.sample(sample)?;
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.criteria_tracker.event(event)?;
        self.sink.event(event)
    }
}
