//! `phalanx study`: effects of settings on results.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::interrupt::{self, Interrupt};
use super::output::print_result;
use super::progress::RunCounter;
use super::set::{SetArgs, source_files};
use super::study_stability::{self, StabilityArgs};
use super::targets::reserve;
use super::{Failure, Status};
use crate::format::ToReport;
use crate::plot;
use crate::report::step_size::step_size_csv;
use crate::scene::Keyword;
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::study::step_size::{StudyError, step_size};

/// The shipped scene, built in so that the command works in any directory.
const STEP_SIZE_SCENE: &str = include_str!("../../scenes/laws/step-size.toml");

/// Files in the output directory.
const FILES: [&str; 4] = ["step-size.txt", "step-size.json", "step-size.csv", "step-size.svg"];

#[derive(Debug, Subcommand)]
pub enum StudyCommand {
    Stability(StabilityArgs),
    StepSize(StepSizeArgs),
}

/// Compare the force of an impact at different step sizes and for several formulations (thesis, Fig. B.3).
///
/// Runs the impact of a scene of discs with the engine and the scene's laws, with the engine and rapier's own contact
/// (both with fixed steps from 1 % to 0.001 % of the simulated time), and with the analytic model at a series of
/// tolerances. The force is compared with the analytic model at its reference preset. rapier's own contact is rigid and
/// has no finite force; it is represented by impulse divided by step, and uses the restitution of the reference.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx study step-size\n  phalanx study step-size my-impact.toml --out study\n  phalanx study \
                  step-size --quick --json > study.json"
)]
pub struct StepSizeArgs {
    /// Disc scene file (TOML) with an impact that rebounds [default: the shipped scenes/laws/step-size.toml]
    scene: Option<PathBuf>,

    #[command(flatten)]
    set: SetArgs,

    /// Write step-size.txt, .json, .csv and .svg to this directory, which is created if needed
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,

    /// Omit fixed steps below 0.01 % of the simulated time
    #[arg(long)]
    quick: bool,
}

/// Runs `phalanx study`.
pub fn run(command: &StudyCommand) -> Result<Status, Failure> {
    match command {
        StudyCommand::Stability(args) => study_stability::run(args),
        StudyCommand::StepSize(args) => run_step_size(args),
    }
}

fn run_step_size(args: &StepSizeArgs) -> Result<Status, Failure> {
    let scene = load_scene(args.scene.as_deref(), &args.set)?;
    let inputs = args.scene.as_deref().map(source_files).unwrap_or_default();
    let directory = reserve(&[("the scene", &inputs)], &[], ("--out", args.out.as_deref(), &FILES))?;
    let interrupt = Interrupt::listen()?;
    let mut counter = RunCounter::new();
    let mut done_and_total = (0, 0);
    let mut report_progress = |done, total, next: &str| {
        done_and_total = (done, total);
        counter.update(done, total, next);
    };
    let result = step_size(&scene, args.quick, &mut report_progress, &|| interrupt.signal().is_none());
    counter.clear();
    let study = result.map_err(|error| match (error, interrupt.signal()) {
        (StudyError::Simulation { .. }, Some(signal)) => {
            interrupt::interrupted_failure("the study", signal, done_and_total, args.out.is_some())
        }
        (error @ (StudyError::NoImpact | StudyError::Kind(_)), _) => Failure::bad_input(error),
        (error @ StudyError::Simulation { .. }, None) => Failure::incomplete(error),
    })?;
    if let Some(directory) = directory {
        let texts = [study.report().to_string(), study.json(), step_size_csv(&study), plot::step_size(&study)];
        directory.write(&FILES, &texts)?;
    }
    print_result(&study, args.json)?;
    Ok(Status::Done)
}

/// Loads the scene of discs from a file, or the shipped one.
fn load_scene(path: Option<&Path>, set: &SetArgs) -> Result<Scene, Failure> {
    let scene = match path {
        Some(path) => set.load_any(path)?,
        None => set.parse_any(STEP_SIZE_SCENE, "step-size.toml")?,
    };
    match scene.kind() {
        SceneKind::Bodies => Ok(scene),
        kind => Err(Failure::bad_input(format!(
            "{} is the scene of a {}; this study needs a scene of discs (kind = \"bodies\"), such as \
             scenes/laws/step-size.toml",
            path.unwrap_or(Path::new("")).display(),
            kind.keyword(),
        ))),
    }
}
