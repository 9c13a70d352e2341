//! `phalanx study`: what a choice of settings does to a result.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::interrupt::{self, Interrupt};
use super::output::answer;
use super::progress::Count;
use super::set::{SetArgs, files};
use super::study_stability::{self, StabilityArgs};
use super::targets::reserve;
use super::{Failure, Status};
use crate::plot;
use crate::report::step_size::step_size_csv;
use crate::scene::Scene;
use crate::scene::Words;
use crate::scene::words::SceneKind;
use crate::study::step_size::{StudyError, step_size};
use crate::wording::Reported;

/// The shipped scene, so that the command works from anywhere.
const STEP_SIZE_SCENE: &str = include_str!("../../scenes/laws/step-size.toml");

/// Everything that is in the directory in the end.
const FILES: [&str; 4] = ["step-size.txt", "step-size.json", "step-size.csv", "step-size.svg"];

#[derive(Debug, Subcommand)]
pub enum StudyCommand {
    Stability(StabilityArgs),
    StepSize(StepSizeArgs),
}

/// The force of an impact against the step size, by formulation: thesis Fig. B.3.
///
/// Runs the impact of a scene of discs with the engine and the scene's laws, with the engine and rapier's own contact (both
/// with fixed steps from 1 % to 0.001 % of the simulated time), and with the analytic model at a ladder of tolerances, and
/// compares the force with that of the analytic model at its reference preset. rapier's own contact is rigid and has no
/// finite force: impulse over step stands in for it, and it is told the restitution of the reference.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx study step-size\n  phalanx study step-size my-impact.toml --out study\n  phalanx study \
                  step-size --quick --json > study.json"
)]
pub struct StepSizeArgs {
    /// Scene of discs (TOML) with an impact that rebounds; the shipped scenes/laws/step-size.toml if none is given
    scene: Option<PathBuf>,

    #[command(flatten)]
    set: SetArgs,

    /// Write step-size.txt, .json, .csv and .svg there; the directory is made if need be
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,

    /// Leave out fixed steps below 0.01 % of the simulated time
    #[arg(long)]
    quick: bool,
}

/// Runs the command.
pub fn run(command: &StudyCommand) -> Result<Status, Failure> {
    match command {
        StudyCommand::Stability(args) => study_stability::run(args),
        StudyCommand::StepSize(args) => run_step_size(args),
    }
}

fn run_step_size(args: &StepSizeArgs) -> Result<Status, Failure> {
    let scene = discs(args.scene.as_deref(), &args.set)?;
    let reads = args.scene.as_deref().map(files).unwrap_or_default();
    let folder = reserve(&[("the scene", &reads)], &[], ("--out", args.out.as_deref(), &FILES))?;
    let interrupt = Interrupt::listen()?;
    let mut count = Count::new();
    let mut reached = (0, 0);
    let mut tell = |done, total, next: &str| {
        reached = (done, total);
        count.show(done, total, next);
    };
    let result = step_size(&scene, args.quick, &mut tell, &|| interrupt.signal().is_none());
    count.clear();
    let study = result.map_err(|error| match (error, interrupt.signal()) {
        (StudyError::Simulation { .. }, Some(signal)) => {
            interrupt::broken_off("the study", signal, reached, args.out.is_some())
        }
        (error @ (StudyError::NoImpact | StudyError::Kind(_)), _) => Failure::bad_input(error),
        (error @ StudyError::Simulation { .. }, None) => Failure::incomplete(error),
    })?;
    if let Some(folder) = folder {
        let texts = [study.report().to_string(), study.json(), step_size_csv(&study), plot::step_size(&study)];
        folder.write(&FILES, &texts)?;
    }
    answer(&study, args.json)?;
    Ok(Status::Done)
}

/// The scene of discs in a file, or the shipped one.
fn discs(path: Option<&Path>, set: &SetArgs) -> Result<Scene, Failure> {
    let scene = match path {
        Some(path) => set.load_any(path)?,
        None => set.parse_any(STEP_SIZE_SCENE, "step-size.toml")?,
    };
    match scene.kind() {
        SceneKind::Bodies => Ok(scene),
        kind => Err(Failure::bad_input(format!(
            "{} is the scene of a {}; this study takes a scene of discs (kind = \"bodies\"), like \
             scenes/laws/step-size.toml",
            path.unwrap_or(Path::new("")).display(),
            kind.word(),
        ))),
    }
}
