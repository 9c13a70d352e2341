//! Simulates a scene for a report: runs it, evaluates its criteria, optionally checks it and closes its log. Used by
//! `phalanx run`, `validate --out` and `replay --verify`.

use std::io::Write;

use super::check::RunCheckReport;
use super::document::{Failure, RunData, RunReport};
use crate::check::{self, Check};
use crate::integrator::Reason;
use crate::log::{self, FinishedRun, ThreadedWriter};
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::trace::{Model, Outcome, RunError, Sink, SinkError};

/// A finished simulation.
pub struct SimulatedRun<W> {
    pub result: Result<Outcome, FailedRun>,
    /// Report of the run, with the result of its check if it was checked.
    pub report: RunReport,
    /// The output of the closed log.
    pub log: Result<Option<W>, SinkError>,
}

/// A run that was not completed.
pub struct FailedRun {
    pub error: Failure,
    /// Results up to the failure.
    pub partial_outcome: Option<Outcome>,
}

/// Whether a completed run is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CheckPolicy {
    Never,
    /// Checks only runs of up to a few thousand steps.
    IfCheap,
    Always,
}

/// Options of a simulation.
pub struct SimulationOptions<'a> {
    pub check_policy: CheckPolicy,
    /// Returns whether to continue. The sink can also stop the run.
    pub keep_running: &'a dyn Fn() -> bool,
    /// Describes why a run ended early.
    pub describe_reason: &'a dyn Fn(&Reason) -> String,
}

impl SimulationOptions<'_> {
    /// Checks a run, unless it was interrupted or the policy excludes it.
    fn check(&self, model: Model, scene: &Scene, result: &Result<Outcome, FailedRun>) -> Option<Check> {
        match (result, self.check_policy) {
            (_, CheckPolicy::Never) => None,
            (Err(FailedRun { error, .. }), _) => Some(Check::not_completed(model, error.time_s, &error.reason)),
            (Ok(outcome), CheckPolicy::IfCheap) if outcome.work.steps > check::MAX_CHECKED_STEPS => None,
            (Ok(_), _) => (self.keep_running)().then(|| check::check(model, scene, self.keep_running)),
        }
    }
}

/// Simulates a scene. `extra_sink` receives the same samples and events as the log.
pub fn simulate_and_check<W: Write + Send + 'static>(
    model: Model,
    scene: &Scene,
    log: Option<ThreadedWriter<W>>,
    options: &SimulationOptions<'_>,
    extra_sink: &mut impl Sink,
) -> SimulatedRun<W> {
    let FinishedRun { result, criteria, grasp, rebounds, warnings, last_s, wall_s, log } =
        log::simulate(model, scene, log, extra_sink);
    let result = result.map_err(|error| match error {
        RunError::Simulation { failure, partial_outcome } => {
            let reason = (options.describe_reason)(&failure.reason);
            FailedRun { error: Failure { time_s: failure.time_s, reason }, partial_outcome: Some(*partial_outcome) }
        }
        RunError::Sink(error) => {
            FailedRun { error: Failure { time_s: last_s, reason: error.to_string() }, partial_outcome: None }
        }
    });
    let check = options.check(model, scene, &result);
    let failure = result.as_ref().err().map(|failed_run| (failed_run.error.time_s, failed_run.error.reason.as_str()));
    let log = log.close(failure, check.as_ref());
    let (outcome, error) = match &result {
        Ok(outcome) => (Some(outcome), None),
        Err(FailedRun { error, partial_outcome }) => (partial_outcome.as_ref(), Some(error.clone())),
    };
    let (grasp, rebounds, warnings) = (grasp.as_ref(), rebounds.as_slice(), warnings.as_slice());
    let data = RunData { wall_s, outcome, criteria, grasp, rebounds, warnings };
    let check = check.map(|check| RunCheckReport::new(&check, scene.kind() != SceneKind::Bodies));
    let report = RunReport { check, ..RunReport::new(scene, model, &data, error) };
    SimulatedRun { result, report, log }
}
