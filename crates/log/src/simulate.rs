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
    CableEvent, Criteria, LinkOverlap, ObjectCriteria, Rebound, RunCriteria, RunCriteriaTracker,
};
use phalanx_core::integrator::Reason;
use phalanx_core::invariants::EnergyAudit;
use phalanx_core::scene::Scene;
use phalanx_core::trace::{
    Decimated, Event, Model, OffGrid, Outcome, RequiredData, RunError, Sample, Sink, SinkError, run,
};

/// Whether a completed run is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CheckPolicy {
    Never,
    /// Checks only runs of up to [`check::MAX_CHECKED_STEPS`] steps.
    IfCheap,
    Always,
}

/// Options of a simulation.
pub struct SimulationOptions<'a> {
    pub check_policy: CheckPolicy,
    /// Returns whether the run may continue. The sink can also stop it.
    pub keep_running: &'a dyn Fn() -> bool,
    /// Describes why a run ended early.
    pub describe_reason: &'a dyn Fn(&Reason) -> String,
}

/// A finished run.
pub struct FinishedRun<W> {
    pub result: Result<Outcome, RunError>,
    /// Time and reason of the end; `None` for a completed run.
    pub stopped: Option<(f64, String)>,
    /// Criteria of a single finger that can grasp its object; `None` for other scenes, and if the run was not
    /// completed.
    pub criteria: Option<Criteria>,
    /// Criteria of the object that a hand grasps; `None` without such an object, and if the run was not completed.
    pub grasp: Option<ObjectCriteria>,
    /// Rebounds, one per pair of discs; empty for scenes with a finger.
    pub rebounds: Vec<Rebound>,
    /// Lift-offs of cables from pulleys, and their returns.
    pub cable_events: Vec<CableEvent>,
    /// Reasons to doubt the results, as sentences; also written to the log.
    pub warnings: Vec<String>,
    /// Result of the accuracy check; `None` if the run was not checked.
    pub check: Option<Check>,
    pub wall_s: f64,
    /// The output to which the log was written, or the error of the log.
    pub log: Result<Option<W>, SinkError>,
}

/// Simulates a scene, evaluates its criteria, and closes the log. A run is checked unless it was interrupted or the
/// policy excludes it. `extra_sink` receives the same samples and events as the log and can stop the run.
pub fn simulate<W: Write + Send + 'static>(
    model: Model,
    scene: &Scene,
    log: Option<ThreadedWriter<W>>,
    options: &SimulationOptions<'_>,
    extra_sink: &mut impl Sink,
) -> FinishedRun<W> {
    let numeric_hz = scene.log.numeric_hz;
    let criteria_tracker = OffGrid::new(numeric_hz, RunCriteriaTracker::for_scene(scene));
    let audit = OffGrid::new(numeric_hz, EnergyAudit::new(model, scene));
    let sinks = RunSinks { log, criteria_tracker, audit, last_s: 0.0, extra_sink };
    let mut decimated = Decimated::new(numeric_hz, sinks);
    let start = Instant::now();
    let (result, path) = match options.check_policy {
        CheckPolicy::Never => (run(model, scene, &mut decimated), None),
        CheckPolicy::IfCheap | CheckPolicy::Always => {
            let (result, path) = check::run_and_record(model, scene, &mut decimated);
            (result, Some(path))
        }
    };
    let wall_s = start.elapsed().as_secs_f64();
    let last_sample = decimated.end().and_then(|()| decimated.sink.end());
    let RunSinks { log, criteria_tracker, audit, last_s, .. } = decimated.sink;
    let RunCriteria { criteria, grasp, rebounds, overlaps, cable_events } =
        criteria_tracker.sink.finish(result.is_ok());
    let verdict = criteria
        .as_ref()
        .map(Criteria::verdict)
        .or_else(|| grasp.as_ref().map(|object| format!("{}: {}", object.fate.name(), object.reason)));
    let energy_warning = audit.sink.violation().map(|breach| breach.to_string());
    let warnings: Vec<String> = energy_warning.into_iter().chain(overlaps.iter().map(LinkOverlap::sentence)).collect();
    let stopped = result.as_ref().err().map(|error| match error {
        RunError::Simulation { failure, .. } => (failure.time_s, (options.describe_reason)(&failure.reason)),
        RunError::Sink(error) => (last_s, error.to_string()),
    });
    let check = match (path, &stopped) {
        (None, _) => None,
        (Some(_), Some((time_s, reason))) => Some(Check::not_completed(model, *time_s, reason)),
        (Some(path), None) if options.check_policy == CheckPolicy::IfCheap && path.steps > check::MAX_CHECKED_STEPS => {
            None
        }
        (Some(path), None) => {
            (options.keep_running)().then(|| check::check_run(model, scene, path, options.keep_running))
        }
    };
    let close = |mut log: ThreadedWriter<W>| {
        last_sample?;
        if let Some(verdict) = &verdict {
            log.note(last_s, Level::Info, "grasp", verdict)?;
        }
        for warning in &warnings {
            log.note(last_s, Level::Warning, "run", warning)?;
        }
        match &stopped {
            None => log.note(last_s, Level::Info, "run", "completed")?,
            Some((time_s, reason)) => log.note(*time_s, Level::Error, "run", &format!("stopped: {reason}"))?,
        }
        // Last, because a metadata record ends the chunk.
        if let Some(check) = &check {
            log.record(CHECK_NAME, check_entries(check))?;
        }
        log.finish()
    };
    let log = log.map(close).transpose();
    FinishedRun { result, stopped, criteria, grasp, rebounds, cable_events, warnings, check, wall_s, log }
}

/// All sinks of a run.
struct RunSinks<'a, W: Write + Send + 'static, A> {
    log: Option<ThreadedWriter<W>>,
    criteria_tracker: OffGrid<RunCriteriaTracker>,
    audit: OffGrid<EnergyAudit>,
    /// Time of the latest sample.
    last_s: f64,
    extra_sink: &'a mut A,
}

impl<W: Write + Send + 'static, A> RunSinks<'_, W, A> {
    /// Passes on the last sample at the end of the run.
    fn end(&mut self) -> Result<(), SinkError> {
        self.criteria_tracker.end()?;
        self.audit.end()
    }
}

impl<W: Write + Send + 'static, A: Sink> Sink for RunSinks<'_, W, A> {
    fn required_data(&self) -> RequiredData {
        let evaluation = self.criteria_tracker.required_data().or(self.audit.required_data());
        evaluation.or(self.extra_sink.required_data()).or(self.log.required_data())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.last_s = sample.time_s;
        self.criteria_tracker.sample(sample)?;
        self.audit.sample(sample)?;
        self.extra_sink.sample(sample)?;
        self.log.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.criteria_tracker.event(event)?;
        self.audit.event(event)?;
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
    /// Criteria of a single finger that can grasp its object; `None` for other scenes.
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
    let log = ThreadedWriter::start(out, UNNAMED_LOG, &run_info(scene, model), || {}).map_err(LogError::Start)?;
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
    let options = SimulationOptions {
        check_policy: CheckPolicy::IfCheap,
        keep_running: &|| true,
        describe_reason: &ToString::to_string,
    };
    let FinishedRun { result, criteria, rebounds, warnings, check, log, .. } =
        simulate(model, scene, Some(log), &options, &mut ());
    let missing_log =
        || SinkError { target: UNNAMED_LOG.to_string(), source: io::Error::other("the log was not started") };
    let finished_log = log.and_then(|out| out.ok_or_else(missing_log));
    (result.map(|outcome| LoggedRun { outcome, criteria, rebounds, warnings, check }), finished_log)
}
