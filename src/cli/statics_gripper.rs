//! `phalanx statics` of a gripper: how its object is held, in the posture of a run or in another.

use std::path::Path;

use clap::Args;

use super::interrupt::Interrupt;
use super::output::{print, show};
use super::overrides::positive;
use super::saved::{broken, save};
use super::{Failure, Status};
use crate::plot;
use crate::report::{GripperStaticsReport, gripper_statics_json, gripper_statics_text};
use crate::scene::GripperScene;
use crate::statics::StaticsError;
use crate::study::gripper_grasp::{Asked, Given, GripperGraspError, PostureOf, gripper_grasp};
use crate::units::{self, Dimension};

/// What only a gripper is asked.
#[derive(Clone, Debug, Args)]
pub struct GripperArgs {
    /// Of a gripper: its posture. "run" is that of a run of the scene, "geometric" has all phalanges on the object where the scene has
    /// it; or angles with their units, such as "q11=2 deg, q21=65 deg" for both fingers, q11_r, q21_r, q11_l, q21_l for one of them, and
    /// x and y for the object's centre
    #[arg(long, value_name = "POSTURE", value_parser = posture, default_value = "run", help_heading = "Of a gripper")]
    posture: Posture,

    /// Time of the run, with its unit, instead of its end, or of when the fingers let go
    #[arg(long, value_name = "TIME", value_parser = time, help_heading = "Of a gripper")]
    at: Option<f64>,

    /// How far a surface may be from the object to touch it: where angles are given, 0.05 mm if nothing else is said; of a run only what
    /// presses touches it otherwise
    #[arg(long, value_name = "LENGTH", value_parser = length, help_heading = "Of a gripper")]
    within: Option<f64>,

    /// Angle from one direction of acceleration to the next, with its unit; a whole number of them make a turn
    #[arg(long, value_name = "ANGLE", value_parser = directions, default_value = "15 deg", help_heading = "Of a gripper")]
    every: usize,
}

/// What is said of a posture.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Posture {
    Run,
    Geometric,
    Given { angles_rad: [[f64; 2]; 2], object_m: [Option<f64>; 2] },
}

/// Nearer than this to the object's surface a phalanx touches it, if nothing else is said.
const WITHIN_M: f64 = 5e-5;

/// A picture has directions at most so far apart, degrees.
const FINE_DEG: f64 = 1.0;

/// What every scene may be asked.
pub struct Shared<'a> {
    pub mu_static: &'a [f64],
    pub motor_n_m: Option<f64>,
    pub svg: Option<&'a Path>,
    pub json: bool,
}

impl GripperArgs {
    /// A flag that was given, though the scene is of another kind.
    pub fn given(&self) -> Option<&'static str> {
        let flags = [
            (self.posture != Posture::Run, "--posture"),
            (self.at.is_some(), "--at"),
            (self.within.is_some(), "--within"),
            (self.every != 24, "--every"),
        ];
        flags.into_iter().find(|(given, _)| *given).map(|(_, flag)| flag)
    }

    fn posture(&self) -> Result<PostureOf, Failure> {
        if self.at.is_some() && self.posture != Posture::Run {
            return Err(Failure::bad_input(
                "--at is a time of a run, and --posture asks for none: take one of them out",
            ));
        }
        match self.posture {
            Posture::Given { angles_rad, object_m } => {
                Ok(PostureOf::Given(Given { angles_rad, object_m, within_m: self.within.unwrap_or(WITHIN_M) }))
            }
            Posture::Run => Ok(PostureOf::Run { at_s: self.at, within_m: self.within }),
            Posture::Geometric if self.within.is_some() => {
                Err(Failure::bad_input("with --posture geometric all phalanges touch the object: take out --within"))
            }
            Posture::Geometric => Ok(PostureOf::Geometric),
        }
    }
}

/// Runs the command for a gripper.
pub fn run(scene: &GripperScene, args: &GripperArgs, shared: &Shared<'_>) -> Result<Status, Failure> {
    let posture = args.posture()?;
    let interrupt = Interrupt::listen()?;
    // A picture needs more directions than a table.
    let finer = match shared.svg {
        Some(_) => (360.0 / FINE_DEG / args.every as f64).ceil().max(1.0) as usize,
        None => 1,
    };
    let asked = Asked {
        posture,
        mu_static: shared.mu_static.to_vec(),
        motor_n_m: shared.motor_n_m,
        directions: args.every * finer,
    };
    let found = gripper_grasp(scene, &asked, &|| interrupt.signal().is_none()).map_err(|error| {
        match (error, interrupt.signal()) {
            (GripperGraspError::Stopped, Some(signal)) => Failure::incomplete(format!("interrupted by {signal}")),
            (error, _) => refused(error),
        }
    })?;
    let mut report = GripperStaticsReport::new(&found, finer);
    if let Some(path) = shared.svg {
        let picture = plot::balance(scene, &found).map_err(|error| broken(path, error))?;
        save(path, &picture)?;
        report.svg = Some(path.display().to_string());
    }
    match shared.json {
        true => print(&gripper_statics_json(&report)),
        false => show(&gripper_statics_text(&report)),
    }?;
    Ok(Status::Done)
}

fn refused(error: GripperGraspError) -> Failure {
    match &error {
        GripperGraspError::Run { .. }
        | GripperGraspError::Stopped
        | GripperGraspError::Statics { error: StaticsError::Balance { .. }, .. } => Failure::incomplete(error),
        _ => Failure::bad_input(error),
    }
}

const EXAMPLE: &str = "expected \"run\", \"geometric\" or angles such as \"q11=2 deg, q21=65 deg\"";

fn posture(text: &str) -> Result<Posture, String> {
    match text.trim() {
        "run" => return Ok(Posture::Run),
        "geometric" => return Ok(Posture::Geometric),
        _ => {}
    }
    let mut angles: [[Option<f64>; 2]; 2] = [[None; 2]; 2];
    let mut object_m = [None; 2];
    let parts = text.split(',').map(str::trim).filter(|part| !part.is_empty());
    for part in parts {
        let (key, value) = part.split_once('=').ok_or_else(|| format!("`{part}` has no `=`; {EXAMPLE}"))?;
        let (key, value) = (key.trim(), value.trim());
        let (coordinate, side) = match key.split_once('_') {
            Some((coordinate, side)) => (coordinate, Some(side)),
            None => (key, None),
        };
        let sides: &[usize] = match side {
            None => &[0, 1],
            Some("r") => &[0],
            Some("l") => &[1],
            Some(_) => return Err(unknown(key)),
        };
        let said = |error: units::QuantityError| format!("`{part}`: {error}");
        match (coordinate, side) {
            ("q11" | "q21", _) => {
                let angle = units::parse(value, Dimension::Angle).map_err(said)?;
                sides.iter().for_each(|&side| angles[side][usize::from(coordinate == "q21")] = Some(angle));
            }
            ("x" | "y", None) => {
                let length = units::parse(value, Dimension::Length).map_err(said)?;
                object_m[usize::from(coordinate == "y")] = Some(length);
            }
            _ => return Err(unknown(key)),
        }
    }
    let mut angles_rad = [[0.0; 2]; 2];
    for (side, end) in ["_r", "_l"].into_iter().enumerate() {
        for (index, name) in ["q11", "q21"].into_iter().enumerate() {
            let missing = || format!("there is no {name}{end}, nor {name} for both fingers; {EXAMPLE}");
            angles_rad[side][index] = angles[side][index].ok_or_else(missing)?;
        }
    }
    Ok(Posture::Given { angles_rad, object_m })
}

fn unknown(key: &str) -> String {
    format!("`{key}` is none of q11, q21, q11_r, q21_r, q11_l, q21_l, x, y; {EXAMPLE}")
}

fn time(text: &str) -> Result<f64, String> {
    positive(text, Dimension::Time, "must be more than 0; expected a time such as \"20 ms\"")
}

fn length(text: &str) -> Result<f64, String> {
    positive(text, Dimension::Length, "must be more than 0; expected a length such as \"0.05 mm\"")
}

/// How many directions there are.
fn directions(text: &str) -> Result<usize, String> {
    let angle_rad = units::parse(text, Dimension::Angle).map_err(|error| error.to_string())?;
    let count = std::f64::consts::TAU / angle_rad;
    match count.round() {
        whole if (whole - count).abs() < 1e-6 * whole && (4.0..=720.0).contains(&whole) => Ok(whole as usize),
        _ => {
            Err("a whole number of them, from 4 to 720, makes a turn; expected an angle such as \"15 deg\"".to_string())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn postures_are_read() {
        assert_eq!((posture("run"), posture(" geometric ")), (Ok(Posture::Run), Ok(Posture::Geometric)));
        let both = posture("q11 = 0.1 rad, q21=0.2 rad,x=1 mm").expect("angles");
        assert_eq!(both, Posture::Given { angles_rad: [[0.1, 0.2]; 2], object_m: [Some(1e-3), None] });
        let one = posture("q11=0.1 rad,q21=0.2 rad,q11_l=0.3 rad").expect("angles");
        assert_eq!(one, Posture::Given { angles_rad: [[0.1, 0.2], [0.3, 0.2]], object_m: [None; 2] });
        for (text, message) in [
            ("q11=0.1 rad", "no q21_r"),
            ("q11_r=1 deg,q21=1 deg", "no q11_l"),
            ("q12=1 deg", "none of q11"),
            ("q11_x=1 deg", "none of q11"),
            ("x_r=1 mm", "none of q11"),
            ("closed", "has no `=`"),
            ("q11=1", "no unit"),
            ("", "no q11_r"),
        ] {
            let error = posture(text).expect_err(message);
            assert!(error.contains(message), "{text}: {error}");
        }
    }

    #[test]
    fn times_lengths_and_directions_are_checked() {
        assert_eq!((time("20 ms"), length("1 mm"), directions("15 deg")), (Ok(0.02), Ok(1e-3), Ok(24)));
        assert_eq!(directions("0.5 deg"), Ok(720));
        for text in ["7 deg", "0 deg", "-15 deg", "200 deg", "0.1 deg"] {
            assert!(directions(text).expect_err(text).contains("makes a turn"), "{text}");
        }
        assert!(time("0 ms").expect_err("no time").contains("more than 0"));
        assert!(length("0 mm").expect_err("no length").contains("more than 0"));
    }
}
