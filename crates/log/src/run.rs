//! One call that runs a scene and logs the run. Whoever puts a [`Writer`](super::Writer) behind a run alone has yet to say in
//! it how the run ended; a log that does not is taken for one of a run that was killed.

use std::io::{self, Write};
use std::path::Path;

use super::beside::Beside;
use super::file::{LogError, LogFile, create};
use super::listeners::{Ran, simulate};
use super::metadata::RunInfo;
use phalanx_core::check::{self, Check};
use phalanx_core::criteria::{Criteria, Rebound};
use phalanx_core::scene::Scene;
use phalanx_core::trace::{Model, Outcome, RunError, SinkError};

/// The name of the scene in a log: a scene in memory has none.
const SCENE_FILE: &str = "scene.toml";
/// What errors call a log that is no file.
const NAMELESS: &str = "the log";

/// A run that was completed; its log says the same.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedRun {
    pub outcome: Outcome,
    /// Of a finger, if it can grasp its object.
    pub criteria: Option<Criteria>,
    /// Of every pair of discs; empty where there is a finger.
    pub rebounds: Vec<Rebound>,
    /// Sentences on what makes the results doubtful; empty for a sound run.
    pub warnings: Vec<String>,
    /// What a check of the run found; none is made of runs of more than [`check::MOST_STEPS`] steps.
    pub check: Option<Check>,
}

/// Why a scene was not run to its end, or has no log.
#[derive(Debug, thiserror::Error)]
pub enum LoggedRunError {
    /// There can be no log: nothing has been simulated.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The simulation ended before its time, or its log could not be written.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Runs a scene with one of the models, and writes the log that `phalanx run --log` would: of the scene as it is, also
/// where it was changed since it was read.
///
/// ```
/// use phalanx_core::{scene, trace::Model};
///
/// let text = std::fs::read_to_string("../../scenes/experiment-95.toml")?;
/// let mut scene = scene::parse(&text, "experiment-95.toml")?;
/// scene.duration_s = 5e-3;
/// # let directory = tempfile::tempdir()?;
/// # let path = directory.path().join("run.mcap");
/// let run = phalanx_log::run_to(&scene, Model::Analytic, &path)?;
/// let read = phalanx_log::read_file(&path, &mut ())?;
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
pub fn run_to(scene: &Scene, model: Model, path: impl AsRef<Path>) -> Result<LoggedRun, LoggedRunError> {
    let (run, log) = run_logged(scene, model, create(path.as_ref(), &info(scene, model))?);
    let kept = log.and_then(LogFile::keep);
    let run = run?;
    kept.map_err(RunError::from)?;
    Ok(run)
}

/// The same into anything that takes bytes, which is handed back.
///
/// # Errors
/// As [`run_to`].
pub fn run_into<W: Write + Send + 'static>(
    scene: &Scene,
    model: Model,
    out: W,
) -> Result<(LoggedRun, W), LoggedRunError> {
    let log = Beside::start(out, NAMELESS, &info(scene, model), None, || {}).map_err(LogError::Start)?;
    let (run, log) = run_logged(scene, model, log);
    let run = run?;
    Ok((run, log.map_err(RunError::from)?))
}

fn info(scene: &Scene, model: Model) -> RunInfo<'_> {
    RunInfo { scene, scene_file: SCENE_FILE, model: model.name() }
}

/// Simulates, checks a run that is not too long for it, says in the log how it ended, and finishes that.
fn run_logged<W: Write + Send + 'static>(
    scene: &Scene,
    model: Model,
    log: Beside<W>,
) -> (Result<LoggedRun, RunError>, Result<W, SinkError>) {
    let Ran { result, criteria, rebounds, warnings, last_s, log, .. } = simulate(model, scene, Some(log), &mut ());
    let (work, stopped) = match &result {
        Ok(outcome) => (Some(outcome.work), None),
        Err(RunError::Simulation { failure, so_far }) => {
            (Some(so_far.work), Some((failure.time_s, failure.reason.to_string())))
        }
        Err(RunError::Sink(error)) => (None, Some((last_s, error.to_string()))),
    };
    let stopped = stopped.as_ref().map(|(time_s, reason)| (*time_s, reason.as_str()));
    let short = work.is_some_and(|work| work.steps <= check::MOST_STEPS);
    let check = match stopped {
        Some((time_s, reason)) => Some(Check::not_completed(model, time_s, reason)),
        None => short.then(|| check::check(model, scene, &|| true)),
    };
    let closed = log.close(stopped, check.as_ref());
    let gone = || SinkError { what: NAMELESS.to_string(), source: io::Error::other("it was never begun") };
    let closed = closed.and_then(|out| out.ok_or_else(gone));
    (result.map(|outcome| LoggedRun { outcome, criteria, rebounds, warnings, check }), closed)
}
