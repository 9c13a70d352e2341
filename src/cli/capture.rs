//! `phalanx capture`: which positioning errors a gripper captures.

use std::path::PathBuf;

use clap::Args;

use super::choice_args::ModelArg;
use super::interrupt::{self, Interrupt};
use super::output::print_result;
use super::overrides::parse_positive;
use super::progress::RunCounter;
use super::set::{SetArgs, source_files};
use super::targets::reserve;
use super::{Failure, Status};
use crate::format::ToReport;
use crate::plot;
use crate::report::capture::capture_csv;
use crate::scene;
use crate::study::capture::{CaptureError, Plan, SceneSource, capture};
use crate::study::require_gripper;
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
pub struct CaptureArgs {
    /// Gripper scene file (TOML)
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Largest positioning error, with its unit
    #[arg(long = "to", value_name = "LENGTH", value_parser = parse_length, default_value = "3.5 mm")]
    max_error_m: f64,

    /// Number of object positions over the whole range; must be odd, to include the middle
    #[arg(long = "places", value_name = "COUNT", value_parser = parse_position_count, default_value = "15")]
    position_count: usize,

    /// Tolerance of the edges of the captured range, with its unit
    #[arg(long = "finely", value_name = "LENGTH", value_parser = parse_length, default_value = "0.01 mm")]
    tolerance_m: f64,

    /// Simulation model
    #[arg(long, value_enum, default_value_t = ModelArg::Analytic)]
    model: ModelArg,

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
    let interrupt = Interrupt::listen()?;
    let plan =
        Plan { model: args.model.into(), error_m, position_count: args.position_count, tolerance_m: args.tolerance_m };
    let load = |offset_m: f64| source.load_at_offset(error_m, offset_m);
    let mut counter = RunCounter::new();
    let mut report_progress = |done: u64, total: u64| counter.update(done as usize, total as usize, "positions");
    let result = capture(plan, &load, &mut report_progress, &|| interrupt.signal().is_none());
    counter.clear();
    let study = result.map_err(|error| match (error, interrupt.signal()) {
        (CaptureError::Stopped { done, total }, Some(signal)) => {
            let files = if args.out.is_some() { interrupt::NO_FILE_WRITTEN } else { "" };
            Failure::incomplete(format!("interrupted by {signal} after {done} of {total} positions{files}"))
        }
        (error @ CaptureError::Stopped { .. }, None) => Failure::incomplete(error),
        (CaptureError::Scene(error), _) => error.into(),
    })?;
    if let Some(directory) = directory {
        let texts = [study.json(), capture_csv(&study), plot::capture(&study), study.report().to_string()];
        directory.write(&FILES, &texts)?;
    }
    print_result(&study, args.json)?;
    Ok(Status::Done)
}

fn parse_length(text: &str) -> Result<f64, String> {
    parse_positive(text, Dimension::Length, "must be more than 0; expected a length such as \"3.5 mm\"")
}

fn parse_position_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 3..=1001) if count % 2 == 1 => Ok(count),
        _ => Err("expected an odd number from 3 to 1001, such as 15".to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rejects_invalid_lengths_and_counts() {
        assert_eq!((parse_length("3.5 mm"), parse_position_count("15")), (Ok(3.5e-3), Ok(15)));
        for (result, message) in [
            (parse_length("0 mm").err(), "more than 0"),
            (parse_length("3").err(), "no unit"),
            (parse_position_count("4").err(), "odd"),
            (parse_position_count("1").err(), "from 3"),
            (parse_position_count("x").err(), "odd"),
        ] {
            let error = result.expect(message);
            assert!(error.contains(message), "{error}");
        }
    }
}
