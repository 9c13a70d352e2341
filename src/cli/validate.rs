//! `phalanx validate`: compares the engine model with the analytic model, and speed with error.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use super::interrupt::{Interrupt, interrupted};
use super::output::{print, print_report};
use super::progress::RunCounter;
use super::run::{log_failure, run_info};
use super::set::{SetArgs, source_files};
use super::simulate::{CheckPolicy, RunLimits, simulate};
use super::targets::{PAGE_FILE, reserve, save, write_failure};
use super::{Failure, Status};
use crate::files::replace_file;
use crate::format::{Report, ToReport, format_duration};
use crate::log::{self, LogFile};
use crate::page::{Note, Page, Picture, Playback, PlaybackRecorder, render_page};
use crate::plot;
use crate::report::validation::{ValidationReport, write_series};
use crate::scene::keywords::SceneKind;
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
                  report\n  phalanx validate scenes/experiment-95.toml --ladder --json > validation.json\n\nThe section \
                  [validate] of a scene sets its bounds. Exit status: 0 within bounds; 1 out of bounds; 2 bad input; 3 a \
                  simulation could not be completed."
)]
pub(crate) struct ValidateArgs {
    /// Scene file (TOML); `phalanx scene schema` describes it
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Write reports, a page for a browser, time series of both models, plots and both logs to this directory, which is
    /// created if needed; an existing file is replaced only when the new one is complete
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,

    /// Also run a ladder of other settings of both models and compare their errors and times; included in --out
    #[arg(long)]
    ladder: bool,

    /// Time limit of the ladder, such as "60 s"; settings that exceed it are omitted and listed [default: 10 s]
    #[arg(long, value_name = "TIME", value_parser = duration)]
    ladder_time: Option<f64>,

    /// Omit slow settings from the ladder: fixed steps below 1e-5 s and reduced coordinates
    #[arg(long)]
    quick: bool,
}

impl ValidateArgs {
    /// Returns the options of the ladder if it is requested.
    fn ladder_options(&self) -> Option<LadderOptions> {
        let is_requested = self.ladder || self.ladder_time.is_some() || self.out.is_some();
        is_requested.then(|| LadderOptions { quick: self.quick, time_s: self.ladder_time.unwrap_or(LADDER_TIME_S) })
    }
}

/// Runs `phalanx validate`.
pub fn run(args: &ValidateArgs) -> Result<Status, Failure> {
    let scene = &args.set.load_any(&args.scene)?;
    let files = file_names(scene);
    let directory = reserve(&[("the scene", &source_files(&args.scene))], &[], ("--out", args.out.as_deref(), &files))?;
    let interrupt = Interrupt::listen()?;
    check_sample_count(scene).map_err(Failure::bad_input)?;
    let mut counter = RunCounter::new();
    counter.update(0, 1, "verdict");
    let result = validate(scene, &|| interrupt.signal().is_none());
    counter.clear();
    let mut validation = result.map_err(|error| run_failure(error, args, &interrupt, "before its verdict"))?;
    // The verdict is printed first, because the ladder takes longer.
    if !args.json {
        print_report(&ValidationReport::new(scene, &validation, None).verdict_report())?;
    }
    let options = args.ladder_options();
    if let Some(options) = options {
        run_ladder_with_progress(&mut validation, scene, (args, options), &interrupt)?;
    }
    let mut report = ValidationReport::new(scene, &validation, options);
    directory.write_with(|out| write_files(out, args, scene, &validation, &mut report, &interrupt))?;
    match (args.json, report.ladder_report()) {
        (true, _) => print(&report.json())?,
        (false, Some(ladder)) => print_report(&Report::from("\n").with(ladder))?,
        (false, None) => {}
    }
    Ok(if validation.verdict.passed() { Status::Done } else { Status::CheckFailed })
}

/// Runs the ladder and shows its progress; stops at a signal.
fn run_ladder_with_progress(
    validation: &mut Validation,
    scene: &Scene,
    (args, options): (&ValidateArgs, LadderOptions),
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let mut counter = RunCounter::new();
    let mut last = (0, 0);
    let mut report_progress = |done: usize, total: usize, next: &str| {
        last = (done, total);
        counter.update(done, total, next);
    };
    let result = run_ladder(validation, scene, options, &mut report_progress, &|| interrupt.signal().is_none());
    counter.clear();
    let when = format!("after {} of {} settings of its ladder", last.0, last.1);
    result.map_err(|error| run_failure(error, args, interrupt, &when))
}

/// Failure of one of the runs of a validation, which may be due to a signal.
fn run_failure(error: ValidationError, args: &ValidateArgs, interrupt: &Interrupt, when: &str) -> Failure {
    if let Some(signal) = interrupt.signal().filter(|_| error.error.is_stop()) {
        return interrupted(&format!("the validation was interrupted by {signal} {when}"), args.out.is_some());
    }
    let model = error.model.name();
    match error.error {
        RunError::Sink(sink) => Failure::incomplete(format!("the {model} model stopped: {sink}")),
        RunError::Simulation { failure, .. } => Failure::incomplete(format!(
            "the {model} model stopped at {}: {}; there is nothing to compare (phalanx run --model {model} --log FILE.mcap \
             keeps the run up to that time)",
            format_duration(failure.time_s),
            failure.reason
        )),
    }
}

/// Returns the names of the files in the output directory. The report lists the others.
fn file_names(scene: &Scene) -> Vec<&'static str> {
    let plots = ["speed-error.svg", "overlay.svg"].into_iter();
    let difference = (scene.kind() != SceneKind::Bodies).then_some("difference.svg");
    let reports = ["report.txt", "report.json", PAGE_FILE, "series.csv"];
    reports.into_iter().chain(plots).chain(difference).chain(["analytic.mcap", "engine.mcap"]).collect()
}

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
    if scene.kind() != SceneKind::Bodies {
        save(&out.join("difference.svg"), &plot::difference(scene, validation))?;
    }
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
    save(&out.join(PAGE_FILE), &page)?;
    let names = file_names(scene).into_iter().map(String::from).collect();
    report.files = args.out.as_ref().map(|out| (out.display().to_string(), names));
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
    let log = log::create(path, &run_info(scene, scene_file, model.name())).map_err(log_failure)?;
    let mut recorder = PlaybackRecorder::default();
    let limits = RunLimits { interrupt, until_s: f64::INFINITY, check_policy: CheckPolicy::IfCheap };
    let run = simulate(model, scene, Some(log), &limits, &mut recorder);
    let mut summary = run.report;
    if scene.kind() == SceneKind::Bodies {
        // Pages of scenes of discs do not show the result of the check.
        summary.check = None;
    }
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
    Ok(recorder.into_playback(model.name(), scene, summary.report()))
}
