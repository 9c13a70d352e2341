//! The files of `phalanx validate --out`: reports, series, pictures, logs.

use std::fmt::Display;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

use super::Failure;
use super::run::info;
use crate::log::{self, Severity};
use crate::plot;
use crate::report::{ValidationReport, series, validation_json, validation_text};
use crate::scene::{Integrator, Preset, Scene};
use crate::validate::{Model, Validation, run};

/// The first file written: it shows whether the others can be.
const REPORT: &str = "report.txt";

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
    File::create(out.join(REPORT)).map(drop).map_err(|error| {
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
) -> Result<(), Failure> {
    let name = &scene.name;
    let pictures = [
        ("speed-error.svg", plot::speed_error(name, found)),
        ("overlay.svg", plot::overlay(name, found)),
        ("difference.svg", plot::difference(name, found)),
    ];
    let mut written = Vec::new();
    for (file, picture) in pictures {
        let path = out.join(file);
        let text = picture.map_err(|error| broken(&path, error))?;
        fs::write(&path, text).map_err(|error| broken(&path, error))?;
        written.push(path);
    }

    let path = out.join("series.csv");
    let table = File::create(&path).and_then(|file| {
        let mut file = BufWriter::new(file);
        series(&mut file, &found.reference, &found.engine, scene.log.numeric_hz)?;
        file.flush()
    });
    table.map_err(|error| broken(&path, error))?;
    written.push(path);

    let reference = Scene {
        integrator: Integrator { max_steps: scene.integrator.max_steps, ..Integrator::preset(Preset::Reference) },
        ..scene.clone()
    };
    for (model, scene) in [(Model::Analytic, &reference), (Model::Engine, scene)] {
        let path = out.join(format!("{}.mcap", model.name()));
        record(model, scene, scene_file, &path)?;
        written.push(path);
    }

    let reports = [out.join(REPORT), out.join("report.json")];
    written.extend(reports.clone());
    report.files = Some(written.iter().map(|path| path.display().to_string()).collect());
    for (path, text) in reports.iter().zip([validation_text(report), validation_json(report)]) {
        fs::write(path, text).map_err(|error| broken(path, error))?;
    }
    Ok(())
}

/// Logs one model, sample rate and all as `phalanx run` does.
fn record(model: Model, scene: &Scene, scene_file: &Path, path: &Path) -> Result<(), Failure> {
    let mut log = log::create(path, &info(scene, scene_file, model.name())).map_err(Failure::bad_input)?;
    let outcome = run(model, scene, &mut log).map_err(|error| broken(path, error))?;
    log.note(outcome.last.time_s, Severity::Info, "completed").map_err(|error| broken(path, error))?;
    log.finish().map_err(|error| broken(path, error))?;
    Ok(())
}

fn broken(path: &Path, error: impl Display) -> Failure {
    Failure::incomplete(format!("cannot write {}: {error}", path.display()))
}
