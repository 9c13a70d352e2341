//! A run as film and figures, and what a check finds of it.

use serde_json::{Value, json};

use super::figures::{figures, verdict};
use crate::check;
use crate::criteria::{Judge, Judged, LinkOverlap};
use crate::film::{Reel, data};
use crate::invariants::EnergyAudit;
use crate::report::check::{self as words, RunCheckReport};
use crate::report::document::{Came, Failure, RunReport};
use crate::scene::Scene;
use crate::scene::words::SceneKind;
use crate::trace::{Event, Model, Outcome, RunError, Sample, Sink, SinkError, Thinned, run_analytic};

/// A run with whoever else listens to it; criteria are found on what a log would keep, as the program does it.
pub fn simulated(scene: &Scene, also: &mut impl Sink) -> RunReport {
    let audit = EnergyAudit::new(Model::Analytic, scene);
    let mut listeners = Thinned::new(scene.log.numeric_hz, Both { judge: Judge::of(scene), audit, also });
    let result = run_analytic(scene, &mut listeners);
    // Nobody here refuses a sample.
    let _ = listeners.end();
    let energy = listeners.sink.audit.breach().map(|breach| breach.to_string());
    let Judged { criteria, grasp, rebounds, overlaps } = listeners.sink.judge.judged(result.is_ok());
    let (outcome, error) = came(result);
    let warnings: Vec<String> = energy.into_iter().chain(overlaps.iter().map(LinkOverlap::sentence)).collect();
    let came = Came {
        wall_s: 0.0,
        outcome: outcome.as_ref(),
        criteria,
        grasp: grasp.as_ref(),
        rebounds: &rebounds,
        warnings: &warnings,
    };
    RunReport::new(scene, Model::Analytic, &came, error)
}

fn came(result: Result<Outcome, RunError>) -> (Option<Outcome>, Option<Failure>) {
    match result {
        Ok(outcome) => (Some(outcome), None),
        Err(RunError::Simulation { failure, so_far }) => {
            (Some(*so_far), Some(Failure { time_s: failure.time_s, reason: failure.reason.to_string() }))
        }
        Err(RunError::Sink(error)) => (None, Some(Failure { time_s: 0.0, reason: error.to_string() })),
    }
}

/// Film and figures.
pub fn run(scene: &Scene, numbers: &mut Vec<f64>) -> Value {
    let mut reel = Reel::default();
    let report = simulated(scene, &mut reel);
    let film = reel.film(Model::Analytic.name(), scene, "");
    json!({
        "film": data::beside(&film, numbers),
        "figures": figures(&report),
        "verdict": verdict(&report),
        "failed": report.error.as_ref().map(|error| &error.reason),
        "warnings": report.warnings,
        "steps": report.steps,
    })
}

/// What a check finds of the run.
pub fn check(scene: &Scene) -> Value {
    let found = check::check(Model::Analytic, scene, &|| true);
    let report = RunCheckReport::new(&found, scene.kind() != SceneKind::Bodies);
    json!({
        "verdict": report.verdict,
        "text": words::line(Some(&report), None).map(|said| said.to_string()),
        "error": found.errors.path,
        "bar": found.bar,
        "report": report,
    })
}

/// The judge, the audit of energies, and whoever else.
struct Both<'a, A> {
    judge: Judge,
    audit: EnergyAudit,
    also: &'a mut A,
}

impl<A: Sink> Sink for Both<'_, A> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.judge.sample(sample)?;
        self.audit.sample(sample)?;
        self.also.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.judge.event(event)?;
        self.also.event(event)
    }
}
