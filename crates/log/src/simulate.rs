//! Simulation of a scene with log, criteria and energy audit, also in one call ([`run_to`]). `phalanx run`, `validate
//! --out` and [`run_to`] share this code, so all their logs have the same content.

use std::io::{self, Write};
use std::path::Path;
use std::time::Instant;

use foxglove::messages::log::Level;

use super::file::{LogError, LogFile, create};
use super::metadata::{CHECK_NAME, RunInfo, check_entries};
use super::threaded::ThreadedWriter;
use phalanx_core::check::{self, Check};
use phalanx_core::criteria::{
    Criteria, GraspCriteria, LinkOverlap, Rebound, RunCriteria, RunCriteriaTracker, fate_reason,
};
use phalanx_core::invariants::EnergyAudit;
use phalanx_core::scene::Scene;
use phalanx_core::trace::{Decimated, Event, Model, Outcome, RunError, Sample, Sink, SinkError, run};

/// A finished run and its log, which is still open.
pub struct FinishedRun<W: Write + Send + 'static> {
    pub result: Result<Outcome, RunError>,
    /// Criteria of a completed run of a single finger that can grasp its object.
    pub criteria: Option<Criteria>,
    /// Grasp criteria, only for a gripper.
    pub grasp: Option<GraspCriteria>,
    /// Rebounds, one per pair of discs; empty for scenes with a finger.
    pub rebounds: Vec<Rebound>,
    /// Reasons to doubt the results, as sentences; also written to the log.
    pub warnings: Vec<String>,
    /// Time of the latest sample.
    pub last_s: f64,
    pub wall_s: f64,
    pub log: OpenLog<W>,
}

/// A log that lacks its final lines.
pub struct OpenLog<W: Write + Send + 'static> {
    log: Option<ThreadedWriter<W>>,
    /// Result of writing the last sample.
    last_sample: Result<(), SinkError>,
    last_s: f64,
    /// Final line about the grasp.
    verdict: Option<String>,
    warnings: Vec<String>,
}

/// Simulates a scene. `extra_sink` receives the same samples and events as the log and can stop the run.
pub fn simulate<W: Write + Send + 'static>(
    model: Model,
    scene: &Scene,
    log: Option<ThreadedWriter<W>>,
    extra_sink: &mut impl Sink,
) -> FinishedRun<W> {
    let audit = EnergyAudit::new(model, scene);
    let sinks =
        RunSinks { log, criteria_tracker: RunCriteriaTracker::for_scene(scene), audit, last_s: 0.0, extra_sink };
    let mut decimated = Decimated::new(scene.log.numeric_hz, sinks);
    let start = Instant::now();
    let result = run(model, scene, &mut decimated);
    let wall_s = start.elapsed().as_secs_f64();
    let last_sample = decimated.end();
    let RunSinks { log, criteria_tracker, audit, last_s, .. } = decimated.sink;
    let RunCriteria { criteria, grasp, rebounds, overlaps } = criteria_tracker.finish(result.is_ok());
    let fate_sentence = |criteria: &GraspCriteria| {
        format!("{}: {}", criteria.fate.name(), fate_reason(criteria, scene.thresholds.held_time_s))
    };
    let verdict = criteria
        .as_ref()
        .map(Criteria::verdict)
        .or_else(|| grasp.as_ref().filter(|_| result.is_ok()).map(fate_sentence));
    let energy_warning = audit.violation().map(|breach| breach.to_string());
    let warnings: Vec<String> = energy_warning.into_iter().chain(overlaps.iter().map(LinkOverlap::sentence)).collect();
    let log = OpenLog { log, last_sample, last_s, verdict, warnings: warnings.clone() };
    FinishedRun { result, criteria, grasp, rebounds, warnings, last_s, wall_s, log }
}

impl<W: Write + Send + 'static> OpenLog<W> {
    /// Writes how the run ended and finishes the log. `stopped`: time and reason if the run ended early.
    pub fn close(self, stopped: Option<(f64, &str)>, check: Option<&Check>) -> Result<Option<W>, SinkError> {
        let Some(mut log) = self.log else { return Ok(None) };
        self.last_sample?;
        if let Some(verdict) = &self.verdict {
            log.note(self.last_s, Level::Info, "grasp", verdict)?;
        }
        for warning in &self.warnings {
            log.note(self.last_s, Level::Warning, "run", warning)?;
        }
        match stopped {
            None => log.note(self.last_s, Level::Info, "run", "completed")?,
            Some((time_s, reason)) => log.note(time_s, Level::Error, "run", &format!("stopped: {reason}"))?,
        }
        // Last, because a metadata record ends the chunk.
        if let Some(check) = check {
            log.record(CHECK_NAME, check_entries(check))?;
        }
        log.finish().map(Some)
    }
}

/// All sinks of a run.
struct RunSinks<'a, W: Write + Send + 'static, A> {
    log: Option<ThreadedWriter<W>>,
    criteria_tracker: RunCriteriaTracker,
    audit: EnergyAudit,
    /// Time of the latest sample.
    last_s: f64,
    extra_sink: &'a mut A,
}

impl<W: Write + Send + 'static, A: Sink> Sink for RunSinks<'_, W, A> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.last_s = sample.time_s;
        self.criteria_tracker.sample(sample)?;
        self.audit.sample(sample)?;
        self.extra_sink.sample(sample)?;
        self.log.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.criteria_tracker.event(event)?;
        self.extra_sink.event(event)?;
        self.log.event(event)
    }

    fn should_continue(&self) -> bool {
        self.extra_sink.should_continue()
    }
}

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
