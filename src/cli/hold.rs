//! `phalanx hold`: the largest acceleration at which a gripper still holds its object.

use std::path::PathBuf;

use clap::Args;

use super::interrupt::{interrupted, run_study};
use super::output::print_result;
use super::parsers::{choice, count, model, number, positive};
use super::set::{SetArgs, source_files};
use super::targets::{FileKind, TargetKind, reserve, save};
use super::{Failure, Status};
use crate::format::ToReport;
use crate::plot;
use crate::report::studies::hold_csv;
use crate::scene::Axis;
use crate::study::hold::{HoldError, Loads, Plan, axis_name, hold};
use crate::study::require_gripper;
use crate::trace::Model;
use crate::units::Dimension;

/// Find the largest acceleration at which a gripper holds its object.
///
/// Simulates the scene until its object is at rest, then moves the palm: by pulses from rest to rest in equally spaced
/// directions (the default), by vibrations, or by a move of varying duration. A load is measured by its peak
/// acceleration. A scan over the whole range and bisection of its first failure find two limits: the largest load at
/// which the object is held at the end and slips less than the bound, and the largest load at which it is held. The
/// report also states whether the object is held at a larger load although a smaller one fails. Motors and brakes keep
/// the state that they have when the loads begin. Runs that cannot be completed count neither as held nor as failed.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx hold scenes/gripper/hold.toml\n  phalanx hold scenes/gripper/hold.toml --directions 24 --svg \
                  hold.svg\n  phalanx hold scenes/gripper/lift.toml --set contact.friction.law=bristle --set motor.brake_law=bristle \
                  --vibration \"50 Hz, 200 Hz\" --along x,y,angle\n  phalanx hold scenes/gripper/cycle.toml --move --slip \"0.1 mm\" --out \
                  hold\n\nExit status: 0 done, whatever the result; 2 bad input; 3 interrupted, or files could not be written."
)]
pub(crate) struct HoldArgs {
    /// Gripper scene file (TOML)
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Duration of a pulse, with its unit
    #[arg(
        long,
        value_name = "TIME",
        value_parser = positive(Dimension::Time, "a time such as \"40 ms\""),
        default_value = "40 ms",
        conflicts_with_all = ["vibration", "moves"]
    )]
    pulse: f64,

    /// Number of pulse directions, equally spaced from +x (along the palm)
    #[arg(
        long,
        value_name = "COUNT",
        value_parser = count(1..=360, "8"),
        default_value = "8",
        conflicts_with_all = ["vibration", "moves"]
    )]
    directions: usize,

    /// Apply vibrations at these frequencies instead of pulses; comma-separated, with units
    #[arg(
        long,
        value_name = "FREQUENCIES",
        value_parser = parse_frequencies,
        num_args = 0..=1,
        default_missing_value = "20 Hz, 50 Hz, 100 Hz, 200 Hz",
        conflicts_with_all = ["moves"]
    )]
    vibration: Option<Frequencies>,

    /// Axes of the vibrations: x along the palm, y perpendicular to it; angle is the rotation about the middle of the
    /// palm
    #[arg(
        long,
        value_parser = choice([Axis::X, Axis::Y, Axis::Angle].map(|axis| (axis_name(axis), "", axis))),
        value_name = "AXES",
        value_delimiter = ',',
        default_value = "x,y",
        requires = "vibration"
    )]
    along: Vec<Axis>,

    /// Scale the duration of the scene's own moves instead of applying pulses; a scene without moves gets 25 mm up,
    /// 305 mm across and 25 mm down
    #[arg(long = "move")]
    moves: bool,

    /// Largest slip of the object relative to the gripper, with its unit
    #[arg(
        long,
        value_name = "LENGTH",
        value_parser = positive(Dimension::Length, "a length such as \"0.5 mm\""),
        default_value = "0.5 mm"
    )]
    slip: f64,

    /// Time at which loads begin, with its unit [default: when the object is at rest and the brakes are engaged, or
    /// when the first of the scene's moves has ended; with --move: when the moves begin]
    #[arg(long, value_name = "TIME", value_parser = positive(Dimension::Time, "a time such as \"60 ms\""))]
    at: Option<f64>,

    /// Smallest peak acceleration to try, with its unit
    #[arg(long, value_name = "ACCELERATION", value_parser = acceleration(), default_value = "1 m/s^2")]
    from: f64,

    /// Largest peak acceleration to try, with its unit
    #[arg(long, value_name = "ACCELERATION", value_parser = acceleration(), default_value = "1000 m/s^2")]
    to: f64,

    /// Number of accelerations to try in this range before bisection; failures closer together than these can be missed
    #[arg(long, value_name = "COUNT", value_parser = count(2..=1000, "11"), default_value = "11")]
    scan: usize,

    /// Relative tolerance of the limits
    #[arg(long, value_name = "FRACTION", value_parser = fraction(), default_value = "0.02")]
    tol: f64,

    /// Simulation model
    #[arg(long, value_parser = model(), default_value = "analytic")]
    model: Model,

    /// Write a plot to this file: limits in polar coordinates for pulses, limits over frequency for three or more
    /// vibrations, else the slip of every run; an existing file is replaced only when the new one is complete
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,

    /// Write hold.txt, .json, .csv (every run) and .svg to this directory, which is created if needed; an existing file
    /// is replaced only when the new one is complete
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,
}

/// Files in the output directory.
const FILES: [&str; 4] = ["hold.json", "hold.csv", "hold.svg", "hold.txt"];

/// Frequencies in Hz, in ascending order.
#[derive(Clone, Debug, PartialEq)]
struct Frequencies(Vec<f64>);

/// Runs `phalanx hold`.
pub fn run(args: &HoldArgs) -> Result<Status, Failure> {
    let scene = args.set.load_any(&args.scene)?;
    let scene = require_gripper(scene, &args.scene.display().to_string(), "scenes/gripper/hold.toml")
        .map_err(Failure::bad_input)?;
    let plan = build_plan(args)?;
    let svg = ("--svg", args.svg.as_deref(), TargetKind::File(FileKind::Picture));
    let directory =
        reserve(&[("the scene", &source_files(&args.scene))], &[svg], ("--out", args.out.as_deref(), &FILES))?;
    let study = run_study(
        "runs",
        |progress, keep_running| hold(&scene, plan, progress, keep_running),
        |error, signal| match (error, signal) {
            (HoldError::Stopped { done }, Some(signal)) => {
                interrupted(&format!("interrupted by {signal} after {done} runs"), args.out.is_some())
            }
            (error @ (HoldError::Stopped { .. } | HoldError::Scene { .. }), _) => Failure::incomplete(error),
            (error, _) => Failure::bad_input(error),
        },
    )?;
    directory.write(FILES, || [study.json(), hold_csv(&study), plot::hold(&study), study.report().to_string()])?;
    if let Some(path) = &args.svg {
        save(path, &plot::hold(&study))?;
    }
    print_result(&study, args.json)?;
    Ok(Status::Done)
}

fn build_plan(args: &HoldArgs) -> Result<Plan, Failure> {
    let loads = match (&args.vibration, args.moves) {
        (Some(Frequencies(frequencies_hz)), _) => {
            Loads::Vibrations { axes: args.along.clone(), frequencies_hz: frequencies_hz.clone() }
        }
        (None, true) => Loads::Move,
        (None, false) => Loads::Pulses { directions: args.directions, length_s: args.pulse },
    };
    let plan = Plan {
        model: args.model,
        loads,
        start_s: args.at,
        slip_m: args.slip,
        from_m_s2: args.from,
        to_m_s2: args.to,
        scan: args.scan,
        tolerance: args.tol,
        threads: 0,
    };
    plan.check().map_err(Failure::bad_input)?;
    Ok(plan)
}

fn acceleration() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    positive(Dimension::Acceleration, "an acceleration such as \"100 m/s^2\"")
}

fn fraction() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    number(|fraction| (1e-9..1.0).contains(fraction), "a number from 1e-9 to below 1, such as 0.02")
}

fn parse_frequencies(text: &str) -> Result<Frequencies, String> {
    let example = "frequencies such as \"50 Hz, 200 Hz\"";
    let parse_item = |item: &str| positive(Dimension::Frequency, example)(item.trim());
    let mut values = text.split(',').map(parse_item).collect::<Result<Vec<f64>, _>>()?;
    values.sort_by(f64::total_cmp);
    Ok(Frequencies(values))
}
