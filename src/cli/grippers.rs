//! Studies of a gripper: `phalanx capture`, which positioning errors it captures, and `phalanx hold`, the largest
//! acceleration at which it still holds its object.

use std::path::PathBuf;

use clap::Args;

use super::output::{OutputArgs, picture_target, print_result, reserve, save_picture};
use super::parsers::{PICTURE, axis, count, model, number, picture, positive, size};
use super::progress::Interrupt;
use super::set::{SetArgs, source_files};
use super::{Failure, Status};
use crate::format::ToReport;
use crate::plot;
use crate::report::offsets::offsets_csv;
use crate::report::studies::{capture_csv, hold_csv};
use crate::scene::{self, Axis, Scene};
use crate::study::capture::{self, CaptureError, SceneSource};
use crate::study::hold::{self, HoldError, Loads, axis_name};
use crate::study::offsets::{self, OffsetError, OffsetPlan};
use crate::study::require_grasp;
use crate::trace::Model;
use crate::units::Dimension;

/// Find which positioning errors of the object a gripper, or the hand of any mechanism, captures.
///
/// Simulates the gripper with its object at several positions, up to the largest error on either side of the middle of
/// the palm. Initial angles and automatically sized motors and springs are those for the largest error, because the
/// gripper does not know the position of the object. An object is captured if it is held at the end of the run;
/// bisection finds the edges of the captured range. For each position the report also shows whether the object is
/// centred, the time after which all contacts stay closed, the final position of the object, and whether the grasp is
/// form-closed.
///
/// The object of a mechanism starts at offsets from its place in the scene, along x, y or by an angle, in the frame of the base
/// of the grasp. Along two of them, the results are a map.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx capture scenes/gripper/offset.toml\n  phalanx capture scenes/gripper/seesaw.toml --to \"3 mm\" \
                  --out capture\n  phalanx capture scenes/real/franka-lift.toml --to \"25 mm\"\n  phalanx capture \
                  scenes/real/t42-grasp.toml --along x,angle --to \"10 mm, 20 deg\" --places 9\n\n--out writes capture.txt, .json, .csv and .svg. Exit status: 0 done, whatever the result; 2 bad input; 3 interrupted, or files could not be written."
)]
pub(crate) struct CaptureArgs {
    /// Scene file (TOML) of a gripper, or of a mechanism with a grasp
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Offsets of the object of a mechanism, separated by commas: one or two of x, y and angle [default: x]
    #[arg(long, value_name = "AXES", value_delimiter = ',', value_parser = axis())]
    along: Vec<Axis>,

    /// Largest positioning error, with its unit; of a mechanism one for each of --along, an angle for angle [default: 3.5
    /// mm, 10 deg]
    #[arg(long = "to", value_name = "SIZES", value_delimiter = ',', value_parser = size(LENGTH))]
    largest: Vec<(f64, Dimension)>,

    /// Number of object positions over the whole range; must be odd, to include the middle; of a map along each of its axes
    #[arg(long = "places", value_name = "COUNT", value_parser = number(|count: &usize| (3..=1001).contains(count) && count % 2 == 1, POSITIONS), default_value = "15")]
    position_count: usize,

    /// Tolerance of the edges of the captured range, with its unit [default: 0.01 mm, 0.01 deg]
    #[arg(long = "finely", value_name = "SIZE", value_parser = size(LENGTH))]
    tolerance: Option<(f64, Dimension)>,

    /// Simulation model
    #[arg(long, value_parser = model(), default_value = "analytic")]
    model: Model,

    #[command(flatten)]
    output: OutputArgs,
}

/// Accepted values in messages.
const LENGTH: &str = "a length such as \"0.5 mm\"";
const POSITIONS: &str = "an odd number from 3 to 1001, such as 15";

impl From<CaptureError> for Failure {
    fn from(error: CaptureError) -> Self {
        match error {
            CaptureError::Scene(error) => error.into(),
            CaptureError::Stopped(_) => Failure::incomplete(error),
        }
    }
}

impl From<OffsetError> for Failure {
    fn from(error: OffsetError) -> Self {
        match error {
            OffsetError::Stopped(_) => Failure::incomplete(error),
            error => Failure::bad_input(error),
        }
    }
}

const CAPTURE_FILES: [&str; 4] = ["capture.json", "capture.csv", "capture.svg", "capture.txt"];

pub(super) fn run_capture(args: &CaptureArgs) -> Result<Status, Failure> {
    // Other kinds of scene are rejected before any directory is created.
    let scene = args.set.load_any(&args.scene)?;
    let scene = require_grasp(scene, &args.scene.display().to_string(), "scenes/gripper/offset.toml")
        .map_err(Failure::bad_input)?;
    if scene.finger_count() == 0 {
        return run_offsets(args, &scene);
    }
    if !args.along.is_empty() {
        let reason = "--along is for mechanisms, but the object of fingers is offset along x; remove --along";
        return Err(Failure::bad_input(reason));
    }
    let error_m = sizes(&[Axis::X], &args.largest, "--to", [3.5e-3, 0.0])?[0];
    let tolerance_m = sizes(&[Axis::X], args.tolerance.as_slice(), "--finely", [1e-5, 0.0])?[0];
    let source = SceneSource { layers: scene::load_layers(&args.scene)?, settings: args.set.set.clone() };
    let directory =
        reserve(&[("the scene", &source_files(&args.scene))], &[], (args.output.out.as_deref(), &CAPTURE_FILES))?;
    let plan = capture::Plan { model: args.model, error_m, position_count: args.position_count, tolerance_m };
    let task = ["the study", "positions", args.output.unwritten()];
    let study = Interrupt::listen()?.compute(task, |monitor| capture::capture(plan, &source, monitor))?;
    let contents = || [study.json(), capture_csv(&study), plot::capture(&study), study.report().to_string()];
    directory.write(CAPTURE_FILES, contents)?;
    print_result(&study, args.output.json)
}

/// Offsets of the object of a mechanism.
fn run_offsets(args: &CaptureArgs, scene: &Scene) -> Result<Status, Failure> {
    let axes = if args.along.is_empty() { vec![Axis::X] } else { args.along.clone() };
    let largest = sizes(&axes, &args.largest, "--to", [3.5e-3, 10f64.to_radians()])?;
    let tolerance = sizes(&axes[..1], args.tolerance.as_slice(), "--finely", [1e-5, 0.01f64.to_radians()])?[0];
    let axes = axes.into_iter().zip(largest).collect();
    let plan = OffsetPlan { model: args.model, axes, count: args.position_count, tolerance };
    plan.check().map_err(Failure::bad_input)?;
    let directory =
        reserve(&[("the scene", &source_files(&args.scene))], &[], (args.output.out.as_deref(), &CAPTURE_FILES))?;
    let task = ["the study", "positions", args.output.unwritten()];
    let study = Interrupt::listen()?.compute(task, |monitor| offsets::offsets(plan, scene, monitor))?;
    let contents = || [study.json(), offsets_csv(&study), plot::offsets(&study), study.report().to_string()];
    directory.write(CAPTURE_FILES, contents)?;
    print_result(&study, args.output.json)
}

/// Sizes given for axes, or the defaults of a length and an angle.
fn sizes(
    axes: &[Axis],
    given: &[(f64, Dimension)],
    flag: &str,
    [length_m, angle_rad]: [f64; 2],
) -> Result<Vec<f64>, Failure> {
    if given.is_empty() {
        return Ok(axes.iter().map(|axis| if *axis == Axis::Angle { angle_rad } else { length_m }).collect());
    }
    let dimension = |axis: &Axis| if *axis == Axis::Angle { Dimension::Angle } else { Dimension::Length };
    if axes.len() == given.len() && axes.iter().zip(given).all(|(axis, (_, of))| dimension(axis) == *of) {
        return Ok(given.iter().map(|(value, _)| *value).collect());
    }
    let names: Vec<&str> = axes.iter().map(|axis| axis_name(*axis)).collect();
    Err(Failure::bad_input(format!(
        "{flag} does not fit offsets along {}: expected a length for x and y, and an angle for angle, such as {flag} \"5 mm, 10 \
         deg\" for x,angle",
        names.join(",")
    )))
}

/// Find the largest acceleration at which a gripper, or the hand of any mechanism, holds its object.
///
/// Simulates the scene until its object is at rest, then moves the palm, or the base of a mechanism: by pulses from rest to rest in equally spaced
/// directions (the default), by vibrations, or by a move of varying duration. A load is measured by its peak
/// acceleration. A scan over the whole range and bisection of its first failure find two limits: the largest load at
/// which the object is held at the end and slips less than the bound, and the largest load at which it is held. The
/// report also states whether the object is held at a larger load although a smaller one fails. Motors and brakes keep
/// the state that they have when the loads begin. Runs that cannot be completed count neither as held nor as failed.
///
/// The base of a mechanism is that of its grasp: the ground with all that is fixed to it, or a body, whose joints with the ground
/// end when the loads begin. Surroundings that a load would hit are removed then.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx hold scenes/gripper/hold.toml\n  phalanx hold scenes/gripper/hold.toml --directions 24 --plot \
                  hold.svg\n  phalanx hold scenes/gripper/lift.toml --set contact.friction.law=bristle --set motor.brake_law=bristle \
                  --vibration \"50 Hz, 200 Hz\" --along x,y,angle\n  phalanx hold scenes/gripper/cycle.toml --move --slip \"0.1 mm\" --out \
                  hold\n  phalanx hold scenes/real/2f85-lift.toml --at \"250 ms\"\n\n--out writes hold.txt, .json, .csv (every run) and .svg. Exit status: 0 done, whatever the result; 2 bad input; 3 interrupted, or files could not be written."
)]
pub(crate) struct HoldArgs {
    /// Scene file (TOML) of a gripper, or of a mechanism with a grasp
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Duration of a pulse, with its unit
    #[arg(long, value_name = "TIME", value_parser = positive(Dimension::Time, TIME), default_value = "40 ms")]
    pulse: f64,

    /// Number of pulse directions, equally spaced from +x (along the palm)
    #[arg(long, value_name = "COUNT", value_parser = count(1..=360, "8"), default_value = "8")]
    directions: usize,

    /// Apply vibrations at these frequencies instead of pulses; comma-separated, with units
    #[arg(
        long,
        value_name = "FREQUENCIES",
        value_parser = positive(Dimension::Frequency, FREQUENCIES),
        value_delimiter = ',',
        num_args = 0..=1,
        default_missing_value = "20 Hz, 50 Hz, 100 Hz, 200 Hz",
        conflicts_with_all = ["pulse", "directions"]
    )]
    vibration: Option<Vec<f64>>,

    /// Axes of the vibrations: x along the palm, y perpendicular to it; angle is the rotation about the middle of the
    /// palm
    #[arg(
        long,
        value_parser = axis(),
        value_name = "AXES",
        value_delimiter = ',',
        default_value = "x,y",
        requires = "vibration"
    )]
    along: Vec<Axis>,

    /// Scale the duration of the scene's own moves instead of applying pulses; a scene without moves gets 25 mm up,
    /// 305 mm across and 25 mm down
    #[arg(long = "move", conflicts_with_all = ["pulse", "directions", "vibration"])]
    moves: bool,

    /// Largest slip of the object relative to the gripper, with its unit
    #[arg(long, value_name = "LENGTH", value_parser = positive(Dimension::Length, LENGTH), default_value = "0.5 mm")]
    slip: f64,

    /// Time at which loads begin, with its unit [default: when the object is at rest and the brakes are engaged, or
    /// when the first of the scene's moves has ended; with --move: when the moves begin]
    #[arg(long, value_name = "TIME", value_parser = positive(Dimension::Time, TIME))]
    at: Option<f64>,

    /// Smallest peak acceleration to try, with its unit
    #[arg(long, value_name = "ACCELERATION", value_parser = positive(Dimension::Acceleration, ACCELERATION), default_value = "1 m/s^2")]
    from: f64,

    /// Largest peak acceleration to try, with its unit
    #[arg(long, value_name = "ACCELERATION", value_parser = positive(Dimension::Acceleration, ACCELERATION), default_value = "1000 m/s^2")]
    to: f64,

    /// Number of accelerations to try in this range before bisection; failures closer together than these can be missed
    #[arg(long, value_name = "COUNT", value_parser = count(2..=1000, "11"), default_value = "11")]
    scan: usize,

    /// Relative tolerance of the limits
    #[arg(long, value_name = "FRACTION", value_parser = number(|x| (1e-9..1.0).contains(x), FRACTION), default_value = "0.02")]
    tol: f64,

    /// Simulation model
    #[arg(long, value_parser = model(), default_value = "analytic")]
    model: Model,

    /// Write a plot to this file: limits in polar coordinates for pulses, limits over frequency for three or more
    /// vibrations, else the slip of every run; an existing file is replaced only when the new one is complete
    #[arg(long, value_name = "FILE.svg|png|html", value_parser = picture(PICTURE))]
    plot: Option<PathBuf>,

    #[command(flatten)]
    output: OutputArgs,
}

/// Accepted values in messages.
const TIME: &str = "a time such as \"40 ms\"";
const ACCELERATION: &str = "an acceleration such as \"100 m/s^2\"";
const FREQUENCIES: &str = "frequencies such as \"50 Hz, 200 Hz\"";
const FRACTION: &str = "a number from 1e-9 to below 1, such as 0.02";

impl From<HoldError> for Failure {
    fn from(error: HoldError) -> Self {
        match error {
            HoldError::Stopped(_) | HoldError::Scene { .. } => Failure::incomplete(error),
            error => Failure::bad_input(error),
        }
    }
}

pub(super) fn run_hold(args: &HoldArgs) -> Result<Status, Failure> {
    let scene = args.set.load_any(&args.scene)?;
    let scene = require_grasp(scene, &args.scene.display().to_string(), "scenes/gripper/hold.toml")
        .map_err(Failure::bad_input)?;
    let plan = build_plan(args)?;
    let svg = picture_target(args.plot.as_deref());
    let files = ["hold.json", "hold.csv", "hold.svg", "hold.txt"];
    let directory =
        reserve(&[("the scene", &source_files(&args.scene))], &[svg], (args.output.out.as_deref(), &files))?;
    let task = ["the study", "runs", args.output.unwritten()];
    let study = Interrupt::listen()?.compute(task, |monitor| hold::hold(&scene, plan, monitor))?;
    directory.write(files, || [study.json(), hold_csv(&study), plot::hold(&study), study.report().to_string()])?;
    if let Some(path) = &args.plot {
        save_picture(path, &scene.name, &plot::hold(&study))?;
    }
    print_result(&study, args.output.json)
}

fn build_plan(args: &HoldArgs) -> Result<hold::Plan, Failure> {
    let loads = match (&args.vibration, args.moves) {
        (Some(frequencies_hz), _) => {
            let mut frequencies_hz = frequencies_hz.clone();
            frequencies_hz.sort_by(f64::total_cmp);
            Loads::Vibrations { axes: args.along.clone(), frequencies_hz }
        }
        (None, true) => Loads::Move,
        (None, false) => Loads::Pulses { directions: args.directions, length_s: args.pulse },
    };
    let plan = hold::Plan {
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
