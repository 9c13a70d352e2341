//! `phalanx validate`: compares the engine model with the analytic model, and speed with error.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use super::output::{OutputArgs, print, print_report, reserve, save, write_failure};
use super::progress::Interrupt;
use super::run::run_info;
use super::set::{SetArgs, source_files};
use super::simulate::{CheckPolicy, RunLimits, simulate};
use super::{Failure, Status};
use crate::files::replace_file;
use crate::format::{Report, ToReport, format_duration};
use crate::log::{self, LogFile};
use crate::page::{Note, Page, Picture, Playback, PlaybackRecorder, render_page};
use crate::plot;
use crate::report::simulation::report_of;
use crate::report::validation::{ValidationReport, write_series};
use crate::scene::{Preset, Scene};
use crate::trace::overrides::duration;
use crate::trace::{Model, RunError};
use crate::validate::{
    LADDER_TIME_S, LadderOptions, Validation, ValidationError, check_sample_count, run_ladder, validate,
};

/// Compare the engine with the analytic model and check the differences against the scene's bounds; --ladder compares
/// speed with error.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx validate scenes/experiment-95.toml\n  phalanx validate scenes/experiment-95.toml --out \
                  report\n  phalanx validate scenes/experiment-95.toml --ladder --json > validation.json\n\n--out writes reports, a \
                  page for a browser, time series of both models, plots and both logs. The section [validate] of a scene sets its bounds. Exit status: 0 within bounds; 1 out of bounds; 2 bad input; 3 a \
                  simulation could not be completed."
)]
pub(crate) struct ValidateArgs {
    /// Scene file (TOML); `phalanx schema scene` describes it
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    #[command(flatten)]
    output: OutputArgs,

    /// Also run a ladder of other settings of both models and compare their errors and times; included in --out
    #[arg(long)]
    ladder: bool,

    /// Time limit of the ladder, such as "60 s"; settings that exceed it are omitted and listed [default: 10 s]
    #[arg(long, value_name = "TIME", value_parser = duration)]
    ladder_time: Option<f64>,

    /// Print all differences of a mechanism or of discs, not only the ten largest; --out and --json contain all
    #[arg(long)]
    all: bool,

    /// Omit slow settings from the ladder: fixed steps below 1e-5 s
    #[arg(long)]
    quick: bool,
}

impl From<ValidationError> for Failure {
    fn from(ValidationError { model, error }: ValidationError) -> Self {
        let model = model.name();
        match error {
            RunError::Sink(sink) => Failure::incomplete(format!("the {model} model stopped: {sink}")),
            RunError::Simulation { failure, .. } => Failure::incomplete(format!(
                "the {model} model stopped at {}: {}; there is nothing to compare (phalanx run --model {model} --log FILE.mcap \
                 keeps the run up to that time)",
                format_duration(failure.time_s),
                failure.reason
            )),
        }
    }
}

pub(super) fn run(args: &ValidateArgs) -> Result<Status, Failure> {
    let scene = &args.set.load_any(&args.scene)?;
    let OutputArgs { out, json } = &args.output;
    let directory =
        reserve(&[("the scene", &source_files(&args.scene))], &[], (args.output.out.as_deref(), &FILE_NAMES))?;
    let interrupt = Interrupt::listen()?;
    check_sample_count(scene).map_err(Failure::bad_input)?;
    let task = ["the validation", "parts", args.output.unwritten()];
    let mut validation = interrupt.compute(task, |monitor| {
        monitor.start(1, "verdict");
        validate(scene, monitor.keep_running())
    })?;
    // The verdict is printed first, because the ladder takes longer.
    if !json {
        let mut report = ValidationReport::new(scene, &validation, None);
        report.all = args.all;
        print_report(&report.verdict_report())?;
    }
    let is_requested = args.ladder || args.ladder_time.is_some() || out.is_some();
    let time_s = args.ladder_time.unwrap_or(LADDER_TIME_S);
    let options = is_requested.then_some(LadderOptions { quick: args.quick, time_s });
    if let Some(options) = options {
        let task = ["the validation", "settings of its ladder", args.output.unwritten()];
        interrupt.compute(task, |monitor| run_ladder(&mut validation, scene, options, monitor))?;
    }
    let mut report = ValidationReport::new(scene, &validation, options);
    directory.write_with(|out| write_files(out, args, scene, &validation, &mut report, &interrupt))?;
    match (json, report.ladder_report()) {
        (true, _) => print(&report.json())?,
        (false, Some(ladder)) => print_report(&Report::from("\n").with(ladder))?,
        (false, None) => Status::Done,
    };
    Ok(if validation.verdict.passed() { Status::Done } else { Status::CheckFailed })
}

/// Names of the files in the output directory. The report lists the others.
const FILE_NAMES: [&str; 9] = [
    "report.txt",
    "report.json",
    "page.html",
    "series.csv",
    "speed-error.svg",
    "overlay.svg",
    "difference.svg",
    "analytic.mcap",
    "engine.mcap",
];

/// Writes all files; the report lists them by their final paths.
fn write_files(
    out: &Path,
    args: &ValidateArgs,
    scene: &Scene,
    validation: &Validation,
    report: &mut ValidationReport<'_>,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let name = &scene.name;
    let speed_error = plot::speed_error(name, validation);
    save(&out.join("speed-error.svg"), &speed_error)?;
    save(&out.join("overlay.svg"), &plot::overlay(scene, validation))?;
    save(&out.join("difference.svg"), &plot::difference(scene, validation))?;
    let series = out.join("series.csv");
    let runs = [&validation.reference, &validation.engine];
    replace_file(&series, |mut out| write_series(&mut out, scene, runs)).map_err(|e| write_failure(&series, e))?;
    let mut reference = scene.clone();
    reference.apply_preset(Preset::Reference);
    let runs = vec![
        record_run(Model::Analytic, &reference, &args.scene, &out.join("analytic.mcap"), interrupt)?,
        record_run(Model::Engine, scene, &args.scene, &out.join("engine.mcap"), interrupt)?,
    ];
    // Pages are shared, so the page does not contain local paths. It plots the runs itself, so it shows one picture.
    let page = render_page(&Page {
        title: name.clone(),
        description: scene.description.clone(),
        runs,
        notes: vec![Note { title: "Validation".to_string(), text: report.report() }],
        pictures: vec![Picture { title: "Speed against error".to_string(), svg: speed_error }],
    });
    save(&out.join("page.html"), &page)?;
    let names = FILE_NAMES.map(String::from).to_vec();
    report.files = args.output.out.as_ref().map(|out| (out.display().to_string(), names));
    save(&out.join("report.txt"), &report.report().to_string())?;
    save(&out.join("report.json"), &report.json())
}

/// Runs and logs one model with the same settings as `phalanx run`; returns the run for the page.
///
/// # Errors
/// Returns an error if the run was not completed, or the log could not be written.
fn record_run(
    model: Model,
    scene: &Scene,
    scene_file: &Path,
    path: &Path,
    interrupt: &Interrupt,
) -> Result<Playback, Failure> {
    let log = log::create(path, &run_info(scene, scene_file, model.name()))?;
    let mut recorder = PlaybackRecorder::default();
    let limits = RunLimits { interrupt, until_s: f64::INFINITY, check_policy: CheckPolicy::IfCheap };
    let run = simulate(model, scene, Some(log), &limits, &mut recorder);
    let summary = report_of(model, scene, &run);
    match (&summary.error, interrupt.signal()) {
        (None, _) => {
            let result = run.log.and_then(|log| log.map_or(Ok(()), LogFile::commit));
            result.map_err(|error| write_failure(path, error))?;
        }
        (Some(_), Some(signal)) => {
            // The target is unchanged; the partial log of a validation is of no use.
            let _ = fs::remove_file(log::partial_name(path));
            return Err(Failure::incomplete(format!(
                "the validation was interrupted by {signal} while it wrote its files; {} and the reports are unchanged",
                path.display()
            )));
        }
        (Some(error), None) => return Err(write_failure(path, &error.reason)),
    }
    let playback = recorder.into_playback(model.name(), scene, summary.report());
    Ok(playback.with_grasp(summary.played_grasp()))
}
