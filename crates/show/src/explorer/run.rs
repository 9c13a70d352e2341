//! Runs: as playback and figures, as comma-separated values, checked, or many at once for a map.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::figures::{figures, leaves, verdict};
use super::request::Request;
use crate::check;
use crate::criteria::{LinkOverlap, RunCriteria, RunCriteriaTracker};
use crate::invariants::EnergyAudit;
use crate::playback::{PlaybackRecorder, json};
use crate::report::check::{RunCheckReport, summary_line};
use crate::report::document::{Failure, RunData, RunReport};
use crate::report::samples::{csv_head, csv_sample};
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::trace::{
    Channel, Decimated, Event, Model, RequiredData, RunError, Sample, Schema, Sink, SinkError, run_analytic,
};

/// Runs a scene; `sink` also receives the samples. As on the command line, criteria are evaluated on the samples that a
/// log would contain.
fn simulate(scene: &Scene, sink: &mut impl Sink) -> RunReport {
    let listeners = Listeners {
        criteria_tracker: RunCriteriaTracker::for_scene(scene),
        audit: EnergyAudit::new(Model::Analytic, scene),
        sink,
    };
    let mut decimated = Decimated::new(scene.log.numeric_hz, listeners);
    let result = run_analytic(scene, &mut decimated);
    // No sink here returns an error.
    let _ = decimated.end();
    let energy = decimated.sink.audit.violation().map(|breach| breach.to_string());
    let RunCriteria { criteria, grasp, rebounds, overlaps } = decimated.sink.criteria_tracker.finish(result.is_ok());
    let (outcome, error) = match result {
        Ok(outcome) => (Some(outcome), None),
        Err(RunError::Simulation { failure, partial_outcome }) => {
            (Some(*partial_outcome), Some(Failure { time_s: failure.time_s, reason: failure.reason.to_string() }))
        }
        Err(RunError::Sink(error)) => (None, Some(Failure { time_s: 0.0, reason: error.to_string() })),
    };
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
        "text": summary_line(Some(&report), None),
        "error": found.errors.path,
        "bar": found.max_path_error,
        "report": report,
    })
}

/// Runs every point of a map. Appends the numerical figures to `numbers` row by row, NaN if a run lacks a figure;
/// figures in words are returned under `words`. A point with an invalid scene has neither.
pub fn criteria(request: &Request, numbers: &mut Vec<f64>) -> Value {
    let (mut rows, mut refused) = (Vec::new(), Vec::new());
    for point in &request.points {
        let set: Vec<(String, String)> = request.fields.iter().cloned().zip(point.iter().cloned()).collect();
        let (row, problem) = match request.scene(&set) {
            Ok(scene) => (leaves(&simulate(&scene, &mut ())), Value::Null),
            Err(problems) => (Vec::new(), problems[0]["message"].clone()),
        };
        rows.push(row);
        refused.push(problem);
    }
    let mut columns: Vec<&str> = Vec::new();
    let mut words: BTreeMap<&str, Vec<Option<&str>>> = BTreeMap::new();
    for (key, value) in rows.iter().flatten() {
        if value.is_number() && !columns.contains(&key.as_str()) {
            columns.push(key);
        } else if value.is_string() {
            words.entry(key).or_default();
        }
    }
    for row in &rows {
        let leaf = |key: &str| row.iter().find(|(known, _)| known == key).map(|(_, value)| value);
        numbers.extend(columns.iter().map(|column| leaf(column).and_then(Value::as_f64).unwrap_or(f64::NAN)));
        words.iter_mut().for_each(|(key, list)| list.push(leaf(key).and_then(Value::as_str)));
    }
    json!({ "columns": columns, "words": words, "refused": refused })
}

/// Returns the samples in the format of `phalanx replay --csv`.
pub fn samples(scene: &Scene) -> Result<Value, Value> {
    let mut lines = CsvSink { channels: Schema::from_system(&scene.system).channels(), text: Vec::new() };
    csv_head(&mut lines.text, &lines.channels).expect("writing to memory cannot fail");
    let mut decimated = Decimated::new(scene.log.numeric_hz, lines);
    // A run that fails early has the samples up to its failure.
    let result = run_analytic(scene, &mut decimated);
    let _ = decimated.end();
    match result {
        Err(RunError::Sink(error)) => Err(json!([{ "message": error.to_string(), "help": "" }])),
        _ => Ok(json!({ "text": String::from_utf8_lossy(&decimated.sink.text) })),
    }
}

struct CsvSink {
    channels: Vec<Channel>,
    text: Vec<u8>,
}

impl Sink for CsvSink {
    fn required_data(&self) -> RequiredData {
        RequiredData::ALL
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        csv_sample(&mut self.text, &self.channels, sample).expect("writing to memory cannot fail");
        Ok(())
    }
}
