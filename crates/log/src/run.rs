//! Runs a scene and logs the run in one call.
//!
//! With a bare [`Writer`](super::Writer) the caller must also write how the run ended; a log without that line counts
//! as the log of a killed run.

use std::io::{self, Write};
use std::path::Path;

use super::file::{LogError, LogFile, create};
use super::metadata::RunInfo;
use super::simulate::{FinishedRun, simulate};
use super::threaded::ThreadedWriter;
use phalanx_core::check::{self, Check};
use phalanx_core::criteria::{Criteria, Rebound};
use phalanx_core::scene::Scene;
use phalanx_core::trace::{Model, Outcome, RunError, SinkError};

/// Name of the scene attachment: a scene in memory has no file name.
const SCENE_FILE: &str = "scene.toml";
/// Name in errors of a log that is not a file.
const UNNAMED_LOG: &str = "the log";

/// Results of a completed run, as stored in its log.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedRun {
    pub outcome: Outcome,
    /// Criteria, only for a single finger that can grasp its object.
    pub criteria: Option<Criteria>,
    /// Rebounds, one per pair of discs; empty for scenes with a finger.
    pub rebounds: Vec<Rebound>,
    /// Reasons to doubt the results, as sentences.
    pub warnings: Vec<String>,
    /// Accuracy check of the run; `None` for runs of more than [`check::MAX_CHECKED_STEPS`] steps.
    pub check: Option<Check>,
}

/// Error for a run that was not completed or not logged.
#[derive(Debug, thiserror::Error)]
pub enum LoggedRunError {
    /// The log could not be created; nothing was simulated.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The simulation ended early or its log could not be written.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Runs a scene with one of the models and writes the same log as `phalanx run --log`. The log contains the scene as
/// passed, including changes made after it was read.
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
/// assert_eq!(read.run_end.unwrap().stopped, None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// The log grows as `PATH.partial` and is renamed when finished, see [`LogFile`]. A run that stops early is an error;
/// its log up to that point remains.
///
/// # Errors
/// Returns [`LoggedRunError`] if the log cannot be created or written, or the run stops early.
pub fn run_to(scene: &Scene, model: Model, path: impl AsRef<Path>) -> Result<LoggedRun, LoggedRunError> {
    let (run, log) = run_logged(scene, model, create(path.as_ref(), &run_info(scene, model))?);
    let committed = log.and_then(LogFile::commit);
    let run = run?;
    committed.map_err(RunError::from)?;
    Ok(run)
}

/// Runs a scene and writes the log to `out`, which is returned.
///
/// # Errors
/// See [`run_to`].
pub fn run_into<W: Write + Send + 'static>(
    scene: &Scene,
    model: Model,
    out: W,
) -> Result<(LoggedRun, W), LoggedRunError> {
    let log = ThreadedWriter::start(out, UNNAMED_LOG, &run_info(scene, model), None, || {}).map_err(LogError::Start)?;
    let (run, log) = run_logged(scene, model, log);
    let run = run?;
    Ok((run, log.map_err(RunError::from)?))
}

fn run_info(scene: &Scene, model: Model) -> RunInfo<'_> {
    RunInfo { scene, scene_file: SCENE_FILE, model: model.name() }
}

/// Simulates a scene, checks the run unless it is too long, writes how it ended and finishes the log.
fn run_logged<W: Write + Send + 'static>(
    scene: &Scene,
    model: Model,
    log: ThreadedWriter<W>,
) -> (Result<LoggedRun, RunError>, Result<W, SinkError>) {
    let FinishedRun { result, criteria, rebounds, warnings, last_s, log, .. } =
        simulate(model, scene, Some(log), &mut ());
    let (work, stopped) = match &result {
        Ok(outcome) => (Some(outcome.work), None),
        Err(RunError::Simulation { failure, partial_outcome }) => {
            (Some(partial_outcome.work), Some((failure.time_s, failure.reason.to_string())))
        }
        Err(RunError::Sink(error)) => (None, Some((last_s, error.to_string()))),
    };
    let stopped = stopped.as_ref().map(|(time_s, reason)| (*time_s, reason.as_str()));
    let is_short = work.is_some_and(|work| work.steps <= check::MAX_CHECKED_STEPS);
    let check = match stopped {
        Some((time_s, reason)) => Some(Check::not_completed(model, time_s, reason)),
        None => is_short.then(|| check::check(model, scene, &|| true)),
    };
    let finished_log = log.close(stopped, check.as_ref());
    let missing_log =
        || SinkError { target: UNNAMED_LOG.to_string(), source: io::Error::other("the log was not started") };
    let finished_log = finished_log.and_then(|out| out.ok_or_else(missing_log));
    (result.map(|outcome| LoggedRun { outcome, criteria, rebounds, warnings, check }), finished_log)
}
