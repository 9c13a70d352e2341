//! `phalanx study stability`: ranges in which the engine model is stable and accurate.

use std::path::PathBuf;

use clap::Args;

use super::interrupt::{self, Interrupt};
use super::output::print_result;
use super::overrides::parse_positive;
use super::progress::RunCounter;
use super::set::{SetArgs, source_files};
use super::targets::reserve;
use super::{Failure, Status};
use crate::format::ToReport;
use crate::plot;
use crate::report::stability::stability_csv;
use crate::scene::keywords::SceneKind;
use crate::study::stability::{ACCURACY_RAD, Grid, StudyError, stability};
use crate::units::{self, Dimension};

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
#[command(after_help = "Examples:\n  phalanx study stability scenes/experiment-95.toml\n  phalanx study stability \
                  scenes/experiment-95.toml --out map\n  phalanx study stability scenes/experiment-95.toml --steps \"100 us, 10 us\" \
                  --stiffness 1,100 --damping 0,1 --json\n\nExit status: 0 done, even if runs of the map failed; 2 bad input; 3 \
                  interrupted, or files could not be written.")]
pub struct StabilityArgs {
    /// Scene file (TOML) of a finger with an object
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Fixed steps, comma-separated, with units [default: 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6 and 1e-6 s]
    #[arg(long, value_name = "TIMES", value_parser = parse_steps, conflicts_with = "quick")]
    steps: Option<ValueList>,

    /// Factors of the contact stiffness k, comma-separated, above 0 [default: 0.01, 1, 100, 1e4]
    #[arg(long, value_name = "FACTORS", value_parser = parse_stiffness)]
    stiffness: Option<ValueList>,

    /// Factors of the contact damping c_max, comma-separated, 0 or more [default: 0, 0.001, 1, 10]
    #[arg(long, value_name = "FACTORS", value_parser = parse_damping)]
    damping: Option<ValueList>,

    /// Largest angle difference of an accurate run, with its unit [default: 1e-3 rad]
    #[arg(long, value_name = "ANGLE", value_parser = parse_accuracy)]
    accurate: Option<f64>,

    /// Write table.txt, stability.json, stability.csv and stability.svg to this directory, which is created if needed;
    /// an existing file is replaced only when the new one is complete
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,

    /// Omit steps below 1e-5 s
    #[arg(long)]
    quick: bool,
}

/// Files in the output directory.
const FILES: [&str; 4] = ["stability.json", "stability.csv", "stability.svg", "table.txt"];

/// Values of one flag in ascending order.
#[derive(Clone, Debug, PartialEq)]
struct ValueList(Vec<f64>);

/// Runs `phalanx study stability`.
pub fn run(args: &StabilityArgs) -> Result<Status, Failure> {
    let scene = args.set.load_any(&args.scene)?;
    if scene.kind() != SceneKind::Finger {
        return Err(Failure::bad_input(format!(
            "{} is {}; this study needs the scene of a finger (kind = \"finger\"), such as \
             scenes/experiment-95.toml",
            args.scene.display(),
            if scene.kind() == SceneKind::Gripper { "the scene of a gripper" } else { "a scene of discs" }
        )));
    }
    let grid = build_grid(args);
    let directory = reserve(&[("the scene", &source_files(&args.scene))], &[], ("--out", args.out.as_deref(), &FILES))?;
    let interrupt = Interrupt::listen()?;
    let mut counter = RunCounter::new();
    let mut report_progress = |done, total, next: &str| counter.update(done, total, next);
    let accuracy_rad = args.accurate.unwrap_or(ACCURACY_RAD);
    let result = stability(&scene, &grid, accuracy_rad, &mut report_progress, &|| interrupt.signal().is_none());
    counter.clear();
    let study = result.map_err(|error| match (error, interrupt.signal()) {
        (StudyError::Stopped { done, total }, Some(signal)) => {
            let files = if args.out.is_some() { interrupt::NO_FILE_WRITTEN } else { "" };
            Failure::incomplete(format!(
                "the study was interrupted by {signal} after {done} of {total} parts; there is no map{files}"
            ))
        }
        (error @ StudyError::Stopped { .. }, None) => Failure::incomplete(error),
        (error, _) => Failure::bad_input(error),
    })?;
    if let Some(directory) = directory {
        let texts = [study.json(), stability_csv(&study), plot::stability(&study), study.report().to_string()];
        directory.write(&FILES, &texts)?;
    }
    print_result(&study, args.json)?;
    Ok(Status::Done)
}

/// Builds the grid: the given values, else those of the standard grid.
fn build_grid(args: &StabilityArgs) -> Grid {
    let standard = Grid::standard(args.quick);
    let values_or = |list: &Option<ValueList>, standard: Vec<f64>| {
        list.as_ref().map_or(standard, |ValueList(values)| values.clone())
    };
    let mut steps_s = values_or(&args.steps, Vec::new());
    steps_s.reverse();
    Grid {
        steps_s: if steps_s.is_empty() { standard.steps_s } else { steps_s },
        stiffness_factors: values_or(&args.stiffness, standard.stiffness_factors),
        damping_factors: values_or(&args.damping, standard.damping_factors),
    }
}

fn parse_steps(text: &str) -> Result<ValueList, String> {
    parse_list(text, "times such as \"100 us, 10 us\"", |item| match units::parse(item, Dimension::Time) {
        Ok(step_s) if step_s > 0.0 => Ok(step_s),
        Ok(_) => Err(format!("`{item}`: a step must be longer than 0")),
        Err(error) => Err(error.to_string()),
    })
}

fn parse_stiffness(text: &str) -> Result<ValueList, String> {
    parse_list(text, "factors such as 0.01,1,100", |item| {
        parse_number(item).filter(|&factor| factor > 0.0).ok_or(format!("`{item}` is not a factor above 0"))
    })
}

fn parse_damping(text: &str) -> Result<ValueList, String> {
    parse_list(text, "factors such as 0,1,10", |item| {
        parse_number(item).filter(|&factor| factor >= 0.0).ok_or(format!("`{item}` is not a factor of 0 or more"))
    })
}

fn parse_accuracy(text: &str) -> Result<f64, String> {
    parse_positive(text, Dimension::Angle, "the bound must be more than 0; expected an angle such as \"1e-3 rad\"")
}

fn parse_number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

/// Parses comma-separated values and sorts them; a value may occur only once.
fn parse_list(text: &str, expected: &str, read: impl Fn(&str) -> Result<f64, String>) -> Result<ValueList, String> {
    let with_example = |message: String| format!("{message}; expected {expected}");
    let mut values =
        text.split(',').map(|item| read(item.trim())).collect::<Result<Vec<_>, _>>().map_err(with_example)?;
    values.sort_by(f64::total_cmp);
    match values.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(with_example(format!("{} is given twice", pair[0]))),
        None => Ok(ValueList(values)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_sorted_and_checked() {
        assert_eq!(parse_steps("10 us, 1 ms"), Ok(ValueList(vec![1e-5, 1e-3])));
        assert_eq!(parse_damping("10,0"), Ok(ValueList(vec![0.0, 10.0])));
        for (result, message) in [
            (parse_steps("1e-3"), "no unit"),
            (parse_steps("0 s"), "longer than 0"),
            (parse_steps("1 mm"), "a length"),
            (parse_stiffness("0"), "above 0"),
            (parse_stiffness("1,,2"), "above 0"),
            (parse_stiffness("nan"), "above 0"),
            (parse_stiffness("1,1.0"), "twice"),
            (parse_damping("-1"), "0 or more"),
        ] {
            let error = result.expect_err(message);
            assert!(error.contains(message) && error.contains("such as"), "{error}");
        }
    }
}
