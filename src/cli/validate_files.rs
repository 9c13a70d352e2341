//! Files of `phalanx validate --out`: reports, time series, pictures and logs.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use super::Failure;
use super::interrupt::Interrupt;
use super::run::{log_failure, run_info};
use super::simulate::{CheckPolicy, FailedRun, RunLimits, simulate};
use super::targets::{PAGE_FILE, save, write_failure};
use super::validate_args::ValidateArgs;
use crate::files::replace_file;
use crate::format::{Report, ToReport};
use crate::log::{self, LogFile};
use crate::page::{Note, Page, Picture, Playback, PlaybackRecorder, render_page};
use crate::plot;
use crate::report::validation::{ValidationReport, write_series};
use crate::scene::keywords::SceneKind;
use crate::scene::{Preset, Scene};
use crate::trace::{Model, Outcome, SinkError};
use crate::validate::Validation;

/// Report that lists the other files.
const REPORT_FILE: &str = "report.txt";

/// Files in the output directory for fingers and grippers.
const FINGER_FILES: [&str; 9] = [
    REPORT_FILE,
    "report.json",
    PAGE_FILE,
    "series.csv",
    "speed-error.svg",
    "overlay.svg",
    "difference.svg",
    "analytic.mcap",
    "engine.mcap",
];
/// Files in the output directory for discs.
const DISC_FILES: [&str; 8] = [
    REPORT_FILE,
    "report.json",
    PAGE_FILE,
    "series.csv",
    "speed-error.svg",
    "overlay.svg",
    "analytic.mcap",
    "engine.mcap",
];

/// Returns the files of a validation.
pub fn files(scene: &Scene) -> &'static [&'static str] {
    match scene.kind() {
        SceneKind::Finger | SceneKind::Gripper => &FINGER_FILES,
        SceneKind::Bodies => &DISC_FILES,
    }
}

/// Writes all files; the report lists them by their final paths.
pub fn write(
    out: &Path,
    args: &ValidateArgs,
    scene: &Scene,
    validation: &Validation,
    report: &mut ValidationReport,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let name = &scene.name;
    let mut plots = vec![
        ("speed-error.svg", "Speed against error", plot::speed_error(name, validation)),
        ("overlay.svg", "Both models over time", plot::overlay(scene, validation)),
    ];
    if scene.kind() != SceneKind::Bodies {
        plots.push(("difference.svg", "Difference over time", plot::difference(scene, validation)));
    }
    let pictures = save_pictures(out, plots)?;
    write_table(&out.join("series.csv"), |mut file| {
        write_series(&mut file, scene, [&validation.reference, &validation.engine])
    })?;
    let mut reference = scene.clone();
    reference.apply_preset(Preset::Reference);
    let runs = vec![
        record_run(Model::Analytic, &reference, &args.scene, &out.join("analytic.mcap"), interrupt)?,
        record_run(Model::Engine, scene, &args.scene, &out.join("engine.mcap"), interrupt)?,
    ];

    // Pages are shared, so the page does not contain local paths.
    write_page(out, name, &scene.description, runs, report.report(), pictures)?;
    report.directory = args.out.as_ref().map(|out| out.display().to_string());
    report.files = Some(files(scene).iter().map(ToString::to_string).collect());
    save(&out.join(REPORT_FILE), &report.report().to_string())?;
    save(&out.join("report.json"), &report.json())
}

/// Writes pictures, each given by file, title and SVG; returns them for the page.
fn save_pictures(out: &Path, plots: Vec<(&str, &str, String)>) -> Result<Vec<Picture>, Failure> {
    let save_one = |(file, title, svg): (&str, &str, String)| {
        save(&out.join(file), &svg)?;
        Ok(Picture { title: title.to_string(), svg })
    };
    plots.into_iter().map(save_one).collect()
}

/// Writes the page of a validation with its runs, its report and its first picture. The other pictures are omitted
/// because the page itself plots the runs.
fn write_page(
    out: &Path,
    name: &str,
    description: &str,
    runs: Vec<Playback>,
    report: Report,
    mut pictures: Vec<Picture>,
) -> Result<(), Failure> {
    pictures.truncate(1);
    let text = render_page(&Page {
        title: name.to_string(),
        description: description.to_string(),
        runs,
        notes: vec![Note { title: "Validation".to_string(), text: report }],
        pictures,
    });
    save(&out.join(PAGE_FILE), &text)
}

/// Writes a table atomically; `rows` writes its contents.
fn write_table(path: &Path, rows: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    let written = replace_file(path, |out| rows(out));
    written.map_err(|error| write_failure(path, error))
}

/// Runs and logs one model with the same settings as `phalanx run`; returns the run for the page.
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
    let mut summary = run.report(model, scene);
    if scene.kind() == SceneKind::Bodies {
        // Pages of scenes of discs do not show the result of the check.
        summary.check = None;
    }
    commit_log(path, interrupt, run.result, run.log)?;
    Ok(recorder.into_playback(model.name(), scene, summary.report()))
}

/// Commits the log of a completed run.
///
/// # Errors
/// Returns an error if the run was not completed, or the log could not be written.
fn commit_log(
    path: &Path,
    interrupt: &Interrupt,
    result: Result<Outcome, FailedRun>,
    log: Result<Option<LogFile>, SinkError>,
) -> Result<(), Failure> {
    match (result, interrupt.signal()) {
        (Ok(_), _) => {
            let result = log.and_then(|log| log.map_or(Ok(()), LogFile::commit));
            result.map_err(|error| write_failure(path, error))
        }
        (Err(_), Some(signal)) => {
            // The target is unchanged; the partial log of a validation is of no use.
            let _ = fs::remove_file(log::partial_name(path));
            Err(Failure::incomplete(format!(
                "the validation was interrupted by {signal} while it wrote its files; {} and the reports are unchanged",
                path.display()
            )))
        }
        (Err(FailedRun { error, .. }), None) => Err(write_failure(path, error.reason)),
    }
}
