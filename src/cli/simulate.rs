//! One simulation as a command makes it, `phalanx run`, `validate --out` or `replay --verify`: with a line that says how far it
//! has come, ended by a signal. What its log holds is decided in the library.

use std::io::Write;

use super::interrupt::Interrupt;
use super::output::complain;
use super::progress::Progress;
use crate::check::{self, Check};
use crate::criteria::{AtRest, Criteria, Rebound, at_rest};
use crate::integrator;
use crate::log::{self, Beside, BodiesChannels, FingerChannels, Ran};
use crate::report;
use crate::scene::{BodiesScene, Scene};
use crate::trace::bodies::{BodiesEvent, BodiesOutcome, BodiesRunError, BodiesSample};
use crate::trace::{Event, Model, Outcome, RunError, Sample, Sink, SinkError};

/// A simulation that is over.
pub(super) struct Simulated<W, O, F> {
    pub result: Result<O, Broken<O>>,
    /// Criteria of a finger, restitution of discs.
    pub found: F,
    pub wall_s: f64,
    /// What a check of the run found, if one was made.
    pub check: Option<Check>,
    /// What the log was written to, finished.
    pub log: Result<Option<W>, SinkError>,
}

/// A run that was not completed.
pub(super) struct Broken<O> {
    pub error: report::Failure,
    /// What there is of it.
    pub so_far: Option<O>,
}

impl<O> Broken<O> {
    /// When and why, as its log says it.
    fn words(&self) -> (f64, &str) {
        (self.error.time_s, &self.error.reason)
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

/// Simulates a finger.
pub(super) fn finger<W: Write + Send + 'static>(
    model: Model,
    scene: &Scene,
    log: Option<Beside<W, FingerChannels>>,
    limits: &Limits<'_>,
    also: &mut impl Sink,
) -> Simulated<W, Outcome, Option<Criteria>> {
    grasp(scene);
    let mut watched = Watched::new(scene.duration_s, limits, also);
    let Ran { result, found, last_s, wall_s, log } = log::run_finger(model, scene, log, &mut watched);
    watched.progress.clear();
    let result = result.map_err(|error| match error {
        RunError::Simulation { failure, so_far } => stopped(failure, Some(*so_far), limits.interrupt),
        RunError::Sink(error) => failed(&error, last_s),
    });
    let steps = steps(&result, |outcome| outcome.work.steps);
    let check = limits.check(steps, |go_on| check::check(model, scene, go_on));
    let log = log.close(result.as_ref().err().map(Broken::words), check.as_ref());
    Simulated { result, found, wall_s, check, log }
}

/// Simulates discs.
pub(super) fn bodies<W: Write + Send + 'static>(
    model: Model,
    scene: &BodiesScene,
    log: Option<Beside<W, BodiesChannels>>,
    limits: &Limits<'_>,
    also: &mut impl Sink<BodiesSample>,
) -> Simulated<W, BodiesOutcome, Vec<Rebound>> {
    let mut watched = Watched::new(scene.duration_s, limits, also);
    let Ran { result, found, last_s, wall_s, log } = log::run_bodies(model, scene, log, &mut watched);
    watched.progress.clear();
    let result = result.map_err(|error| match error {
        BodiesRunError::Simulation { failure, so_far } => stopped(failure, Some(*so_far), limits.interrupt),
        BodiesRunError::Sink(error) => failed(&error, last_s),
    });
    let steps = steps(&result, |outcome| outcome.work.steps);
    let check = limits.check(steps, |go_on| check::check_bodies(model, scene, go_on));
    let log = log.close(result.as_ref().err().map(Broken::words), check.as_ref());
    Simulated { result, found, wall_s, check, log }
}

/// Steps of a run, whether it was completed or not.
fn steps<O>(result: &Result<O, Broken<O>>, of: impl Fn(&O) -> u64) -> u64 {
    match result {
        Ok(outcome) => of(outcome),
        Err(broken) => broken.so_far.as_ref().map_or(0, of),
    }
}

fn stopped<O>(failure: integrator::Failure, so_far: Option<O>, interrupt: &Interrupt) -> Broken<O> {
    let reason = interrupt.reason(&failure.reason);
    Broken { error: report::Failure { time_s: failure.time_s, reason }, so_far }
}

fn failed<O>(error: &SinkError, last_s: f64) -> Broken<O> {
    Broken { error: report::Failure { time_s: last_s, reason: error.to_string() }, so_far: None }
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

    fn proceed(&self) -> bool {
        self.last_s <= self.limits.until_s && self.limits.interrupt.signal().is_none()
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
        self.proceed()
    }
}

impl<A: Sink<BodiesSample>> Sink<BodiesSample> for Watched<'_, A> {
    fn sample(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        self.last_s = sample.time_s;
        Sink::sample(&mut self.progress, sample)?;
        self.also.sample(sample)
    }

    fn event(&mut self, event: &BodiesEvent) -> Result<(), SinkError> {
        self.also.event(event)
    }

    fn proceed(&self) -> bool {
        self.proceed()
    }
}
