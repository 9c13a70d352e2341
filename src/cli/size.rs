//! `phalanx size`: sizes the spring and motor of a finger.

use std::path::PathBuf;

use clap::Args;

use super::output::print_result;
use super::parsers::rule;
use super::set::{SetArgs, source_files};
use super::targets::reserve;
use super::{Failure, Status};
use crate::format::ToReport;
use crate::plot;
use crate::report::studies::sizing_csv;
use crate::sizing::Rule;
use crate::study::size::{SizingOptions, size_finger};
use crate::units::{Dimension, parse_positive};

/// Size the spring and motor of a finger from a test trajectory.
///
/// The motor link moves from the initial posture to the closed finger in 10 ms. The spring must keep the finger
/// straight until the proximal phalanx contacts the object; the motor provides the RMS torque. The torques in the scene
/// are shown for comparison.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx size scenes/experiment-95.toml\n  phalanx size scenes/experiment-95.toml --closing-time \"8 \
                  ms\" --json\n  phalanx size my-gripper.toml --out sizing\n\nA scene with sizing = \"rigid\" (or \"whole\") at \
                  its top uses these torques automatically. Exit status: 0 done; 2 bad input, or a finger that cannot be sized."
)]
pub(crate) struct SizeArgs {
    /// Finger scene file (TOML)
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Time span over which the motor torque is averaged
    #[arg(long, value_parser = rule(), default_value = "rigid")]
    rule: Rule,

    /// Duration of the test trajectory with its unit [default: 10 ms]
    #[arg(long, value_name = "TIME", value_parser = parse_closing_time)]
    closing_time: Option<f64>,

    /// Deflection of the torsional spring, which is compared with the constant one, when the finger is straight
    /// [default: the preload of the scene's torsional spring, or 90 deg]
    #[arg(long, value_name = "ANGLE", value_parser = parse_preload)]
    preload: Option<f64>,

    /// Write size.txt, .json, .csv (the profile), trajectory.svg, springs.svg and spring-types.svg to this directory,
    /// which is created if needed
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,
}

/// Files in the output directory.
const FILES: [&str; 6] = ["size.txt", "size.json", "size.csv", "trajectory.svg", "springs.svg", "spring-types.svg"];

/// Runs `phalanx size`.
pub fn run(args: &SizeArgs) -> Result<Status, Failure> {
    let scene = args.set.load(&args.scene)?;
    let directory = reserve(&[("the scene", &source_files(&args.scene))], &[], ("--out", args.out.as_deref(), &FILES))?;
    let defaults = SizingOptions::default();
    let options = SizingOptions {
        rule: args.rule,
        closing_s: args.closing_time.unwrap_or(defaults.closing_s),
        preload_rad: args.preload,
    };
    let sizing = size_finger(&scene, options).map_err(Failure::bad_input)?;
    let profile = &sizing.profile;
    directory.write(FILES, || {
        let [trajectory, springs, spring_types] = plot::sizing(&scene.name, profile);
        [sizing.report().to_string(), sizing.json(), sizing_csv(profile), trajectory, springs, spring_types]
    })?;
    print_result(&sizing, args.json)?;
    Ok(Status::Done)
}

fn parse_closing_time(text: &str) -> Result<f64, String> {
    parse_positive(text, Dimension::Time, "the closing time must be more than 0; expected a time such as \"10 ms\"")
}

fn parse_preload(text: &str) -> Result<f64, String> {
    parse_positive(text, Dimension::Angle, "the preload must be more than 0; expected an angle such as \"90 deg\"")
}
