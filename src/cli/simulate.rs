//! One simulation with everything that listens to it: `phalanx run`, `validate --out` and `replay --verify` all go through
//! here, so that what a log should hold is decided in one place.

use std::io::Write;
use std::time::Instant;

use super::interrupt::Interrupt;
use super::output::complain;
use super::progress::Progress;
use crate::check::{self, Check};
use crate::criteria::{AtRest, Criteria, Rebound, Rebounds, Tracker, at_rest};
use crate::integrator;
use crate::log::{self, Beside, BodiesChannels, CHECK_NAME, Channels, FingerChannels, Severity};
use crate::report;
use crate::scene::{BodiesScene, Scene};
use crate::trace::bodies::{BodiesEvent, BodiesOutcome, BodiesRunError, BodiesSample, BodiesSink, run_bodies};
use crate::trace::{self, Event, Model, Outcome, RunError, Sample, Sink, SinkError, Thinned};

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
    let grasp = grasp(scene);
    let tracker = grasp.as_ref().map(|grasp| Tracker::new(grasp.angles()));
    let progress = progress(scene.duration_s, limits);
    let sinks = Sinks { log, found: tracker, last_s: 0.0, progress, limits, also };
    let mut thinned = Thinned::new(scene.log.numeric_hz, sinks);
    let start = Instant::now();
    let result = trace::run(model, scene, &mut thinned);
    let wall_s = start.elapsed().as_secs_f64();
    let last = thinned.end();
    let mut sinks = thinned.sink;
    sinks.progress.clear();
    let found = sinks.found.as_ref().zip(grasp).filter(|_| result.is_ok());
    let found = found.map(|(tracker, grasp)| tracker.criteria(grasp.is_stable()));
    let result = result.map_err(|error| match error {
        RunError::Simulation { failure, so_far } => stopped(failure, Some(*so_far), limits.interrupt),
        RunError::Sink(error) => failed(&error, sinks.last_s),
    });
    let steps = steps(&result, |outcome| outcome.work.steps);
    let check = limits.check(steps, |go_on| check::check(model, scene, go_on));
    let close = |mut log: Beside<W, FingerChannels>| {
        last?;
        if let Some(criteria) = &found {
            log.note(sinks.last_s, Severity::Info, "grasp", &verdict(criteria))?;
        }
        close(log, sinks.last_s, result.as_ref().err(), check.as_ref())
    };
    let log = sinks.log.map(close).transpose();
    Simulated { result, found, wall_s, check, log }
}

/// Simulates discs.
pub(super) fn bodies<W: Write + Send + 'static>(
    model: Model,
    scene: &BodiesScene,
    log: Option<Beside<W, BodiesChannels>>,
    limits: &Limits<'_>,
    also: &mut impl BodiesSink,
) -> Simulated<W, BodiesOutcome, Vec<Rebound>> {
    let rebounds = Rebounds::new(scene.pairs().len());
    let progress = progress(scene.duration_s, limits);
    let sinks = Sinks { log, found: rebounds, last_s: 0.0, progress, limits, also };
    let mut thinned = Thinned::new(scene.log.numeric_hz, sinks);
    let start = Instant::now();
    let result = run_bodies(model, scene, &mut thinned);
    let wall_s = start.elapsed().as_secs_f64();
    let last = thinned.end();
    let mut sinks = thinned.sink;
    sinks.progress.clear();
    let result = result.map_err(|error| match error {
        BodiesRunError::Simulation { failure, so_far } => stopped(failure, Some(*so_far), limits.interrupt),
        BodiesRunError::Sink(error) => failed(&error, sinks.last_s),
    });
    let steps = steps(&result, |outcome| outcome.work.steps);
    let check = limits.check(steps, |go_on| check::check_bodies(model, scene, go_on));
    let close = |log| {
        last?;
        close(log, sinks.last_s, result.as_ref().err(), check.as_ref())
    };
    let log = sinks.log.map(close).transpose();
    Simulated { result, found: sinks.found.pairs().to_vec(), wall_s, check, log }
}

/// Steps of a run, whether it was completed or not.
fn steps<O>(result: &Result<O, Broken<O>>, of: impl Fn(&O) -> u64) -> u64 {
    match result {
        Ok(outcome) => of(outcome),
        Err(broken) => broken.so_far.as_ref().map_or(0, of),
    }
}

/// Says in the log what a check found.
fn record<W: Write + Send + 'static, C: Channels>(
    log: &mut Beside<W, C>,
    check: Option<&Check>,
) -> Result<(), SinkError> {
    check.map_or(Ok(()), |check| log.record(CHECK_NAME, log::check_entries(check)))
}

/// How far a run has come of how far it goes.
fn progress(duration_s: f64, limits: &Limits<'_>) -> Progress {
    Progress::new(duration_s.min(limits.until_s))
}

fn stopped<O>(failure: integrator::Failure, so_far: Option<O>, interrupt: &Interrupt) -> Broken<O> {
    let reason = interrupt.reason(&failure.reason);
    Broken { error: report::Failure { time_s: failure.time_s, reason }, so_far }
}

fn failed<O>(error: &SinkError, last_s: f64) -> Broken<O> {
    Broken { error: report::Failure { time_s: last_s, reason: error.to_string() }, so_far: None }
}

/// Says in the log how the run ended, and finishes it.
fn close<W: Write + Send + 'static, C: Channels, O>(
    mut log: Beside<W, C>,
    last_s: f64,
    broken: Option<&Broken<O>>,
    check: Option<&Check>,
) -> Result<W, SinkError> {
    let (time_s, severity, text) = match broken {
        None => (last_s, Severity::Info, "completed".to_string()),
        Some(Broken { error, .. }) => (error.time_s, Severity::Error, format!("stopped: {}", error.reason)),
    };
    log.note(time_s, severity, "run", &text)?;
    // Last of all: it ends a chunk.
    record(&mut log, check)?;
    log.finish()
}

/// What the log says of the grasp in the end.
fn verdict(criteria: &Criteria) -> String {
    let ms = |time_s: f64| format!("{:.6} ms", time_s * 1e3);
    let class = criteria.class.name();
    if !criteria.statically_stable {
        return format!("{class}: at rest a phalanx would have to pull");
    }
    match (criteria.tts_s, criteria.rebound_percent, criteria.t_geo_s) {
        (Some(tts_s), Some(rebound), _) => {
            format!("{class}: both phalanges hold for good from {}, rebounds {rebound:.3} %", ms(tts_s))
        }
        (_, _, Some(t_geo_s)) => {
            format!("{class}: in position from {}, but not held by both phalanges in the end", ms(t_geo_s))
        }
        _ => format!("{class}: the finger never came into position"),
    }
}

/// The grasp at rest that a run is judged by; `None`, and said why, if the criteria make no sense for this scene.
pub(super) fn grasp(scene: &Scene) -> Option<AtRest> {
    at_rest(scene, scene.object?)
        .map_err(|error| complain(&format!("no dynamic criteria, for the finger cannot grasp this object: {error}")))
        .ok()
}

/// Everything that listens to a run; `found` is the tracker of criteria or rebounds.
struct Sinks<'a, W: Write + Send + 'static, C: Channels, F, A> {
    log: Option<Beside<W, C>>,
    found: F,
    /// Time of the latest sample.
    last_s: f64,
    progress: Progress,
    limits: &'a Limits<'a>,
    /// Whoever else wants what the log gets.
    also: &'a mut A,
}

impl<W: Write + Send + 'static, A: Sink> Sink for Sinks<'_, W, FingerChannels, Option<Tracker>, A> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.last_s = sample.time_s;
        Sink::sample(&mut self.progress, sample)?;
        self.found.sample(sample)?;
        self.also.sample(sample)?;
        self.log.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.found.event(event)?;
        self.also.event(event)?;
        self.log.event(event)
    }

    fn proceed(&self) -> bool {
        self.last_s <= self.limits.until_s && self.limits.interrupt.signal().is_none()
    }
}

impl<W: Write + Send + 'static, A: BodiesSink> BodiesSink for Sinks<'_, W, BodiesChannels, Rebounds, A> {
    fn sample(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        self.last_s = sample.time_s;
        BodiesSink::sample(&mut self.progress, sample)?;
        self.found.sample(sample)?;
        self.also.sample(sample)?;
        self.log.sample(sample)
    }

    fn event(&mut self, event: &BodiesEvent) -> Result<(), SinkError> {
        self.found.event(event)?;
        self.also.event(event)?;
        self.log.event(event)
    }

    fn proceed(&self) -> bool {
        self.last_s <= self.limits.until_s && self.limits.interrupt.signal().is_none()
    }
}
