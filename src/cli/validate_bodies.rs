//! `phalanx validate` of a scene of discs: the comparison, and the files of `--out`.

use std::path::Path;

use super::folder::Folder;
use super::interrupt::Interrupt;
use super::output::{print, show};
use super::validate::{ValidateArgs, stopped, watched};
use super::validate_files::{PAGE, pictures, record, save, show_page, table};
use super::{Failure, Status};
use crate::plot;
use crate::report::{BodiesValidationReport, bodies_series, bodies_validation_json, bodies_validation_text};
use crate::scene::{BodiesScene, Preset};
use crate::trace::{Model, RunError};
use crate::validate::{StudyError, Subject, Validation};

/// Everything that is in the directory in the end.
const FILES: [&str; 8] =
    ["report.txt", "report.json", PAGE, "series.csv", "speed-error.svg", "overlay.svg", "analytic.mcap", "engine.mcap"];

/// Runs the command.
pub fn run(args: &ValidateArgs, scene: &BodiesScene) -> Result<Status, Failure> {
    let folder = args.out.as_deref().map(|out| Folder::open(out, &FILES)).transpose()?;
    let interrupt = Interrupt::listen()?;
    let found = watched(scene, args, &interrupt, incomplete)?;
    let mut report = BodiesValidationReport::new(scene, &found, args.quick);
    if let Some(folder) = folder {
        folder.fill(|out| write(out, args, scene, &found, &mut report, &interrupt))?;
    }
    match args.json {
        true => print(&bodies_validation_json(&report)),
        false => show(&bodies_validation_text(&report)),
    }?;
    Ok(if report.passed { Status::Done } else { Status::CheckFailed })
}

fn incomplete(error: StudyError<RunError>) -> Failure {
    match error.error {
        RunError::Simulation { failure, .. } => stopped(error.model, &failure),
        RunError::Sink(sink) => Failure::incomplete(format!("the {} model stopped: {sink}", error.model.name())),
    }
}

fn write(
    out: &Path,
    args: &ValidateArgs,
    scene: &BodiesScene,
    found: &Validation<BodiesScene>,
    report: &mut BodiesValidationReport,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let pictures = pictures(
        out,
        [
            ("speed-error.svg", "Speed against error", plot::bodies_speed_error(&scene.name, found)),
            ("overlay.svg", "Both models over time", plot::bodies_overlay(scene, found)),
        ],
    )?;
    table(&out.join("series.csv"), |mut file| bodies_series(&mut file, scene, [&found.reference, &found.engine]))?;
    let reference = scene.with_integrator(scene.integrator.with_preset(Preset::Reference));
    let runs = vec![
        record(Model::Analytic, &reference, &args.scene, &out.join("analytic.mcap"), interrupt)?,
        record(Model::Engine, scene, &args.scene, &out.join("engine.mcap"), interrupt)?,
    ];

    show_page(out, &scene.name, &scene.description, runs, bodies_validation_text(report), pictures)?;
    report.directory = args.out.as_ref().map(|out| out.display().to_string());
    report.files = Some(FILES.map(String::from).to_vec());
    save(&out.join("report.txt"), &bodies_validation_text(report).to_string())?;
    save(&out.join("report.json"), &bodies_validation_json(report))
}
