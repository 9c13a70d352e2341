//! The report of a simulated run. Used by `phalanx run` and `validate --out`.

use super::check::RunCheckReport;
use super::document::{Failure, RunData, RunReport};
pub use crate::log::{CheckPolicy, FinishedRun, SimulationOptions};
use crate::scene::Scene;
use crate::trace::{Model, RunError};

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
        cable_events: &run.cable_events,
        warnings: &run.warnings,
    };
    let error = run.stopped.clone().map(|(time_s, reason)| Failure { time_s, reason });
    let check = run.check.as_ref().map(|check| RunCheckReport::new(check, scene.has_joints()));
    RunReport { check, ..RunReport::new(scene, model, &data, error) }
}
