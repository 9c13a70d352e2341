//! `phalanx capture`: which positioning errors a gripper captures.

use std::path::PathBuf;

use clap::Args;

use super::interrupt::Interrupt;
use super::output::answer;
use super::overrides::positive;
use super::progress::Count;
use super::set::{SetArgs, files};
use super::targets::reserve;
use super::words::ModelArg;
use super::{Failure, Status};
use crate::plot;
use crate::report::capture::{CaptureReport, capture_csv};
use crate::scene;
use crate::study::capture::{CaptureError, Plan, Source, capture};
use crate::study::only_gripper;
use crate::units::Dimension;
use crate::wording::Reported;

/// Which positioning errors a gripper captures: where the object ends that lies off the middle of the palm.
///
/// Simulates the gripper with its object at places from one end of the largest error to the other. Starts, and motors and springs that the
/// scene sizes, are those for the largest error: the gripper does not know where the object lies. An object is captured where its fate
/// is held; where it is no longer, the edge is found by bisection. Beside it: whether it comes to the middle,
/// how long until all contacts hold for good, and whether the grasp is form-closed, where the object lies and where it ends.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx capture scenes/gripper/offset.toml\n  phalanx capture scenes/gripper/seesaw.toml --to \"3 mm\" \
                  --out capture\n\nExit status: 0 done, whatever is captured; 2 bad input; 3 interrupted, or files could not be written."
)]
pub struct CaptureArgs {
    /// Scene of a gripper (TOML)
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Largest positioning error, with its unit
    #[arg(long, value_name = "LENGTH", value_parser = length, default_value = "3.5 mm")]
    to: f64,

    /// Places of the object over the whole range; an odd number, so that the middle is among them
    #[arg(long, value_name = "COUNT", value_parser = places, default_value = "15")]
    places: usize,

    /// How finely the edges of what is captured are found, with its unit
    #[arg(long, value_name = "LENGTH", value_parser = length, default_value = "0.01 mm")]
    finely: f64,

    /// Model that simulates
    #[arg(long, value_enum, default_value_t = ModelArg::Analytic)]
    model: ModelArg,

    /// Write capture.txt, .json, .csv and .svg there; the directory is made if need be, and an older file is replaced only when the new
    /// one is whole
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,
}

/// Everything that is in the directory in the end.
const FILES: [&str; 4] = ["capture.json", "capture.csv", "capture.svg", "capture.txt"];

/// Runs the command.
pub fn run(args: &CaptureArgs) -> Result<Status, Failure> {
    let error_m = args.to;
    // Whether it is a gripper at all is said before anything is made.
    let scene = args.set.load_any(&args.scene)?;
    only_gripper(scene, &args.scene.display().to_string(), "scenes/gripper/offset.toml").map_err(Failure::bad_input)?;
    let source = Source { layers: scene::layers(&args.scene)?, settings: args.set.settings().to_vec() };
    let folder = reserve(&[("the scene", &files(&args.scene))], &[], ("--out", args.out.as_deref(), &FILES))?;
    let interrupt = Interrupt::listen()?;
    let plan = Plan { model: args.model.into(), error_m, places: args.places, tolerance_m: args.finely };
    let load = |offset_m: f64| source.placed(error_m, offset_m);
    let mut count = Count::new();
    let mut tell = |done: u64, total: u64| count.show(done as usize, total as usize, "places");
    let result = capture(plan, &load, &mut tell, &|| interrupt.signal().is_none());
    count.clear();
    let found = result.map_err(|error| match (error, interrupt.signal()) {
        (CaptureError::Stopped { done, total }, Some(signal)) => {
            let files = if args.out.is_some() { "; no file was written, and older ones are as they were" } else { "" };
            Failure::incomplete(format!("interrupted by {signal} after {done} of {total} places{files}"))
        }
        (error @ CaptureError::Stopped { .. }, None) => Failure::incomplete(error),
        (CaptureError::Scene(error), _) => error.into(),
    })?;
    let report = CaptureReport::from(&found);
    if let Some(folder) = folder {
        let texts = [report.json(), capture_csv(&report), plot::capture(&found), report.report().to_string()];
        folder.write(&FILES, &texts)?;
    }
    answer(&report, args.json)?;
    Ok(Status::Done)
}

fn length(text: &str) -> Result<f64, String> {
    positive(text, Dimension::Length, "must be more than 0; expected a length such as \"3.5 mm\"")
}

fn places(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 3..=1001) if count % 2 == 1 => Ok(count),
        _ => Err("expected an odd number from 3 to 1001, such as 15".to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_and_counts_are_checked() {
        assert_eq!((length("3.5 mm"), places("15")), (Ok(3.5e-3), Ok(15)));
        for (result, message) in [
            (length("0 mm").err(), "more than 0"),
            (length("3").err(), "no unit"),
            (places("4").err(), "odd"),
            (places("1").err(), "from 3"),
            (places("x").err(), "odd"),
        ] {
            let error = result.expect(message);
            assert!(error.contains(message), "{error}");
        }
    }
}
