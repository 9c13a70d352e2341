//! A run as it is reported: simulated, judged, checked if that is wanted, its log closed. `phalanx run`, `validate --out` and
//! `replay --verify` make theirs here.

use crate::scene::Scene;
use std::io::Write;

use super::check::RunCheckReport;
use super::document::{Came, Failure, RunReport};
use crate::check::{self, Check};
use crate::criteria::{Criteria, GraspCriteria, Rebound};
use crate::integrator::Reason;
use crate::log::{self, Beside, Ran};
use crate::scene::words::SceneKind;
use crate::trace::{Model, Outcome, RunError, Sink, SinkError};

/// A simulation that is over.
pub struct Finished<W> {
    pub result: Result<Outcome, Broken>,
    /// Of a finger, if it can grasp its object and the run was completed.
    pub criteria: Option<Criteria>,
    /// Of a gripper.
    pub grasp: Option<GraspCriteria>,
    /// Of every pair of discs.
    pub rebounds: Vec<Rebound>,
    /// Sentences on what makes the results doubtful.
    pub warnings: Vec<String>,
    pub wall_s: f64,
    /// What a check of the run found, if one was made.
    pub check: Option<RunCheckReport>,
    /// What the log was written to, finished.
    pub log: Result<Option<W>, SinkError>,
}

/// A run that was not completed.
pub struct Broken {
    pub error: Failure,
    /// What there is of it.
    pub so_far: Option<Outcome>,
}

impl<W> Finished<W> {
    /// What is reported of it.
    pub fn report(&self, model: Model, scene: &Scene) -> RunReport {
        let (outcome, error) = match &self.result {
            Ok(outcome) => (Some(outcome), None),
            Err(Broken { error, so_far }) => (so_far.as_ref(), Some(error.clone())),
        };
        let (grasp, rebounds, warnings) = (self.grasp.as_ref(), self.rebounds.as_slice(), self.warnings.as_slice());
        let came = Came { wall_s: self.wall_s, outcome, criteria: self.criteria, grasp, rebounds, warnings };
        RunReport { check: self.check.clone(), ..RunReport::new(scene, model, &came, error) }
    }
}

/// Whether a run is checked when it is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Checking {
    Never,
    /// Where it costs little: runs of a few thousand steps.
    Cheap,
    Always,
}

/// How a run is made.
pub struct Making<'a> {
    pub checking: Checking,
    /// Whether somebody still wants it; the sink is asked besides.
    pub go_on: &'a dyn Fn() -> bool,
    /// Why a run ended early, in words.
    pub reason: &'a dyn Fn(&Reason) -> String,
}

impl Making<'_> {
    /// Checks a run that is completed and was not broken off by somebody.
    fn check(&self, model: Model, scene: &Scene, result: &Result<Outcome, Broken>) -> Option<Check> {
        match (result, self.checking) {
            (_, Checking::Never) => None,
            (Err(Broken { error, .. }), _) => Some(Check::not_completed(model, error.time_s, &error.reason)),
            (Ok(outcome), Checking::Cheap) if outcome.work.steps > check::MOST_STEPS => None,
            (Ok(_), _) => (self.go_on)().then(|| check::check(model, scene, self.go_on)),
        }
    }
}

/// Simulates a scene; `also` gets what the log gets.
pub fn simulated<W: Write + Send + 'static>(
    model: Model,
    scene: &Scene,
    log: Option<Beside<W>>,
    making: &Making<'_>,
    also: &mut impl Sink,
) -> Finished<W> {
    let Ran { result, criteria, grasp, rebounds, warnings, last_s, wall_s, log } =
        log::simulate(model, scene, log, also);
    let result = result.map_err(|error| match error {
        RunError::Simulation { failure, so_far } => {
            let reason = (making.reason)(&failure.reason);
            Broken { error: Failure { time_s: failure.time_s, reason }, so_far: Some(*so_far) }
        }
        RunError::Sink(error) => Broken { error: Failure { time_s: last_s, reason: error.to_string() }, so_far: None },
    });
    let check = making.check(model, scene, &result);
    let stopped = result.as_ref().err().map(|broken| (broken.error.time_s, broken.error.reason.as_str()));
    let log = log.close(stopped, check.as_ref());
    let check = check.map(|check| RunCheckReport::new(&check, scene.kind() != SceneKind::Bodies));
    Finished { result, criteria, grasp, rebounds, warnings, wall_s, check, log }
}
