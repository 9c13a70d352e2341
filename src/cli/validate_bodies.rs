//! `phalanx validate` of a scene of discs: the comparison, and the files of `--out`.

use std::path::Path;

use super::interrupt::Interrupt;
use super::output::print;
use super::run::{info, unstarted};
use super::validate::{ValidateArgs, stopped, watched};
use super::validate_files::{broken, directory, save, table, unfinished};
use super::{Failure, Status};
use crate::log::{self, Severity};
use crate::plot;
use crate::report::{BodiesValidationReport, bodies_series, bodies_validation_json, bodies_validation_text};
use crate::scene::{BodiesScene, Preset};
use crate::trace::bodies::{BodiesRunError, run_bodies};
use crate::trace::{Model, Thinned};
use crate::validate::{StudyError, Subject, Validation, While};

/// Everything that is in the directory in the end.
const FILES: [&str; 7] =
    ["report.txt", "report.json", "series.csv", "speed-error.svg", "overlay.svg", "analytic.mcap", "engine.mcap"];

/// Runs the command.
pub fn run(args: &ValidateArgs, scene: &BodiesScene) -> Result<Status, Failure> {
    if let Some(out) = &args.out {
        directory(out)?;
    }
    let interrupt = Interrupt::listen()?;
    let found = watched(scene, args, &interrupt, incomplete)?;
    let mut report = BodiesValidationReport::new(scene, &found, args.quick);
    if let Some(out) = &args.out {
        write(out, &args.scene, scene, &found, &mut report, &interrupt)?;
    }
    print(&match args.json {
        true => bodies_validation_json(&report),
        false => bodies_validation_text(&report),
    })?;
    Ok(if report.passed { Status::Done } else { Status::CheckFailed })
}

fn incomplete(error: StudyError<BodiesRunError>) -> Failure {
    match error.error {
        BodiesRunError::Simulation { failure, .. } => stopped(error.model, &failure),
        BodiesRunError::Sink(sink) => Failure::incomplete(format!("the {} model stopped: {sink}", error.model.name())),
    }
}

fn write(
    out: &Path,
    scene_file: &Path,
    scene: &BodiesScene,
    found: &Validation<BodiesScene>,
    report: &mut BodiesValidationReport,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    for (file, picture) in [
        ("speed-error.svg", plot::bodies_speed_error(&scene.name, found)),
        ("overlay.svg", plot::bodies_overlay(scene, found)),
    ] {
        let path = out.join(file);
        save(&path, &picture.map_err(|error| broken(&path, error))?)?;
    }
    table(&out.join("series.csv"), |mut file| bodies_series(&mut file, scene, [&found.reference, &found.engine]))?;
    let reference = scene.with_integrator(scene.integrator.with_preset(Preset::Reference));
    record(Model::Analytic, &reference, scene_file, &out.join("analytic.mcap"), interrupt)?;
    record(Model::Engine, scene, scene_file, &out.join("engine.mcap"), interrupt)?;

    report.directory = Some(out.display().to_string());
    report.files = Some(FILES.map(String::from).to_vec());
    save(&out.join("report.txt"), &bodies_validation_text(report))?;
    save(&out.join("report.json"), &bodies_validation_json(report))
}

/// Logs one model, sample rate and all as `phalanx run` does.
fn record(
    model: Model,
    scene: &BodiesScene,
    scene_file: &Path,
    path: &Path,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let mut log = log::create(path, &info(scene, scene_file, model.name())).map_err(unstarted)?;
    let go_on = || interrupt.signal().is_none();
    let mut thinned = Thinned::new(scene.log.numeric_hz, While { sink: &mut log, go_on: &go_on });
    let outcome =
        run_bodies(model, scene, &mut thinned).map_err(|error| unfinished(path, interrupt, error.is_stop(), error))?;
    thinned.end().map_err(|error| broken(path, error))?;
    log.note(outcome.last.time_s, Severity::Info, "run", "completed").map_err(|error| broken(path, error))?;
    log.keep().map_err(|error| broken(path, error))
}
