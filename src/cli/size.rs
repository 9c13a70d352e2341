//! `phalanx size`: spring and motor for a finger.

use std::path::PathBuf;

use clap::Args;

use super::output::answer;
use super::overrides::positive;
use super::set::{SetArgs, files};
use super::targets::reserve;
use super::words::RuleArg;
use super::{Failure, Status};
use crate::plot;
use crate::report::sizing::{SizingReport, sizing_csv};
use crate::study::size::{Asked, size};
use crate::units::Dimension;
use crate::wording::Reported;

/// Size spring and motor of a finger: what a test trajectory asks of them.
///
/// The motor link goes from the start of the scene to the closed finger in 10 ms. The spring must hold the finger straight until
/// the proximal phalanx meets the object; the motor has the RMS torque. Whatever torques the scene itself has are shown beside.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx size scenes/experiment-95.toml\n  phalanx size scenes/experiment-95.toml --closing-time \"8 \
                  ms\" --json\n  phalanx size my-gripper.toml --out sizing\n\nA scene that says sizing = \"rigid\" (or \"whole\") at \
                  its top takes these torques by itself. Exit status: 0 done; 2 bad input, or a finger that cannot be sized."
)]
pub struct SizeArgs {
    /// Scene file of a finger (TOML)
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Over what the motor torque is averaged
    #[arg(long, value_enum, default_value_t = RuleArg::Rigid)]
    rule: RuleArg,

    /// Length of the test trajectory with its unit [default: 10 ms]
    #[arg(long, value_name = "TIME", value_parser = closing_time)]
    closing_time: Option<f64>,

    /// How far the torsional spring that the constant one is compared with is turned where the finger is straight [default: the
    /// preload of the scene's own torsional spring, or 90 deg]
    #[arg(long, value_name = "ANGLE", value_parser = preload)]
    preload: Option<f64>,

    /// Write size.txt, .json, .csv (the profile), and trajectory.svg, springs.svg and spring-types.svg there; the directory is
    /// made if need be
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,
}

/// Everything that is in the directory in the end.
const FILES: [&str; 6] = ["size.txt", "size.json", "size.csv", "trajectory.svg", "springs.svg", "spring-types.svg"];

/// Runs the command.
pub fn run(args: &SizeArgs) -> Result<Status, Failure> {
    let scene = args.set.load(&args.scene)?;
    let folder = reserve(&[("the scene", &files(&args.scene))], &[], ("--out", args.out.as_deref(), &FILES))?;
    let usual = Asked::default();
    let asked = Asked {
        rule: args.rule.into(),
        closing_s: args.closing_time.unwrap_or(usual.closing_s),
        preload_rad: args.preload,
    };
    let found = size(&scene, asked).map_err(Failure::bad_input)?;
    let report = SizingReport::from(&found);
    let profile = &found.profile;
    if let Some(folder) = folder {
        let texts = [
            report.report().to_string(),
            report.json(),
            sizing_csv(profile),
            plot::sizing_trajectory(&scene.name, profile),
            plot::sizing_springs(&scene.name, profile),
            plot::sizing_spring_types(&scene.name, profile),
        ];
        folder.write(&FILES, &texts)?;
    }
    answer(&report, args.json)?;
    Ok(Status::Done)
}

fn closing_time(text: &str) -> Result<f64, String> {
    positive(text, Dimension::Time, "the closing takes some time; expected one such as \"10 ms\"")
}

fn preload(text: &str) -> Result<f64, String> {
    positive(text, Dimension::Angle, "a preload must be more than 0; expected an angle such as \"90 deg\"")
}
