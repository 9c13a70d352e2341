//! One call that runs a scene and logs the run. Whoever puts a [`Writer`](super::Writer) behind a run alone has yet to say in
//! it how the run ended; a log that does not is taken for one of a run that was killed.

use std::io::{self, Write};
use std::path::Path;

use super::beside::Beside;
use super::file::{LogError, LogFile, create};
use super::listeners::{Open, bodies, finger};
use super::metadata::{Logged, RunInfo};
use super::writer::Channels;
use crate::check::{self, Check};
use crate::criteria::{Criteria, Rebound};
use crate::integrator::Failure;
use crate::scene::{BodiesScene, Scene};
use crate::trace::bodies::{BodiesOutcome, BodiesRunError};
use crate::trace::{Model, Outcome, RunError, SinkError, Work};

/// The name of the scene in a log: a scene in memory has none.
const SCENE_FILE: &str = "scene.toml";
/// What errors call a log that is no file.
const NAMELESS: &str = "the log";

/// A run that was completed; its log says the same.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedRun<O, F> {
    pub outcome: O,
    /// Criteria of a finger, if it can grasp its object; the restitution of every pair of discs.
    pub found: F,
    /// What a check of the run found; none is made of runs of more than [`check::MOST_STEPS`] steps.
    pub check: Option<Check>,
}

/// Why a scene was not run to its end, or has no log.
#[derive(Debug, thiserror::Error)]
pub enum LoggedRunError<E> {
    /// There can be no log: nothing has been simulated.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The simulation ended before its time, or its log could not be written.
    #[error(transparent)]
    Run(E),
}

/// A kind of scene that can be run and logged by one call.
pub trait Runs: Logged + Clone + Send + 'static {
    type Outcome;
    type Found;
    type Error: From<SinkError>;

    /// Simulates, says in the log how that ended, and finishes it.
    fn run_logged<W: Write + Send + 'static>(&self, model: Model, log: Beside<W, Self::Channels>)
    -> RunAndLog<Self, W>;
}

/// A completed run of a kind of scene.
pub type RunOf<S> = LoggedRun<<S as Runs>::Outcome, <S as Runs>::Found>;

/// What [`run_to`] gives for a kind of scene.
pub type RunResult<S, T = RunOf<S>> = Result<T, LoggedRunError<<S as Runs>::Error>>;

/// A run that is over, and its log, which is too.
pub type RunAndLog<S, W> = (Result<RunOf<S>, <S as Runs>::Error>, Result<W, SinkError>);

/// Runs a scene with one of the models, and writes the log that `phalanx run --log` would: of the scene as it is, also
/// where it was changed since it was read.
///
/// ```
/// use phalanx::{log, scene, trace::Model};
///
/// let mut scene = scene::load("scenes/experiment-95.toml")?;
/// scene.duration_s = 5e-3;
/// # let directory = tempfile::tempdir()?;
/// # let path = directory.path().join("run.mcap");
/// let run = log::run_to(&scene, Model::Analytic, &path)?;
/// let read = log::read_file(&path, &mut ())?;
/// assert_eq!(read.last_s, Some(run.outcome.last.time_s));
/// assert_eq!(read.ended.unwrap().stopped, None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// The log grows as `PATH.partial` and takes its name in the end, see [`LogFile`]. A run that stops before its time is an
/// error, and its log up to there is kept.
///
/// # Errors
/// [`LoggedRunError`] with what could not be done.
pub fn run_to<S: Runs>(scene: &S, model: Model, path: impl AsRef<Path>) -> RunResult<S> {
    let log = create(path.as_ref(), &info(scene, model))?;
    let (run, log) = scene.run_logged(model, log);
    let kept = log.and_then(LogFile::keep);
    let run = run.map_err(LoggedRunError::Run)?;
    kept.map_err(|error| LoggedRunError::Run(error.into()))?;
    Ok(run)
}

/// The same into anything that takes bytes, which is handed back.
///
/// # Errors
/// As [`run_to`].
pub fn run_into<S: Runs, W: Write + Send + 'static>(scene: &S, model: Model, out: W) -> RunResult<S, (RunOf<S>, W)> {
    let log = Beside::start(out, NAMELESS, &info(scene, model), None, || {}).map_err(LogError::Start)?;
    let (run, log) = scene.run_logged(model, log);
    let run = run.map_err(LoggedRunError::Run)?;
    Ok((run, log.map_err(|error| LoggedRunError::Run(error.into()))?))
}

fn info<S>(scene: &S, model: Model) -> RunInfo<'_, S> {
    RunInfo { scene, scene_file: SCENE_FILE, model: model.name() }
}

impl Runs for Scene {
    type Outcome = Outcome;
    type Found = Option<Criteria>;
    type Error = RunError;

    fn run_logged<W: Write + Send + 'static>(
        &self,
        model: Model,
        log: Beside<W, Self::Channels>,
    ) -> RunAndLog<Self, W> {
        let ran = finger(model, self, Some(log), &mut ());
        let end = match &ran.result {
            Ok(outcome) => End::Completed(&outcome.work),
            Err(RunError::Simulation { failure, so_far }) => End::Stopped(failure, &so_far.work),
            Err(RunError::Sink(error)) => End::Unwritten(error, ran.last_s),
        };
        let (check, log) = close(ran.log, &end, || check::check(model, self, &|| true));
        (ran.result.map(|outcome| LoggedRun { outcome, found: ran.found, check }), log)
    }
}

impl Runs for BodiesScene {
    type Outcome = BodiesOutcome;
    type Found = Vec<Rebound>;
    type Error = BodiesRunError;

    fn run_logged<W: Write + Send + 'static>(
        &self,
        model: Model,
        log: Beside<W, Self::Channels>,
    ) -> RunAndLog<Self, W> {
        let ran = bodies(model, self, Some(log), &mut ());
        let end = match &ran.result {
            Ok(outcome) => End::Completed(&outcome.work),
            Err(BodiesRunError::Simulation { failure, so_far }) => End::Stopped(failure, &so_far.work),
            Err(BodiesRunError::Sink(error)) => End::Unwritten(error, ran.last_s),
        };
        let (check, log) = close(ran.log, &end, || check::check_bodies(model, self, &|| true));
        (ran.result.map(|outcome| LoggedRun { outcome, found: ran.found, check }), log)
    }
}

/// How a run ended.
enum End<'a> {
    Completed(&'a Work),
    Stopped(&'a Failure, &'a Work),
    Unwritten(&'a SinkError, f64),
}

/// Checks a run that is not too long for it, and closes its log.
fn close<W: Write + Send + 'static, C: Channels>(
    log: Open<W, C>,
    end: &End<'_>,
    check: impl FnOnce() -> Check,
) -> (Option<Check>, Result<W, SinkError>) {
    let (work, stopped) = match end {
        End::Completed(work) => (Some(work), None),
        End::Stopped(failure, work) => (Some(work), Some((failure.time_s, failure.reason.to_string()))),
        End::Unwritten(error, last_s) => (None, Some((*last_s, error.to_string()))),
    };
    let check = work.filter(|work| work.steps <= check::MOST_STEPS).map(|_| check());
    let stopped = stopped.as_ref().map(|(time_s, reason)| (*time_s, reason.as_str()));
    let closed = log.close(stopped, check.as_ref());
    let gone = || SinkError { what: NAMELESS.to_string(), source: io::Error::other("it was never begun") };
    (check, closed.and_then(|out| out.ok_or_else(gone)))
}
