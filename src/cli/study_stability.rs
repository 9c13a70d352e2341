//! `phalanx study stability`: where the engine model is stable, and where it is right.

use std::path::PathBuf;

use clap::Args;

use super::interrupt::Interrupt;
use super::output::answer;
use super::overrides::positive;
use super::progress::Count;
use super::set::{SetArgs, files};
use super::targets::reserve;
use super::{Failure, Status};
use crate::plot;
use crate::report::stability::stability_csv;
use crate::scene::words::SceneKind;
use crate::study::stability::{ACCURACY_RAD, Grid, StudyError, stability};
use crate::units::{self, Dimension};
use crate::wording::Reported;

/// Where the engine is stable and where it is right: a map over step size, contact stiffness and contact damping.
///
/// Runs the scene of a finger with the engine at fixed steps, the stiffness k and the greatest damping c_max of both
/// contacts times each pair of factors; the joint limit keeps its law. Each pair has a reference of its own: the analytic
/// model at its reference preset, up to `[validate] until`.
///
/// "failed" is a run that ended in an error, or where a number was not finite, mechanical energy rose beyond the motor's
/// work by more than 10 % of the reference's energy throughput, the dissipated energy fell by as much, or a contact or the joint limit
/// was deeper than all energy there is could push it. "accurate" is any other run whose joint angles stay within the bound
/// all along; the rest is stable, but inaccurate. Where the reference cannot be completed nothing is judged.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phalanx study stability scenes/experiment-95.toml\n  phalanx study stability \
                  scenes/experiment-95.toml --out map\n  phalanx study stability scenes/experiment-95.toml --steps \"100 us, 10 us\" \
                  --stiffness 1,100 --damping 0,1 --json\n\nExit status: 0 done, whatever failed in the map; 2 bad input; 3 \
                  interrupted, or files could not be written.")]
pub struct StabilityArgs {
    /// Scene of a finger with an object (TOML)
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Fixed steps with their units [default: 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6 and 1e-6 s]
    #[arg(long, value_name = "TIMES", value_parser = steps, conflicts_with = "quick")]
    steps: Option<List>,

    /// Factors of the contact stiffness k, above 0 [default: 0.01, 1, 100, 1e4]
    #[arg(long, value_name = "FACTORS", value_parser = stiffness)]
    stiffness: Option<List>,

    /// Factors of the contact damping c_max, 0 or above [default: 0, 0.001, 1, 10]
    #[arg(long, value_name = "FACTORS", value_parser = damping)]
    damping: Option<List>,

    /// Largest angle difference of an accurate run, with its unit [default: 1e-3 rad]
    #[arg(long, value_name = "ANGLE", value_parser = accuracy)]
    accurate: Option<f64>,

    /// Write table.txt, stability.json, stability.csv and stability.svg there; the directory is made if need be, and an
    /// older file is replaced only when the new one is whole
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,

    /// Leave out steps below 1e-5 s
    #[arg(long)]
    quick: bool,
}

/// Everything that is in the directory in the end.
const FILES: [&str; 4] = ["stability.json", "stability.csv", "stability.svg", "table.txt"];

/// Values of one flag, in order from small to large.
#[derive(Clone, Debug, PartialEq)]
struct List(Vec<f64>);

/// Runs the command.
pub fn run(args: &StabilityArgs) -> Result<Status, Failure> {
    let scene = args.set.load_any(&args.scene)?;
    if scene.kind() != SceneKind::Finger {
        return Err(Failure::bad_input(format!(
            "{} is {}; this study takes the scene of a finger (kind = \"finger\"), like \
             scenes/experiment-95.toml",
            args.scene.display(),
            if scene.kind() == SceneKind::Gripper { "the scene of a gripper" } else { "a scene of discs" }
        )));
    }
    let grid = grid(args);
    let folder = reserve(&[("the scene", &files(&args.scene))], &[], ("--out", args.out.as_deref(), &FILES))?;
    let interrupt = Interrupt::listen()?;
    let mut count = Count::new();
    let mut tell = |done, total, next: &str| count.show(done, total, next);
    let accuracy_rad = args.accurate.unwrap_or(ACCURACY_RAD);
    let result = stability(&scene, &grid, accuracy_rad, &mut tell, &|| interrupt.signal().is_none());
    count.clear();
    let study = result.map_err(|error| match (error, interrupt.signal()) {
        (StudyError::Stopped { done, total }, Some(signal)) => {
            let files = if args.out.is_some() { "; no file was written, and older ones are as they were" } else { "" };
            Failure::incomplete(format!(
                "the study was interrupted by {signal} after {done} of {total} parts: there is no map{files}"
            ))
        }
        (error @ StudyError::Stopped { .. }, None) => Failure::incomplete(error),
        (error, _) => Failure::bad_input(error),
    })?;
    if let Some(folder) = folder {
        let texts = [study.json(), stability_csv(&study), plot::stability(&study), study.report().to_string()];
        folder.write(&FILES, &texts)?;
    }
    answer(&study, args.json)?;
    Ok(Status::Done)
}

/// The usual grid with what was given in its place.
fn grid(args: &StabilityArgs) -> Grid {
    let usual = Grid::usual(args.quick);
    let or = |list: &Option<List>, usual: Vec<f64>| list.as_ref().map_or(usual, |List(values)| values.clone());
    let mut given = or(&args.steps, Vec::new());
    given.reverse();
    Grid {
        steps_s: if given.is_empty() { usual.steps_s } else { given },
        stiffness_factors: or(&args.stiffness, usual.stiffness_factors),
        damping_factors: or(&args.damping, usual.damping_factors),
    }
}

fn steps(text: &str) -> Result<List, String> {
    list(text, "times such as \"100 us, 10 us\"", |item| match units::parse(item, Dimension::Time) {
        Ok(step_s) if step_s > 0.0 => Ok(step_s),
        Ok(_) => Err(format!("`{item}`: a step must be longer than 0")),
        Err(error) => Err(error.to_string()),
    })
}

fn stiffness(text: &str) -> Result<List, String> {
    list(text, "factors such as 0.01,1,100", |item| {
        number(item).filter(|&factor| factor > 0.0).ok_or(format!("`{item}` is no factor above 0"))
    })
}

fn damping(text: &str) -> Result<List, String> {
    list(text, "factors such as 0,1,10", |item| {
        number(item).filter(|&factor| factor >= 0.0).ok_or(format!("`{item}` is no factor from 0"))
    })
}

fn accuracy(text: &str) -> Result<f64, String> {
    positive(text, Dimension::Angle, "a bound must be more than 0; expected an angle such as \"1e-3 rad\"")
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

/// Values between commas, sorted; each may be there once.
fn list(text: &str, wanted: &str, read: impl Fn(&str) -> Result<f64, String>) -> Result<List, String> {
    let with_example = |message: String| format!("{message}; expected {wanted}");
    let mut values =
        text.split(',').map(|item| read(item.trim())).collect::<Result<Vec<_>, _>>().map_err(with_example)?;
    values.sort_by(f64::total_cmp);
    match values.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(with_example(format!("{} is there twice", pair[0]))),
        None => Ok(List(values)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_sorted_and_checked() {
        assert_eq!(steps("10 us, 1 ms"), Ok(List(vec![1e-5, 1e-3])));
        assert_eq!(damping("10,0"), Ok(List(vec![0.0, 10.0])));
        for (result, message) in [
            (steps("1e-3"), "no unit"),
            (steps("0 s"), "longer than 0"),
            (steps("1 mm"), "a length"),
            (stiffness("0"), "above 0"),
            (stiffness("1,,2"), "above 0"),
            (stiffness("nan"), "above 0"),
            (stiffness("1,1.0"), "twice"),
            (damping("-1"), "from 0"),
        ] {
            let error = result.expect_err(message);
            assert!(error.contains(message) && error.contains("such as"), "{error}");
        }
    }
}
