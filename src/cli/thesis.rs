//! `phalanx thesis`: `reproduce` recomputes the figures of the thesis, with reasons for differences; `volume` and `select` are its
//! design work; `stability` and `step-size` show how settings affect a result.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, Subcommand};

use super::output::{OutputArgs, print_note, print_result, reserve, save, write_failure};
use super::parsers::{number, positive};
use super::progress::Interrupt;
use super::select::{self, SelectArgs};
use super::set::{SetArgs, source_files};
use super::volume::{self, VolumeArgs};
use super::{Failure, Status};
use crate::format::{ToReport, format_duration};
use crate::page::report_page;
use crate::report::reproduce::{Reproduced, ReproductionReport, reproduce};
use crate::report::sweep::ranking_table;
use crate::table;
use crate::thesis::stability::{ACCURACY_RAD, Grid, stability};
use crate::thesis::step_size::step_size;
use crate::units::Dimension;
use phalanx_parallel::ComputeError;

/// The shipped scene, built in so that the command works in any directory.
const STEP_SIZE_SCENE: &str = include_str!("../../scenes/laws/step-size.toml");

impl From<ComputeError> for Failure {
    fn from(error: ComputeError) -> Self {
        match error {
            ComputeError::Unsuitable(_) => Failure::bad_input(error),
            ComputeError::Failed(_) | ComputeError::Stopped { .. } => Failure::incomplete(error),
        }
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum ThesisCommand {
    Reproduce(ReproduceArgs),
    Volume(VolumeArgs),
    Select(SelectArgs),
    Stability(StabilityArgs),
    StepSize(StepSizeArgs),
}

/// Map where the engine is stable and accurate over step size, contact stiffness and contact damping.
///
/// Runs the scene of a finger with the engine at fixed steps. The stiffness k and the largest damping c_max of both
/// contacts are scaled by each pair of factors; the joint limit keeps its law. The reference for each pair is the
/// analytic model at its reference preset, up to `[validate] until`.
///
/// A run is "failed" if it ended with an error, if a number was not finite, if mechanical energy exceeded the motor's
/// work by more than 10 % of the energy exchanged in the reference run, if the dissipated energy decreased by more than
/// that, or if the penetration of a contact or the joint limit was larger than the total energy allows. A run is
/// "accurate" if it has not failed and its joint angles stay within the bound at all times. All other runs are stable
/// but inaccurate. Pairs without a completed reference are not judged.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phalanx thesis stability scenes/experiment-95.toml\n  phalanx thesis stability \
                  scenes/experiment-95.toml --out map\n  phalanx thesis stability scenes/experiment-95.toml --steps \"100 us, 10 us\" \
                  --stiffness 1,100 --damping 0,1 --json\n\n--out writes table.txt, stability.json, stability.csv and stability.svg. Exit status: 0 done, even if runs of the map failed; 2 bad input; 3 \
                  interrupted, or files could not be written.")]
pub(crate) struct StabilityArgs {
    /// Scene file (TOML) of a finger with an object
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Fixed steps, comma-separated, with units [default: 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6 and 1e-6 s]
    #[arg(long, value_name = "TIMES", value_delimiter = ',', value_parser = positive(Dimension::Time, STEPS), conflicts_with = "quick")]
    steps: Vec<f64>,

    /// Factors of the contact stiffness k, comma-separated, above 0 [default: 0.01, 1, 100, 1e4]
    #[arg(long, value_name = "FACTORS", value_delimiter = ',', value_parser = number(|x| (f64::MIN_POSITIVE..=f64::MAX).contains(x), STIFFNESS))]
    stiffness: Vec<f64>,

    /// Factors of the contact damping c_max, comma-separated, 0 or more [default: 0, 0.001, 1, 10]
    #[arg(long, value_name = "FACTORS", value_delimiter = ',', value_parser = number(|x| (0.0..=f64::MAX).contains(x), DAMPING))]
    damping: Vec<f64>,

    /// Largest angle difference of an accurate run, with its unit [default: 1e-3 rad]
    #[arg(long, value_name = "ANGLE", value_parser = positive(Dimension::Angle, "an angle such as \"1e-3 rad\""))]
    accurate: Option<f64>,

    #[command(flatten)]
    output: OutputArgs,

    /// Omit steps below 1e-5 s
    #[arg(long)]
    quick: bool,
}

/// Compare the force of an impact at different step sizes and for several formulations (thesis, Fig. B.3).
///
/// Runs the impact of a scene of discs with the engine and the scene's laws, with the engine and rapier's own contact
/// (both with fixed steps from 1 % to 0.001 % of the simulated time), and with the analytic model at a series of
/// tolerances. The force is compared with the analytic model at its reference preset. rapier's own contact is rigid and
/// has no finite force; it is represented by impulse divided by step, and uses the restitution of the reference.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx thesis step-size\n  phalanx thesis step-size my-impact.toml --out study\n  phalanx study \
                  step-size --quick --json > study.json\n\n--out writes step-size.txt, .json, .csv and .svg."
)]
pub(crate) struct StepSizeArgs {
    /// Disc scene file (TOML) with an impact that rebounds [default: the shipped scenes/laws/step-size.toml]
    scene: Option<PathBuf>,

    #[command(flatten)]
    set: SetArgs,

    #[command(flatten)]
    output: OutputArgs,

    /// Omit fixed steps below 0.01 % of the simulated time
    #[arg(long)]
    quick: bool,
}

/// Accepted values in messages.
const STEPS: &str = "times such as \"100 us, 10 us\"";
const STIFFNESS: &str = "factors above 0, such as 0.01,1,100";
const DAMPING: &str = "factors of 0 or more, such as 0,1,10";

pub(super) fn run(command: &ThesisCommand) -> Result<Status, Failure> {
    match command {
        ThesisCommand::Reproduce(args) => run_reproduce(args),
        ThesisCommand::Volume(args) => volume::run(args),
        ThesisCommand::Select(args) => select::run(args),
        ThesisCommand::Stability(args) => run_stability(args),
        ThesisCommand::StepSize(args) => run_step_size(args),
    }
}

fn run_stability(args: &StabilityArgs) -> Result<Status, Failure> {
    let scene = args.set.load_any(&args.scene)?;
    if scene.finger_count() != 1 {
        return Err(Failure::bad_input(format!(
            "{} is {}; this study needs the scene of a finger (kind = \"finger\"), such as \
             scenes/experiment-95.toml",
            args.scene.display(),
            if scene.finger_count() == 2 { "the scene of a gripper" } else { "the scene of a mechanism" }
        )));
    }
    let files = ["stability.json", "stability.csv", "stability.svg", "table.txt"];
    let directory = reserve(&[("the scene", &source_files(&args.scene))], &[], (args.output.out.as_deref(), &files))?;
    let (grid, accuracy_rad) = (build_grid(args), args.accurate.unwrap_or(ACCURACY_RAD));
    let task = ["the study", "parts", args.output.unwritten()];
    let study = Interrupt::listen()?.compute(task, |monitor| stability(&scene, &grid, accuracy_rad, monitor))?;
    directory.write(files, || [study.json(), study.csv(), study.picture(), study.report().to_string()])?;
    print_result(&study, args.output.json)
}

fn run_step_size(args: &StepSizeArgs) -> Result<Status, Failure> {
    let (scene, inputs) = match &args.scene {
        Some(path) => (args.set.load_any(path)?, source_files(path)),
        None => (args.set.parse_any(STEP_SIZE_SCENE, "step-size.toml")?, Vec::new()),
    };
    let files = ["step-size.txt", "step-size.json", "step-size.csv", "step-size.svg"];
    let directory = reserve(&[("the scene", &inputs)], &[], (args.output.out.as_deref(), &files))?;
    let task = ["the study", "parts", args.output.unwritten()];
    let study = Interrupt::listen()?.compute(task, |monitor| step_size(&scene, args.quick, monitor))?;
    directory.write(files, || [study.report().to_string(), study.json(), study.csv(), study.picture()])?;
    print_result(&study, args.output.json)
}

/// Builds the grid: the given values, else those of the standard grid.
fn build_grid(args: &StabilityArgs) -> Grid {
    let mut grid = Grid::standard(args.quick);
    let lists = [
        (&mut grid.steps_s, &args.steps),
        (&mut grid.stiffness_factors, &args.stiffness),
        (&mut grid.damping_factors, &args.damping),
    ];
    for (values, given) in lists.into_iter().filter(|(_, given)| !given.is_empty()) {
        values.clone_from(given);
        values.sort_by(f64::total_cmp);
    }
    if !args.steps.is_empty() {
        grid.steps_s.reverse();
    }
    grid
}

/// Reproduce the thesis: sizing, statics, volumes, 384 simulations, selection, design 95 and its CAD model.
///
/// Every number printed in the thesis is recomputed and compared with the thesis and with the value expected from the
/// corrected equations; the reason for each difference is given. Simulations whose class depends on the tolerances
/// are listed.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx thesis reproduce\n  phalanx thesis reproduce --out report\n  phalanx thesis reproduce --quick --json > \
                  report.json\n\n--out writes report.md with figures/, report.html (self-contained), report.json, results.csv and ranking.csv. Exit status: 0 every value is as expected; 1 a value is outside its bounds; 3 something \
                  could not be computed or written."
)]
pub(crate) struct ReproduceArgs {
    #[command(flatten)]
    output: OutputArgs,

    /// Compute volumes of 10³ instead of 20³ points; they are shown but not checked
    #[arg(long)]
    quick: bool,
}

fn run_reproduce(args: &ReproduceArgs) -> Result<Status, Failure> {
    let directory = reserve(&[], &[], (args.output.out.as_deref(), &FILES))?;
    let start = Instant::now();
    let task = ["the reproduction", "parts", args.output.unwritten()];
    let reproduced = Interrupt::listen()?.compute(task, |monitor| reproduce(args.quick, 0, monitor))?;
    let wall_s = start.elapsed().as_secs_f64();
    let report = ReproductionReport::new(&reproduced);
    directory.write_with(|out| write(out, &reproduced, &report))?;
    print_result(&report, args.output.json)?;
    if !args.output.json {
        print_note(&format!("computed in {}", format_duration(wall_s)));
    }
    Ok(if reproduced.reproduction.outside > 0 { Status::CheckFailed } else { Status::Done })
}

/// Files in the output directory, without the pictures in figures/.
const FILES: [&str; 6] = ["report.md", "report.html", "report.json", "results.csv", "ranking.csv", "figures/*.svg"];

/// Writes the files of `--out`; the report is written last.
fn write(out: &Path, found: &Reproduced, report: &ReproductionReport<'_>) -> Result<(), Failure> {
    let paper = found.reproduction.paper();
    let figures = out.join("figures");
    fs::create_dir_all(&figures).map_err(|error| write_failure(&figures, error))?;
    for figure in paper.figures() {
        save(&figures.join(&figure.file), &figure.svg)?;
    }
    let ranking = ranking_table(&found.results, &found.selection);
    for (file, table) in [("results.csv", &found.results), ("ranking.csv", &ranking)] {
        table::write(&out.join(file), table).map_err(Failure::incomplete)?;
    }
    save(&out.join("report.json"), &report.json())?;
    save(&out.join("report.html"), &report_page(&paper))?;
    save(&out.join("report.md"), &paper.markdown())
}
