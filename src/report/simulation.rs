//! Simulates a scene for a report. Used by `phalanx run`, `validate --out` and `replay --verify`.

use std::io::Write;
use std::mem;

use super::check::RunCheckReport;
use super::document::{Failure, RunData, RunReport};
use crate::log::{self, ThreadedWriter};
pub use crate::log::{CheckPolicy, FinishedRun, SimulationOptions};
use crate::scene::Scene;
use crate::trace::{Model, RunError, Sink, SinkError};

/// A finished simulation.
pub struct SimulatedRun<W> {
    /// Report of the run, with the result of its check if it was checked.
    pub report: RunReport,
    /// Whether a sink failed, so the results of the run are unknown.
    pub has_failed_sink: bool,
    /// The output of the closed log.
    pub log: Result<Option<W>, SinkError>,
}

/// Simulates a scene. `extra_sink` receives the same samples and events as the log.
pub fn simulate_and_check<W: Write + Send + 'static>(
    model: Model,
    scene: &Scene,
    log: Option<ThreadedWriter<W>>,
    options: &SimulationOptions<'_>,
    extra_sink: &mut impl Sink,
) -> SimulatedRun<W> {
    let mut run = log::simulate(model, scene, log, options, extra_sink);
    let log = mem::replace(&mut run.log, Ok(None));
    let has_failed_sink = matches!(run.result, Err(RunError::Sink(_)));
    SimulatedRun { report: report_of(model, scene, &run), has_failed_sink, log }
}

/// Builds the report of a run.
pub fn report_of<W>(model: Model, scene: &Scene, run: &FinishedRun<W>) -> RunReport {
    let outcome = match &run.result {
        Ok(outcome) => Some(outcome),
        Err(RunError::Simulation { partial_outcome, .. }) => Some(&**partial_outcome),
        Err(RunError::Sink(_)) => None,
    };
    let data = RunData {
        wall_s: run.wall_s,
        outcome,
        criteria: run.criteria,
        grasp: run.grasp.as_ref(),
        rebounds: &run.rebounds,
        warnings: &run.warnings,
    };
    let error = run.stopped.clone().map(|(time_s, reason)| Failure { time_s, reason });
    let check = run.check.as_ref().map(|check| RunCheckReport::new(check, scene.has_joints()));
    RunReport { check, ..RunReport::new(scene, model, &data, error) }
}
