//! The files of `phalanx validate --out`: reports, series, pictures, logs.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use super::Failure;
use super::interrupt::Interrupt;
use super::run::{info, unstarted};
use super::saved::{PAGE, broken, save};
use super::simulate::{Broken, Checking, Limits, simulate};
use super::validate_args::ValidateArgs;
use crate::files::replace;
use crate::log::{self, LogFile};
use crate::page::{Film, Note, Page, Picture, Reel, page};
use crate::plot;
use crate::report::validation::{ValidationReport, series};
use crate::scene::words::SceneKind;
use crate::scene::{Preset, Scene};
use crate::trace::{Model, Outcome, SinkError};
use crate::validate::Validation;
use crate::wording::{Report, Reported};

/// The file that says what the others are; written last.
const REPORT: &str = "report.txt";

/// Everything that is in the directory in the end, of fingers and of discs.
const FINGER: [&str; 9] = [
    REPORT,
    "report.json",
    PAGE,
    "series.csv",
    "speed-error.svg",
    "overlay.svg",
    "difference.svg",
    "analytic.mcap",
    "engine.mcap",
];
const DISCS: [&str; 8] =
    [REPORT, "report.json", PAGE, "series.csv", "speed-error.svg", "overlay.svg", "analytic.mcap", "engine.mcap"];

/// The files of a validation.
pub fn files(scene: &Scene) -> &'static [&'static str] {
    match scene.kind() {
        SceneKind::Finger | SceneKind::Gripper => &FINGER,
        SceneKind::Bodies => &DISCS,
    }
}

/// Writes everything, and says in the report where it is to be in the end.
pub fn write(
    out: &Path,
    args: &ValidateArgs,
    scene: &Scene,
    found: &Validation,
    report: &mut ValidationReport,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let name = &scene.name;
    let mut drawn = vec![
        ("speed-error.svg", "Speed against error", plot::speed_error(name, found)),
        ("overlay.svg", "Both models over time", plot::overlay(scene, found)),
    ];
    if scene.kind() != SceneKind::Bodies {
        drawn.push(("difference.svg", "Difference over time", plot::difference(scene, found)));
    }
    let pictures = pictures(out, drawn)?;
    table(&out.join("series.csv"), |mut file| series(&mut file, scene, [&found.reference, &found.engine]))?;
    let mut reference = scene.clone();
    reference.integrate_by(Preset::Reference);
    let runs = vec![
        record(Model::Analytic, &reference, &args.scene, &out.join("analytic.mcap"), interrupt)?,
        record(Model::Engine, scene, &args.scene, &out.join("engine.mcap"), interrupt)?,
    ];

    // A page is given to others: it does not say where it was made.
    show_page(out, name, &scene.description, runs, report.report(), pictures)?;
    report.directory = args.out.as_ref().map(|out| out.display().to_string());
    report.files = Some(files(scene).iter().map(ToString::to_string).collect());
    save(&out.join(REPORT), &report.report().to_string())?;
    save(&out.join("report.json"), &report.json())
}

/// Writes pictures, each a file with a title; returns them for the page.
fn pictures(out: &Path, drawn: Vec<(&str, &str, String)>) -> Result<Vec<Picture>, Failure> {
    let save_one = |(file, title, svg): (&str, &str, String)| {
        save(&out.join(file), &svg)?;
        Ok(Picture { title: title.to_string(), svg })
    };
    drawn.into_iter().map(save_one).collect()
}

/// Writes the page of a validation: its runs, its report, and the first of its pictures (the others are plots of the same
/// runs, which the page draws itself).
fn show_page(
    out: &Path,
    name: &str,
    description: &str,
    runs: Vec<Film>,
    report: Report,
    mut pictures: Vec<Picture>,
) -> Result<(), Failure> {
    pictures.truncate(1);
    let text = page(&Page {
        title: name.to_string(),
        description: description.to_string(),
        runs,
        notes: vec![Note { title: "Validation".to_string(), text: report }],
        pictures,
    });
    save(&out.join(PAGE), &text)
}

/// Both models side by side, as `rows` writes them.
fn table(path: &Path, rows: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    let written = replace(path, |out| rows(out));
    written.map_err(|error| broken(path, error))
}

/// Logs one model, sample rate and all as `phalanx run` does; returns the same for the page.
fn record(model: Model, scene: &Scene, scene_file: &Path, path: &Path, interrupt: &Interrupt) -> Result<Film, Failure> {
    let log = log::create(path, &info(scene, scene_file, model.name())).map_err(unstarted)?;
    let mut reel = Reel::default();
    let limits = Limits { interrupt, until_s: f64::INFINITY, checking: Checking::Cheap };
    let run = simulate(model, scene, Some(log), &limits, &mut reel);
    let mut summary = run.report(model, scene);
    if scene.kind() == SceneKind::Bodies {
        // Their page shows the run alone.
        summary.check = None;
    }
    finished(path, interrupt, run.result, run.log)?;
    Ok(reel.film(model.name(), scene, summary.report()))
}

/// Keeps the log of a run that was completed; why not, if a signal came or the log could not be written.
fn finished(
    path: &Path,
    interrupt: &Interrupt,
    result: Result<Outcome, Broken>,
    log: Result<Option<LogFile>, SinkError>,
) -> Result<(), Failure> {
    match (result, interrupt.signal()) {
        (Ok(_), _) => {
            let kept = log.and_then(|log| log.map_or(Ok(()), LogFile::keep));
            kept.map_err(|error| broken(path, error))
        }
        (Err(_), Some(signal)) => {
            // Its place is untouched, and half a log of a validation is of no use.
            let _ = fs::remove_file(log::partial_name(path));
            Err(Failure::incomplete(format!(
                "the validation was interrupted by {signal} while it wrote its files: {} and the reports are as they were \
                 before",
                path.display()
            )))
        }
        (Err(Broken { error, .. }), None) => Err(broken(path, error.reason)),
    }
}
