//! `phalanx capture`: which positioning errors a gripper captures.

use std::path::PathBuf;

use clap::Args;

use super::interrupt::{interrupted, run_study};
use super::output::print_result;
use super::parsers::{model, number, positive};
use super::set::{SetArgs, source_files};
use super::targets::reserve;
use super::{Failure, Status};
use crate::format::ToReport;
use crate::plot;
use crate::report::studies::capture_csv;
use crate::scene;
use crate::study::capture::{CaptureError, Plan, SceneSource, capture};
use crate::study::require_gripper;
use crate::trace::Model;
use crate::units::Dimension;

/// Find which positioning errors of the object a gripper captures.
///
/// Simulates the gripper with its object at several positions, up to the largest error on either side of the middle of
/// the palm. Initial angles and automatically sized motors and springs are those for the largest error, because the
/// gripper does not know the position of the object. An object is captured if it is held at the end of the run;
/// bisection finds the edges of the captured range. For each position the report also shows whether the object is
/// centred, the time after which all contacts stay closed, the final position of the object, and whether the grasp is
/// form-closed.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx capture scenes/gripper/offset.toml\n  phalanx capture scenes/gripper/seesaw.toml --to \"3 mm\" \
                  --out capture\n\nExit status: 0 done, whatever the result; 2 bad input; 3 interrupted, or files could not be written."
)]
pub(crate) struct CaptureArgs {
    /// Gripper scene file (TOML)
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Largest positioning error, with its unit
    #[arg(long = "to", value_name = "LENGTH", value_parser = length(), default_value = "3.5 mm")]
    max_error_m: f64,

    /// Number of object positions over the whole range; must be odd, to include the middle
    #[arg(
        long = "places",
        value_name = "COUNT",
        value_parser = number(is_position_count, "an odd number from 3 to 1001, such as 15"),
        default_value = "15"
    )]
    position_count: usize,

    /// Tolerance of the edges of the captured range, with its unit
    #[arg(long = "finely", value_name = "LENGTH", value_parser = length(), default_value = "0.01 mm")]
    tolerance_m: f64,

    /// Simulation model
    #[arg(long, value_parser = model(), default_value = "analytic")]
    model: Model,

    /// Write capture.txt, .json, .csv and .svg to this directory, which is created if needed; an existing file is
    /// replaced only when the new one is complete
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,
}

/// Files in the output directory.
const FILES: [&str; 4] = ["capture.json", "capture.csv", "capture.svg", "capture.txt"];

/// Runs `phalanx capture`.
pub fn run(args: &CaptureArgs) -> Result<Status, Failure> {
    let error_m = args.max_error_m;
    // Other kinds of scene are rejected before any directory is created.
    let scene = args.set.load_any(&args.scene)?;
    require_gripper(scene, &args.scene.display().to_string(), "scenes/gripper/offset.toml")
        .map_err(Failure::bad_input)?;
    let source = SceneSource { layers: scene::load_layers(&args.scene)?, settings: args.set.settings().to_vec() };
    let directory = reserve(&[("the scene", &source_files(&args.scene))], &[], ("--out", args.out.as_deref(), &FILES))?;
    let plan = Plan { model: args.model, error_m, position_count: args.position_count, tolerance_m: args.tolerance_m };
    let study = run_study(
        "positions",
        |progress, keep_running| capture(plan, &source, progress, keep_running),
        |error, signal| match (error, signal) {
            (CaptureError::Stopped { done, total }, Some(signal)) => {
                let message = format!("interrupted by {signal} after {done} of {total} positions");
                interrupted(&message, args.out.is_some())
            }
            (error @ CaptureError::Stopped { .. }, None) => Failure::incomplete(error),
            (CaptureError::Scene(error), _) => error.into(),
        },
    )?;
    let texts = || [study.json(), capture_csv(&study), plot::capture(&study), study.report().to_string()];
    directory.write(FILES, texts)?;
    print_result(&study, args.json)?;
    Ok(Status::Done)
}

fn is_position_count(count: &usize) -> bool {
    (3..=1001).contains(count) && count % 2 == 1
}

fn length() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    positive(Dimension::Length, "a length such as \"3.5 mm\"")
}
