//! `phalanx run`: one simulation, its summary, its log.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::interrupt::Interrupt;
use super::live::{Live, LiveArgs};
use super::output::{complain, print};
use super::overrides::Overrides;
use super::progress::Progress;
use super::{Failure, Status, run_bodies};
use crate::criteria::{FinalAngles, Tracker};
use crate::gripper::{Circle, final_posture};
use crate::log::{self, FileWriter, LogError, Logged, RunInfo, Severity};
use crate::report::{self, RunReport};
use crate::scene::{self, AnyScene, Scene};
use crate::trace::{self, Event, Model, RunError, Sample, Sink, SinkError};

/// Simulate a scene and print a summary: final state, contacts, energies, dynamic criteria or restitution.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx run scenes/experiment-95.toml\n  phalanx run scenes/experiment-95.toml --log run.mcap\n  \
                  phalanx run scenes/experiment-95.toml --duration \"30 ms\" --preset reference --json > run.json\n  \
                  phalanx run scenes/experiment-95.toml --model engine --step \"1 us\"\n\nThe log \
                  opens in Foxglove, Rerun and PlotJuggler. Exit status: 0 done; 2 bad input; 3 the simulation could not be \
                  completed (the log up to there is kept)."
)]
pub struct RunArgs {
    /// Scene file (TOML); `phalanx scene schema` describes it
    pub(super) scene: PathBuf,

    /// Which of the two independent models simulates the scene
    #[arg(long, value_enum, default_value_t = Model::Analytic)]
    pub(super) model: Model,

    /// Write a log (MCAP, readable while it grows as FILE.mcap.partial); an older log of that name is replaced only
    /// when the new one is whole
    #[arg(long, value_name = "FILE.mcap")]
    pub(super) log: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of the summary
    #[arg(long)]
    pub(super) json: bool,

    #[command(flatten)]
    pub(super) overrides: Overrides,

    #[command(flatten)]
    pub(super) live: LiveArgs,
}

/// Runs the command.
pub fn run(args: &RunArgs) -> Result<Status, Failure> {
    match scene::load_any(&args.scene)? {
        AnyScene::Finger(scene) => finger(args, *scene),
        AnyScene::Bodies(scene) => run_bodies::run(args, *scene),
    }
}

fn finger(args: &RunArgs, mut scene: Scene) -> Result<Status, Failure> {
    args.overrides.apply(args.model, &mut scene)?;
    let model = args.model.name();
    let interrupt = Interrupt::listen()?;
    let live = args.live.start(&scene.name, scene.duration_s, &interrupt)?;
    let mut sinks = Sinks {
        log: started(args, &scene, live.as_ref(), &interrupt)?,
        tracker: final_angles(&scene).map(Tracker::new),
        last_s: 0.0,
        progress: Progress::new(scene.duration_s),
        interrupt: &interrupt,
    };

    let start = Instant::now();
    let result = trace::run(args.model, &scene, &mut sinks);
    let wall_s = start.elapsed().as_secs_f64();
    sinks.progress.clear();

    let (mut report, broken) = match &result {
        Ok(outcome) => {
            // Whether the grasp is statically stable is for the statics to say; the criteria here are the run's own.
            let criteria = sinks.tracker.as_ref().map(|tracker| tracker.criteria(true));
            (RunReport::completed(&scene, model, wall_s, outcome, criteria), None)
        }
        Err(error) => {
            let (time_s, reason, so_far) = match error {
                RunError::Simulation { failure, so_far } => {
                    (failure.time_s, interrupt.reason(&failure.reason), Some(so_far.as_ref()))
                }
                RunError::Sink(error) => (sinks.last_s, error.to_string(), None),
            };
            let failure = report::Failure { time_s, reason };
            let message = stopped(&failure, scene.duration_s);
            (RunReport::failed(&scene, model, wall_s, failure, so_far), Some(message))
        }
    };
    report.log = args.log.as_ref().map(|path| path.display().to_string());

    let finished = finish_log(sinks.log, sinks.last_s, report.error.as_ref());
    print(&match args.json {
        true => report::json(&report),
        false => report::text(&report),
    })?;
    if let Some(live) = live {
        live.end();
    }
    match (broken, finished) {
        (Some(message), finished) => Err(Failure::incomplete(message + &kept(args, finished.is_ok()))),
        (None, Err(error)) => Err(Failure::incomplete(format!("{error}{}", kept(args, false)))),
        (None, Ok(())) => Ok(Status::Done),
    }
}

/// The log of a run, if there is to be one or the run is watched.
pub(super) fn started<S: Logged>(
    args: &RunArgs,
    scene: &S,
    live: Option<&Live>,
    interrupt: &Interrupt,
) -> Result<Option<FileWriter<S::Channels>>, Failure> {
    if args.log.is_none() && live.is_none() {
        return Ok(None);
    }
    let feed = live.map(|live| live.feed(interrupt));
    let info = info(scene, &args.scene, args.model.name());
    let log = log::create_with_feed(args.log.as_deref(), &info, feed).map_err(unstarted)?;
    if let Some(live) = live {
        live.begin();
    }
    Ok(Some(log))
}

/// What the log says about the run.
pub(super) fn info<'a, S>(scene: &'a S, path: &'a Path, model: &'a str) -> RunInfo<'a, S> {
    RunInfo { scene, scene_file: path.file_name().and_then(|name| name.to_str()).unwrap_or("scene.toml"), model }
}

/// A log that could not be started: the path is wrong, or the disk is full already.
pub(super) fn unstarted(error: LogError) -> Failure {
    match error {
        LogError::Start(_) => Failure::incomplete(error),
        _ => Failure::bad_input(error),
    }
}

/// Where the finger ends if it grasps the object; `None`, and said why, if the criteria make no sense for this scene.
pub(super) fn final_angles(scene: &Scene) -> Option<FinalAngles> {
    let object = scene.object?;
    let disc = Circle { radius_m: object.radius_m, centre_m: object.centre_m };
    match final_posture(&scene.finger.lengths, scene.finger.assembly, disc) {
        Ok(end) => Some(FinalAngles { q11_rad: end.posture.q11_rad, q21_rad: end.posture.q21_rad }),
        Err(error) => {
            complain(&format!("no dynamic criteria, for the finger cannot grasp this object: {error}"));
            None
        }
    }
}

/// How far a run came, and why not further.
pub(super) fn stopped(failure: &report::Failure, duration_s: f64) -> String {
    let (at, of) = (report::duration(failure.time_s), report::duration(duration_s));
    format!("the simulation stopped at {at} of {of}: {}", failure.reason)
}

/// Says in the log how the run ended, and finishes it.
pub(super) fn finish_log<C>(
    log: Option<FileWriter<C>>,
    last_s: f64,
    error: Option<&report::Failure>,
) -> Result<(), SinkError> {
    let Some(mut log) = log else {
        return Ok(());
    };
    let (time_s, severity, text) = match error {
        None => (last_s, Severity::Info, "completed".to_string()),
        Some(error) => (error.time_s, Severity::Error, format!("stopped: {}", error.reason)),
    };
    log.note(time_s, severity, &text)?;
    log.keep()
}

/// Where what there is of a run can be found; `finished`: whether its log is.
pub(super) fn kept(args: &RunArgs, finished: bool) -> String {
    let Some(path) = &args.log else {
        return "; with --log FILE.mcap the run up to there is kept".to_string();
    };
    let partial = log::partial_name(path);
    match finished {
        true => format!("; the log up to there is in {}", path.display()),
        false if partial.exists() => format!(
            "; the log up to there is in {} (phalanx replay reads it), and {} is as it was before",
            partial.display(),
            path.display()
        ),
        false => "; what could be written of the log has gone where it was sent".to_string(),
    }
}

/// Everything that listens to a run.
struct Sinks<'a> {
    log: Option<FileWriter>,
    tracker: Option<Tracker>,
    /// Time of the latest sample.
    last_s: f64,
    progress: Progress,
    interrupt: &'a Interrupt,
}

impl Sink for Sinks<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.last_s = sample.time_s;
        self.progress.sample(sample)?;
        if let Some(tracker) = &mut self.tracker {
            tracker.sample(sample)?;
        }
        match &mut self.log {
            Some(log) => log.sample(sample),
            None => Ok(()),
        }
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        if let Some(tracker) = &mut self.tracker {
            tracker.event(event)?;
        }
        match &mut self.log {
            Some(log) => log.event(event),
            None => Ok(()),
        }
    }

    fn proceed(&self) -> bool {
        self.interrupt.signal().is_none()
    }
}
