//! `phalanx run`: one simulation with its summary, log, table and page.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, SystemTime};

use clap::Args;

use super::output::{FileKind, NO_DIRECTORY, print_diagnostic, print_note, print_result, reserve};
use super::page::PageArgs;
use super::parsers::{self, preset};
use super::progress::Interrupt;
use super::set::{SetArgs, source_files};
use super::simulate::{CheckPolicy, RunLimits, SampleTable, csv_file, simulate};
use super::{Failure, Status};
use crate::format::{ToReport, format_duration};
use crate::log::{self, LogError, LogFile, RunInfo};
use crate::page::PlaybackRecorder;
use crate::report::document::{self, Detail};
use crate::report::simulation::report_of;
use crate::scene::{Preset, Scene};
use crate::trace::overrides::{self, duration, numeric_rate, picture_rate, rtol, step, tolerance};
use crate::trace::{Event, Model, RequiredData, Sample, Schema, Sink, SinkError};

/// Polling period of `--watch`, and time for an editor to finish writing.
const PERIOD: Duration = Duration::from_millis(100);

/// Simulate a scene and print a summary: final state, contacts, energies, dynamic criteria or restitution.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx run scenes/experiment-95.toml\n  phalanx run scenes/experiment-95.toml --open\n  phalanx run scenes/experiment-95.toml --log run.mcap\n  \
                  phalanx run scenes/experiment-95.toml --duration \"30 ms\" --preset reference --json > run.json\n  \
                  phalanx run scenes/experiment-95.toml --model engine --step \"1 us\"\n\nThe log \
                  opens in Foxglove, Rerun and PlotJuggler. Exit status: 0 done; 2 bad input; 3 the simulation could not be \
                  completed (the log up to that time is kept)."
)]
pub(crate) struct RunArgs {
    /// Scene file (TOML); `phalanx schema scene` describes it
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Simulation model; the two models are independent
    #[arg(long, value_parser = parsers::model(), default_value = "analytic")]
    model: Model,

    /// Write a log (MCAP; FILE.mcap.partial is readable during the run); an existing log is replaced only when the new
    /// one is complete
    #[arg(long, value_name = "FILE.mcap")]
    log: Option<PathBuf>,

    /// Write all samples as comma-separated values to this file, as `phalanx replay --csv` does for a log, always with
    /// the forces of joints; - writes them to standard output instead of the summary
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,

    #[command(flatten)]
    page: PageArgs,

    /// Run again whenever the scene file is saved, until Ctrl-C; the log and the page are rewritten each time
    #[arg(long, conflicts_with = "json")]
    watch: bool,

    /// Print one JSON document with SI units in its keys instead of the summary
    #[arg(long)]
    json: bool,

    /// Print the contacts of a grasp by their points, not by pairs of outlines
    #[arg(long, conflicts_with = "json")]
    points: bool,

    /// Print the states of all bodies, joints and actuators, and all contact points
    #[arg(long, conflicts_with = "json")]
    all: bool,

    /// Estimate the error from further, independent runs and report whether the outcome is chaotic; the default for
    /// runs of up to 20,000 steps
    #[arg(long, overrides_with = "no_check")]
    check: bool,

    /// Do not estimate the error
    #[arg(long, overrides_with = "check")]
    no_check: bool,

    #[command(flatten)]
    overrides: Overrides,
}

/// Settings of the simulation given on the command line, which override fields of the scene.
#[derive(Debug, Args)]
struct Overrides {
    /// Preset of integrator method and tolerances of the analytic model [default: as in the scene]
    #[arg(long, value_parser = preset())]
    preset: Option<Preset>,

    /// Relative tolerance of the analytic model [default: from the scene or preset]; absolute tolerances are scaled by
    /// the same factor
    #[arg(long, value_name = "X", value_parser = rtol)]
    rtol: Option<f64>,

    /// Use fixed steps of this size in the engine model, such as "1 us" [default: stepping of the scene]
    #[arg(long, value_name = "TIME", value_parser = step, conflicts_with = "tolerance")]
    step: Option<f64>,

    /// Use adaptive steps in the engine model, with this largest opening of a joint per step, such as "0.02 um"
    /// [default: stepping of the scene]
    #[arg(long, value_name = "LENGTH", value_parser = tolerance)]
    tolerance: Option<f64>,

    /// Duration of the run with its unit, such as "30 ms" [default: as in the scene]
    #[arg(long, value_name = "TIME", value_parser = duration)]
    duration: Option<f64>,

    /// Samples per simulated second in the log, such as "20 kHz" [default: as in the scene]; during impacts every step
    /// is also logged
    #[arg(long, value_name = "FREQUENCY", value_parser = numeric_rate)]
    numeric_rate: Option<f64>,

    /// Pictures per simulated second in the log, such as "1 kHz" ("0 Hz": none) [default: as in the scene]
    #[arg(long, value_name = "FREQUENCY", value_parser = picture_rate)]
    picture_rate: Option<f64>,
}

impl Overrides {
    /// Applies the flags to a scene. A flag that belongs to the model that is not run is an error.
    fn apply(&self, model: Model, scene: &mut Scene) -> Result<(), Failure> {
        let overrides = overrides::Overrides {
            preset: self.preset,
            rtol: self.rtol,
            step_s: self.step,
            tolerance_m: self.tolerance,
            duration_s: self.duration,
            numeric_hz: self.numeric_rate,
            picture_hz: self.picture_rate,
        };
        overrides.apply(model, scene).map_err(Failure::bad_input)
    }
}

pub(super) fn run(args: &RunArgs) -> Result<Status, Failure> {
    if args.watch { args.page.ensure_watchable().and_then(|()| watch(args)) } else { run_once(args, true) }
}

/// Performs a run immediately and after each change of the scene, until a signal arrives. A failure is printed and does
/// not end the loop, because the next change may fix it.
fn watch(args: &RunArgs) -> Result<Status, Failure> {
    let interrupt = Interrupt::listen()?;
    let mut first = true;
    loop {
        let files = source_files(&args.scene);
        let previous = file_stamps(&files);
        let status = run_once(args, first).unwrap_or_else(|failure| {
            print_diagnostic(&failure.message);
            failure.status
        });
        first = false;
        if interrupt.signal().is_some() {
            return Ok(status);
        }
        print_note(&format!("\nwatching {}: save the file to run again; Ctrl-C to stop", args.scene.display()));
        // Many editors remove the file and write a new one, so a missing file is not a change.
        while matches!(file_stamps(&files), stamps if stamps == previous || stamps.is_none()) {
            if interrupt.signal().is_some() {
                return Ok(Status::Done);
            }
            sleep(PERIOD);
        }
        sleep(PERIOD);
    }
}

/// Modification times and sizes of the files; `None` if a file is missing.
fn file_stamps(paths: &[PathBuf]) -> Option<Vec<(SystemTime, u64)>> {
    let file_stamp = |path: &PathBuf| fs::metadata(path).and_then(|found| Ok((found.modified()?, found.len()))).ok();
    paths.iter().map(file_stamp).collect()
}

/// Performs one run. `first`: whether it is the first of several.
fn run_once(args: &RunArgs, first: bool) -> Result<Status, Failure> {
    let mut scene = args.set.load_any(&args.scene)?;
    args.overrides.apply(args.model, &mut scene)?;
    let scene = &scene;
    let (name, duration_s) = (scene.name.as_str(), scene.duration_s);
    let csv = csv_file(args.csv.as_deref(), args.json)?;
    let targets = [
        ("--log", args.log.as_deref(), FileKind::Log),
        ("--csv", csv, FileKind::Table),
        ("--plot", args.page.plot.as_deref(), FileKind::Page),
    ];
    reserve(&[("the scene", &source_files(&args.scene))], &targets, NO_DIRECTORY)?;
    let page = args.page.prepare(first)?;
    let interrupt = Interrupt::listen()?;
    let log = args.log.as_deref().map(|path| log::create(path, &run_info(scene, &args.scene, args.model.name())));
    let log = log.transpose()?;
    let table = args.csv.as_deref().map(SampleTable::create).transpose()?;
    let mut outputs = Outputs { recorder: page.as_ref().map(|_| PlaybackRecorder::default()), table };
    outputs.table.iter_mut().for_each(|table| table.set_schema(&Schema::from_scene(scene)));
    let check_policy = match (args.check, args.no_check) {
        (true, _) => CheckPolicy::Always,
        (_, true) => CheckPolicy::Never,
        _ => CheckPolicy::IfCheap,
    };
    let limits = RunLimits { interrupt: &interrupt, until_s: f64::INFINITY, check_policy };
    let run = simulate(args.model, scene, log, &limits, &mut outputs);
    let table = outputs.table.map_or(Ok(true), SampleTable::finish);
    let mut report = report_of(args.model, scene, &run);
    // Pages are shared, so the page does not contain local paths.
    let page_path = page.as_ref().zip(outputs.recorder).map(|(page, recorder)| {
        let playback = recorder.into_playback(args.model.name(), scene, report.report());
        let playback = playback.with_grasp(report.played_grasp());
        page.write(name, &scene.description, playback)
    });
    report.detail = Detail { points: args.points || args.all, all: args.all };
    report.page = page_path.as_ref().and_then(|path| path.as_ref().ok().cloned());
    report.log = args.log.as_ref().map(|path| path.display().to_string());
    report.csv = csv.filter(|_| table.is_ok()).map(|path| path.display().to_string());
    let log_result = run.log.and_then(|log| log.map_or(Ok(()), LogFile::commit));
    if csv.is_some() || args.csv.is_none() {
        print_result(&report, args.json)?;
    }
    let status = match table {
        // The reader of standard output closed the pipe.
        Ok(false) => Ok(Status::Done),
        table => exit_status(args, duration_s, report.error.as_ref(), log_result).and(table.map(|_| Status::Done)),
    };
    // The page is opened even after a failed run, whose failure comes first.
    let shown = page_path.map(|written| written.and_then(|_| page.map_or(Ok(()), |page| page.show())));
    let status = status?;
    shown.unwrap_or(Ok(())).map(|()| status)
}

/// Further outputs of a run.
struct Outputs {
    recorder: Option<PlaybackRecorder>,
    table: Option<SampleTable>,
}

impl Sink for Outputs {
    fn required_data(&self) -> RequiredData {
        self.table.required_data().or(self.recorder.required_data())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.table.sample(sample)?;
        self.recorder.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.recorder.event(event)
    }
}

fn exit_status(
    args: &RunArgs,
    duration_s: f64,
    error: Option<&document::Failure>,
    log_result: Result<(), SinkError>,
) -> Result<Status, Failure> {
    let location = log_location(args, log_result.is_ok());
    match (error, log_result) {
        (Some(document::Failure { time_s, reason }), _) => {
            let (stop_time, duration) = (format_duration(*time_s), format_duration(duration_s));
            let message = format!("the simulation stopped at {stop_time} of {duration}: {reason}{location}");
            Err(Failure::incomplete(message))
        }
        (None, Err(error)) => Err(Failure::incomplete(format!("{error}{location}"))),
        (None, Ok(())) => Ok(Status::Done),
    }
}

/// Returns the description of the run for its log.
pub(super) fn run_info<'a>(scene: &'a Scene, path: &'a Path, model: &'a str) -> RunInfo<'a> {
    RunInfo { scene, scene_file: path.file_name().and_then(|name| name.to_str()).unwrap_or("scene.toml"), model }
}

impl From<LogError> for Failure {
    /// A log cannot be created if its path is invalid, or if the disk is full.
    fn from(error: LogError) -> Self {
        match error {
            LogError::Start(_) => Failure::incomplete(error),
            _ => Failure::bad_input(error),
        }
    }
}

/// Message with the location of the log of an incomplete run. `is_finished`: whether the log itself was finished.
fn log_location(args: &RunArgs, is_finished: bool) -> String {
    let Some(path) = &args.log else {
        return "; use --log FILE.mcap to record the run up to that time".to_string();
    };
    let partial = log::partial_name(path);
    match is_finished {
        true => format!("; the log up to that time is in {}", path.display()),
        false if partial.exists() => format!(
            "; the log up to that time is in {} (phalanx replay reads it), and {} is unchanged",
            partial.display(),
            path.display()
        ),
        false => format!("; {} contains only the part of the log that could be written", path.display()),
    }
}
