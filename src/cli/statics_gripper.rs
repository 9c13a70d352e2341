//! `phalanx statics` of a gripper: how its object is held, in the posture of a run or in another.

use std::path::Path;

use clap::Args;

use super::interrupt::Interrupt;
use super::output::answer;
use super::overrides::positive;
use super::saved::save;
use super::{Failure, Status};
use crate::grasp::gripper::{Asked, GripperGraspError, PostureOf, gripper_grasp};
use crate::plot;
use crate::report::statics::GripperStaticsReport;
use crate::scene::Scene;
use crate::statics::StaticsError;
use crate::study::posture::{Posture, directions, posture};
use crate::units::Dimension;

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
        self.posture.asked(self.at, self.within).map_err(Failure::bad_input)
    }
}

/// Runs the command for a gripper.
pub fn run(scene: &Scene, args: &GripperArgs, shared: &Shared<'_>) -> Result<Status, Failure> {
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
        save(path, &plot::balance(scene, &found, plot::Form::Sheet))?;
        report.svg = Some(path.display().to_string());
    }
    answer(&report, shared.json)?;
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

fn time(text: &str) -> Result<f64, String> {
    positive(text, Dimension::Time, "must be more than 0; expected a time such as \"20 ms\"")
}

fn length(text: &str) -> Result<f64, String> {
    positive(text, Dimension::Length, "must be more than 0; expected a length such as \"0.05 mm\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_lengths_are_checked() {
        assert_eq!((time("20 ms"), length("1 mm")), (Ok(0.02), Ok(1e-3)));
        assert!(time("0 ms").expect_err("no time").contains("more than 0"));
        assert!(length("0 mm").expect_err("no length").contains("more than 0"));
    }
}
