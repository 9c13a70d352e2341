//! `phalanx hold`: how much acceleration a gripper holds its object against.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::interrupt::Interrupt;
use super::output::answer;
use super::overrides::positive;
use super::own::Form;
use super::progress::Count;
use super::saved::save;
use super::set::{SetArgs, files};
use super::targets::{Kind, reserve};
use super::words::ModelArg;
use super::{Failure, Status};
use crate::plot;
use crate::report::hold::{HoldReport, hold_csv};
use crate::scene::{Axis, Scene};
use crate::study::hold::{HoldError, Loads, Plan, hold};
use crate::study::only_gripper;
use crate::units::Dimension;
use crate::wording::Reported;

/// How much acceleration a gripper holds its object against: in pulses, vibrations, or a pick-and-place move.
///
/// Simulates the scene up to where its object is at rest, and moves the palm from there on: by pulses from rest to rest in directions all
/// around (the default), by vibrations, or by a move in another time. How strong a load is, is its peak acceleration. A scan over the
/// whole range, and bisection of the first failure in it, find the largest one at which the object slips less than the bound and is held
/// at the end, and the largest one at which it is held. Where a larger load holds although a smaller one fails, that is said. Motors and
/// brakes stay as they are when loads begin. Runs that cannot be finished count as neither.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx hold scenes/gripper/hold.toml\n  phalanx hold scenes/gripper/hold.toml --directions 24 --svg \
                  hold.svg\n  phalanx hold scenes/gripper/lift.toml --set contact.friction.law=bristle --set motor.brake_law=bristle \
                  --vibration \"50 Hz, 200 Hz\" --along x,y,angle\n  phalanx hold scenes/gripper/cycle.toml --move --slip \"0.1 mm\" --out \
                  hold\n\nExit status: 0 done, whatever is held; 2 bad input; 3 interrupted, or files could not be written."
)]
pub struct HoldArgs {
    /// Scene of a gripper (TOML)
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// How long a pulse takes, with its unit
    #[arg(long, value_name = "TIME", value_parser = time, default_value = "40 ms", conflicts_with_all = ["vibration", "moves"])]
    pulse: f64,

    /// Directions of pulses, all around from +x (along the palm)
    #[arg(long, value_name = "COUNT", value_parser = directions, default_value = "8", conflicts_with_all = ["vibration", "moves"])]
    directions: usize,

    /// Vibrations at these frequencies instead, with their units, and commas between
    #[arg(
        long,
        value_name = "FREQUENCIES",
        value_parser = frequencies,
        num_args = 0..=1,
        default_missing_value = "20 Hz, 50 Hz, 100 Hz, 200 Hz",
        conflicts_with_all = ["moves"]
    )]
    vibration: Option<Frequencies>,

    /// Along what vibrations go; an angle about the middle of the palm
    #[arg(long, value_enum, value_name = "AXES", value_delimiter = ',', default_value = "x,y", requires = "vibration")]
    along: Vec<AxisArg>,

    /// The scene's own moves in another time instead; of a scene without any, 25/305/25 mm up, across and down
    #[arg(long = "move")]
    moves: bool,

    /// How far the object may slip in the hand, with its unit
    #[arg(long, value_name = "LENGTH", value_parser = length, default_value = "0.5 mm")]
    slip: f64,

    /// When loads begin, with its unit [default: when the object is at rest and brakes have gripped, or when the first of the scene's
    /// moves is over; with --move when they begin]
    #[arg(long, value_name = "TIME", value_parser = instant)]
    at: Option<f64>,

    /// Smallest peak acceleration that is tried, with its unit
    #[arg(long, value_name = "ACCELERATION", value_parser = acceleration, default_value = "1 m/s^2")]
    from: f64,

    /// Largest one
    #[arg(long, value_name = "ACCELERATION", value_parser = acceleration, default_value = "1000 m/s^2")]
    to: f64,

    /// How many are tried from the one to the other, before limits are narrowed: failures that lie closer together can be missed
    #[arg(long, value_name = "COUNT", value_parser = scan, default_value = "11")]
    scan: usize,

    /// How finely limits are found, as part of themselves
    #[arg(long, value_name = "PART", value_parser = part, default_value = "0.02")]
    tol: f64,

    /// Model that simulates
    #[arg(long, value_enum, default_value_t = ModelArg::Analytic)]
    model: ModelArg,

    /// Draw the limits into a picture: polar for pulses, over frequency for three vibrations or more, else the slip of every run; an
    /// older file is replaced only when the new one is whole
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,

    /// Write hold.txt, .json, .csv (every run) and .svg there; the directory is made if need be, and an older file is replaced only when
    /// the new one is whole
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,
}

/// Everything that is in the directory in the end.
const FILES: [&str; 4] = ["hold.json", "hold.csv", "hold.svg", "hold.txt"];

/// Values of one flag, each once.
#[derive(Clone, Debug, PartialEq)]
struct Frequencies(Vec<f64>);

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum AxisArg {
    /// Along the palm
    X,
    /// Out of the palm
    Y,
    /// About its middle
    Angle,
}

impl From<AxisArg> for Axis {
    fn from(word: AxisArg) -> Self {
        match word {
            AxisArg::X => Axis::X,
            AxisArg::Y => Axis::Y,
            AxisArg::Angle => Axis::Angle,
        }
    }
}

/// Runs the command.
pub fn run(args: &HoldArgs) -> Result<Status, Failure> {
    let scene = gripper(args)?;
    let plan = plan(args)?;
    let svg = ("--svg", args.svg.as_deref(), Kind::File(Form::Picture));
    let folder = reserve(&[("the scene", &files(&args.scene))], &[svg], ("--out", args.out.as_deref(), &FILES))?;
    let interrupt = Interrupt::listen()?;
    let mut count = Count::new();
    let mut tell = |done: u64, total: u64| count.show(done as usize, total as usize, "runs");
    let result = hold(&scene, plan, &mut tell, &|| interrupt.signal().is_none());
    count.clear();
    let found = result.map_err(|error| match (error, interrupt.signal()) {
        (HoldError::Stopped { done }, Some(signal)) => {
            let files = if args.out.is_some() { "; no file was written, and older ones are as they were" } else { "" };
            Failure::incomplete(format!("interrupted by {signal} after {done} runs{files}"))
        }
        (error @ (HoldError::Stopped { .. } | HoldError::Scene { .. }), _) => Failure::incomplete(error),
        (error, _) => Failure::bad_input(error),
    })?;
    let report = HoldReport::from(&found);
    if let Some(folder) = folder {
        let texts = [report.json(), hold_csv(&report), plot::hold(&found), report.report().to_string()];
        folder.write(&FILES, &texts)?;
    }
    if let Some(path) = &args.svg {
        save(path, &plot::hold(&found))?;
    }
    answer(&report, args.json)?;
    Ok(Status::Done)
}

fn gripper(args: &HoldArgs) -> Result<Scene, Failure> {
    let scene = args.set.load_any(&args.scene)?;
    only_gripper(scene, &args.scene.display().to_string(), "scenes/gripper/hold.toml").map_err(Failure::bad_input)
}

fn plan(args: &HoldArgs) -> Result<Plan, Failure> {
    let loads = match (&args.vibration, args.moves) {
        (Some(Frequencies(frequencies_hz)), _) => {
            let axes = args.along.iter().map(|axis| Axis::from(*axis)).collect();
            Loads::Vibrations { axes, frequencies_hz: frequencies_hz.clone() }
        }
        (None, true) => Loads::Move,
        (None, false) => Loads::Pulses { directions: args.directions, length_s: args.pulse },
    };
    let plan = Plan {
        model: args.model.into(),
        loads,
        begins_s: args.at,
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

/// A quantity above 0, such as the example.
fn above_zero(text: &str, dimension: Dimension, example: &str) -> Result<f64, String> {
    positive(text, dimension, &format!("must be more than 0; expected {example}"))
}

fn length(text: &str) -> Result<f64, String> {
    above_zero(text, Dimension::Length, "a length such as \"0.5 mm\"")
}

fn time(text: &str) -> Result<f64, String> {
    above_zero(text, Dimension::Time, "a time such as \"40 ms\"")
}

fn instant(text: &str) -> Result<f64, String> {
    above_zero(text, Dimension::Time, "a time such as \"60 ms\"")
}

fn acceleration(text: &str) -> Result<f64, String> {
    above_zero(text, Dimension::Acceleration, "an acceleration such as \"100 m/s^2\"")
}

fn frequencies(text: &str) -> Result<Frequencies, String> {
    let one = |item: &str| above_zero(item.trim(), Dimension::Frequency, "frequencies such as \"50 Hz, 200 Hz\"");
    let mut values = text.split(',').map(one).collect::<Result<Vec<f64>, _>>()?;
    values.sort_by(f64::total_cmp);
    match values.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(format!("{} Hz is there twice; expected frequencies such as \"50 Hz, 200 Hz\"", pair[0])),
        None => Ok(Frequencies(values)),
    }
}

fn directions(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 1..=360) => Ok(count),
        _ => Err("expected a number from 1 to 360, such as 8".to_string()),
    }
}

fn scan(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 2..=1000) => Ok(count),
        _ => Err("expected a number from 2 to 1000, such as 11".to_string()),
    }
}

fn part(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(part) if (1e-9..1.0).contains(&part) => Ok(part),
        _ => Err("expected a number from 1e-9 to below 1, such as 0.02".to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_checked() {
        assert_eq!(frequencies("200 Hz, 50 Hz"), Ok(Frequencies(vec![50.0, 200.0])));
        assert_eq!((time("40 ms"), acceleration("20 m/s^2"), scan("2")), (Ok(0.04), Ok(20.0), Ok(2)));
        for (message, error) in [
            ("more than 0", length("0 mm").err()),
            ("no unit", acceleration("20").err()),
            ("more than 0", time("-1 ms").err()),
            ("twice", frequencies("50 Hz,50 Hz").err()),
            ("such as", frequencies("0 Hz").err()),
            ("1 to 360", directions("0").err()),
            ("from 2", scan("1").err()),
            ("below 1", part("1").err()),
            ("below 1", part("nan").err()),
        ] {
            let error = error.expect(message);
            assert!(error.contains(message), "{error}");
        }
    }
}
