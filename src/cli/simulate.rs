//! One simulation as a command makes it, `phalanx run`, `validate --out` or `replay --verify`: with a line that says how far it
//! has come, ended by a signal. What its log holds is decided in the library.

use std::io::Write;

use super::interrupt::Interrupt;
use super::output::complain;
use super::progress::Progress;
use crate::check::{self, Check};
use crate::criteria::{AtRest, Criteria, GraspCriteria, Rebound, at_rest};
use crate::log::{self, Beside, Ran};
use crate::report::{self, Came, RunCheckReport, RunReport};
use crate::scene::Scene;
use crate::scene::words::SceneKind;
use crate::trace::{Event, Model, Outcome, RunError, Sample, Simulated, Sink, SinkError};

/// A simulation that is over.
pub(super) struct Finished<W> {
    pub result: Result<Outcome, Broken>,
    /// Of a finger, if it can grasp its object and the run was completed.
    pub criteria: Option<Criteria>,
    /// Of a gripper.
    pub grasp: Option<GraspCriteria>,
    /// Of every pair of discs.
    pub rebounds: Vec<Rebound>,
    pub wall_s: f64,
    /// What a check of the run found, if one was made.
    pub check: Option<RunCheckReport>,
    /// What the log was written to, finished.
    pub log: Result<Option<W>, SinkError>,
}

/// A run that was not completed.
pub(super) struct Broken {
    pub error: report::Failure,
    /// What there is of it.
    pub so_far: Option<Outcome>,
}

impl<W> Finished<W> {
    /// What is reported of it.
    pub fn report(&self, model: Model, scene: Simulated<'_>) -> RunReport {
        let (outcome, error) = match &self.result {
            Ok(outcome) => (Some(outcome), None),
            Err(Broken { error, so_far }) => (so_far.as_ref(), Some(error.clone())),
        };
        let (grasp, rebounds) = (self.grasp.as_ref(), self.rebounds.as_slice());
        let came = Came { wall_s: self.wall_s, outcome, criteria: self.criteria, grasp, rebounds };
        RunReport { check: self.check.clone(), ..RunReport::new(scene, model, &came, error) }
    }
}

/// What ends a run before its time: a signal, or that it is past what anybody wants to know.
pub(super) struct Limits<'a> {
    pub interrupt: &'a Interrupt,
    /// The run may end after the first sample beyond.
    pub until_s: f64,
    pub checking: Checking,
}

/// Whether a run is checked when it is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Checking {
    Never,
    /// Where it costs little: runs of a few thousand steps.
    Cheap,
    Always,
}

impl Limits<'_> {
    /// Checks a run that was not broken off by somebody.
    fn check(&self, steps: u64, found: impl FnOnce(&dyn Fn() -> bool) -> Check) -> Option<Check> {
        let wanted = match self.checking {
            Checking::Never => false,
            Checking::Cheap => steps <= check::MOST_STEPS,
            Checking::Always => true,
        };
        let go_on = || self.interrupt.signal().is_none();
        (wanted && go_on()).then(|| found(&go_on))
    }
}

/// Simulates a scene.
pub(super) fn simulate<W: Write + Send + 'static>(
    model: Model,
    scene: Simulated<'_>,
    log: Option<Beside<W>>,
    limits: &Limits<'_>,
    also: &mut impl Sink,
) -> Finished<W> {
    if let Simulated::Finger(scene) = scene {
        grasp(scene);
    }
    let mut watched = Watched::new(scene.duration_s(), limits, also);
    let Ran { result, criteria, grasp, rebounds, last_s, wall_s, log } = log::simulate(model, scene, log, &mut watched);
    watched.progress.clear();
    let result = result.map_err(|error| match error {
        RunError::Simulation { failure, so_far } => {
            let reason = limits.interrupt.reason(&failure.reason);
            Broken { error: report::Failure { time_s: failure.time_s, reason }, so_far: Some(*so_far) }
        }
        RunError::Sink(error) => {
            Broken { error: report::Failure { time_s: last_s, reason: error.to_string() }, so_far: None }
        }
    });
    let outcome = match &result {
        Ok(outcome) => Some(outcome),
        Err(broken) => broken.so_far.as_ref(),
    };
    let steps = outcome.map_or(0, |outcome| outcome.work.steps);
    let check = limits.check(steps, |go_on| check::check(model, scene, go_on));
    let stopped = result.as_ref().err().map(|broken| (broken.error.time_s, broken.error.reason.as_str()));
    let log = log.close(stopped, check.as_ref());
    let check = check.map(|check| RunCheckReport::new(&check, scene.kind() != SceneKind::Bodies));
    Finished { result, criteria, grasp, rebounds, wall_s, check, log }
}

/// The grasp at rest that a run is judged by; `None`, and said why, if the criteria make no sense for this scene.
pub(super) fn grasp(scene: &Scene) -> Option<AtRest> {
    at_rest(scene, scene.object?)
        .map_err(|error| complain(&format!("no dynamic criteria, for the finger cannot grasp this object: {error}")))
        .ok()
}

/// What the command line adds to those who listen to a run: how far it has come, and that it may be ended.
struct Watched<'a, A> {
    /// Time of the latest sample.
    last_s: f64,
    progress: Progress,
    limits: &'a Limits<'a>,
    /// Whoever else wants what the log gets.
    also: &'a mut A,
}

impl<'a, A> Watched<'a, A> {
    fn new(duration_s: f64, limits: &'a Limits<'a>, also: &'a mut A) -> Self {
        // A run may end before it is over.
        let progress = Progress::new(duration_s.min(limits.until_s));
        Watched { last_s: 0.0, progress, limits, also }
    }
}

impl<A: Sink> Sink for Watched<'_, A> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.last_s = sample.time_s;
        Sink::sample(&mut self.progress, sample)?;
        self.also.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.also.event(event)
    }

    fn proceed(&self) -> bool {
        self.last_s <= self.limits.until_s && self.limits.interrupt.signal().is_none()
    }
}
