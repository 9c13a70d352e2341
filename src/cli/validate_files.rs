//! The files of `phalanx validate --out`: reports, series, pictures, logs.

use std::fmt::Display;
use std::fs;
use std::io::{self, Write};
use std::path::Path;

use super::Failure;
use super::interrupt::Interrupt;
use super::replace::{probe, replace};
use super::run::{info, unstarted};
use crate::log::{self, Severity};
use crate::plot;
use crate::report::{ValidationReport, series, validation_json, validation_text};
use crate::scene::{Preset, Scene};
use crate::trace::{Model, Thinned, run};
use crate::validate::{Validation, While};

/// The file that says what the others are; written last.
const REPORT: &str = "report.txt";

/// Everything that is in the directory in the end.
const FILES: [&str; 8] = [
    REPORT,
    "report.json",
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
    for (file, picture) in [
        ("speed-error.svg", plot::speed_error(name, found)),
        ("overlay.svg", plot::overlay(name, found)),
        ("difference.svg", plot::difference(name, found)),
    ] {
        let path = out.join(file);
        save(&path, &picture.map_err(|error| broken(&path, error))?)?;
    }
    table(&out.join("series.csv"), |mut file| {
        series(&mut file, &found.reference, &found.engine, scene.log.numeric_hz)
    })?;
    let reference = Scene { integrator: scene.integrator.with_preset(Preset::Reference), ..scene.clone() };
    record(Model::Analytic, &reference, scene_file, &out.join("analytic.mcap"), interrupt)?;
    record(Model::Engine, scene, scene_file, &out.join("engine.mcap"), interrupt)?;

    report.directory = Some(out.display().to_string());
    report.files = Some(FILES.map(String::from).to_vec());
    save(&out.join(REPORT), &validation_text(report))?;
    save(&out.join("report.json"), &validation_json(report))
}

pub(super) fn save(path: &Path, text: &str) -> Result<(), Failure> {
    replace(path, |out| out.write_all(text.as_bytes())).map_err(|error| broken(path, error))
}

/// Both models side by side, as `rows` writes them.
pub(super) fn table(path: &Path, rows: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    let written = replace(path, rows);
    written.map_err(|error| broken(path, error))
}

/// Logs one model, sample rate and all as `phalanx run` does.
fn record(model: Model, scene: &Scene, scene_file: &Path, path: &Path, interrupt: &Interrupt) -> Result<(), Failure> {
    let mut log = log::create(path, &info(scene, scene_file, model.name())).map_err(unstarted)?;
    let go_on = || interrupt.signal().is_none();
    let mut thinned = Thinned::new(scene.log.numeric_hz, While { sink: &mut log, go_on: &go_on });
    let outcome =
        run(model, scene, &mut thinned).map_err(|error| unfinished(path, interrupt, error.is_stop(), error))?;
    thinned.end().map_err(|error| broken(path, error))?;
    log.note(outcome.last.time_s, Severity::Info, "run", "completed").map_err(|error| broken(path, error))?;
    log.keep().map_err(|error| broken(path, error))
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
