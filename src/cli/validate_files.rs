//! The files of `phalanx validate --out`: reports, series, pictures, logs.

use std::fmt::Display;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::time::Instant;

use super::Failure;
use super::interrupt::Interrupt;
use super::replace::{probe, replace};
use super::run::{info, unstarted};
use crate::log::{self, FileWriter, Severity};
use crate::page::{Film, Note, Page, Picture, Reel, page};
use crate::plot;
use crate::report::{self, RunReport, ValidationReport, series, validation_json, validation_text};
use crate::scene::{Preset, Scene};
use crate::trace::{Event, Model, Sample, Sink, SinkError, run};
use crate::validate::{Validation, While};

/// The file that says what the others are; written last.
const REPORT: &str = "report.txt";

/// Both models in motion, laid over each other.
pub(super) const PAGE: &str = "page.html";

/// Everything that is in the directory in the end.
const FILES: [&str; 9] = [
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

/// Makes the directory and tries to write there, before anything is simulated.
pub fn directory(out: &Path) -> Result<(), Failure> {
    if out.exists() && !out.is_dir() {
        return Err(Failure::bad_input(format!(
            "cannot write the results to {}: that is a file; remove it first or give another directory",
            out.display()
        )));
    }
    fs::create_dir_all(out).map_err(|error| {
        Failure::bad_input(format!(
            "cannot make the directory {}: {error}; give one where you may write",
            out.display()
        ))
    })?;
    probe(&out.join(REPORT)).map_err(|error| {
        let path = out.join(REPORT);
        Failure::bad_input(format!("cannot write {}: {error}; give a directory where you may write", path.display()))
    })
}

/// Writes everything and says in the report what was written.
pub fn write(
    out: &Path,
    scene_file: &Path,
    scene: &Scene,
    found: &Validation,
    report: &mut ValidationReport,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let name = &scene.name;
    let pictures = pictures(
        out,
        [
            ("speed-error.svg", "Speed against error", plot::speed_error(name, found)),
            ("overlay.svg", "Both models over time", plot::overlay(name, found)),
            ("difference.svg", "Difference over time", plot::difference(name, found)),
        ],
    )?;
    table(&out.join("series.csv"), |mut file| {
        series(&mut file, &found.reference, &found.engine, scene.log.numeric_hz)
    })?;
    let reference = Scene { integrator: scene.integrator.with_preset(Preset::Reference), ..scene.clone() };
    let runs = vec![
        record(Model::Analytic, &reference, scene_file, &out.join("analytic.mcap"), interrupt)?,
        record(Model::Engine, scene, scene_file, &out.join("engine.mcap"), interrupt)?,
    ];

    report.directory = Some(out.display().to_string());
    report.files = Some(FILES.map(String::from).to_vec());
    let text = validation_text(report);
    show(out, name, &scene.description, runs, &text, pictures)?;
    save(&out.join(REPORT), &text)?;
    save(&out.join("report.json"), &validation_json(report))
}

/// Writes pictures, each a file with a title; returns them for the page.
pub(super) fn pictures<const N: usize>(
    out: &Path,
    drawn: [(&str, &str, Result<String, plot::DrawError>); N],
) -> Result<Vec<Picture>, Failure> {
    let save_one = |(file, title, picture): (&str, &str, Result<String, plot::DrawError>)| {
        let path = out.join(file);
        let svg = picture.map_err(|error| broken(&path, error))?;
        save(&path, &svg)?;
        Ok(Picture { title: title.to_string(), svg })
    };
    drawn.into_iter().map(save_one).collect()
}

/// Writes the page of a validation: its runs, its report, and the first of its pictures (the others are plots of the same
/// runs, which the page draws itself).
pub(super) fn show(
    out: &Path,
    name: &str,
    description: &str,
    runs: Vec<Film>,
    report: &str,
    mut pictures: Vec<Picture>,
) -> Result<(), Failure> {
    pictures.truncate(1);
    let text = page(&Page {
        title: name.to_string(),
        description: description.to_string(),
        runs,
        notes: vec![Note { title: "Validation".to_string(), text: report.to_string() }],
        pictures,
    });
    save(&out.join(PAGE), &text)
}

pub(super) fn save(path: &Path, text: &str) -> Result<(), Failure> {
    replace(path, |out| out.write_all(text.as_bytes())).map_err(|error| broken(path, error))
}

/// Both models side by side, as `rows` writes them.
pub(super) fn table(path: &Path, rows: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    let written = replace(path, rows);
    written.map_err(|error| broken(path, error))
}

/// Logs one model, sample rate and all as `phalanx run` does; returns the same for the page.
fn record(model: Model, scene: &Scene, scene_file: &Path, path: &Path, interrupt: &Interrupt) -> Result<Film, Failure> {
    let log = log::create(path, &info(scene, scene_file, model.name())).map_err(unstarted)?;
    let mut kept = Kept { log, reel: Reel::default() };
    let go_on = || interrupt.signal().is_none();
    let start = Instant::now();
    let outcome = run(model, scene, &mut While { sink: &mut kept, go_on: &go_on })
        .map_err(|error| unfinished(path, interrupt, error.is_stop(), error))?;
    let summary = RunReport::completed(scene, model.name(), start.elapsed().as_secs_f64(), &outcome, None);
    let Kept { mut log, reel } = kept;
    log.note(outcome.last.time_s, Severity::Info, "completed").map_err(|error| broken(path, error))?;
    log.keep().map_err(|error| broken(path, error))?;
    Ok(reel.film(model.name(), scene, &report::text(&summary)))
}

/// What is kept of a run: its log, and the film of it.
struct Kept {
    log: FileWriter,
    reel: Reel<Sample, Event>,
}

impl Sink for Kept {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.reel.sample(sample)?;
        self.log.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.reel.event(event)?;
        self.log.event(event)
    }
}

/// Why a log of a validation was not finished: a signal came, or it could not be written.
pub(super) fn unfinished(path: &Path, interrupt: &Interrupt, stopped: bool, error: impl Display) -> Failure {
    match interrupt.signal().filter(|_| stopped) {
        Some(signal) => {
            // Its place is untouched, and half a log of a validation is of no use.
            let _ = fs::remove_file(log::partial_name(path));
            Failure::incomplete(format!(
                "the validation was interrupted by {signal} while it wrote its files: {} and the reports are as they were \
                 before",
                path.display()
            ))
        }
        None => broken(path, error),
    }
}

pub(super) fn broken(path: &Path, error: impl Display) -> Failure {
    Failure::incomplete(format!("cannot write {}: {error}", path.display()))
}
