//! `phalanx statics` of a gripper: its grasp in the posture of a run or in a given posture.

use std::path::Path;

use clap::Args;

use super::interrupt::Interrupt;
use super::output::print_result;
use super::overrides::parse_positive;
use super::targets::save;
use super::{Failure, Status};
use crate::grasp::gripper::{GripperGraspError, GripperGraspRequest, PostureRequest, gripper_grasp};
use crate::plot;
use crate::report::statics::GripperStaticsReport;
use crate::scene::Scene;
use crate::statics::StaticsError;
use crate::study::posture::{PostureSpec, parse_direction_count, parse_posture};
use crate::units::Dimension;

/// Arguments for grippers only.
#[derive(Clone, Debug, Args)]
pub struct GripperArgs {
    /// Posture: "run" is the posture of a run of the scene; "geometric" has all phalanges on the object at its position
    /// in the scene; or angles with units, such as "q11=2 deg, q21=65 deg" for both fingers, q11_r, q21_r, q11_l, q21_l
    /// for one finger, and x and y for the object's centre
    #[arg(long, value_name = "POSTURE", value_parser = parse_posture, default_value = "run", help_heading = "For a gripper")]
    posture: PostureSpec,

    /// Time of the run, with its unit [default: its end, or when the fingers release the object]
    #[arg(long, value_name = "TIME", value_parser = parse_time, help_heading = "For a gripper")]
    at: Option<f64>,

    /// Largest gap at which a surface counts as in contact [default: 0.05 mm for given angles; for a run only surfaces
    /// with a contact force]
    #[arg(long, value_name = "LENGTH", value_parser = parse_length, help_heading = "For a gripper")]
    within: Option<f64>,

    /// Angle between neighbouring directions of acceleration, with its unit; must divide a full turn
    #[arg(long, value_name = "ANGLE", value_parser = parse_direction_count, default_value = "15 deg", help_heading = "For a gripper")]
    every: usize,
}

/// Largest angle between neighbouring directions in a picture, degrees.
const MAX_PICTURE_SPACING_DEG: f64 = 1.0;

/// Arguments for all scenes.
pub struct SharedArgs<'a> {
    pub mu_static: &'a [f64],
    pub motor_n_m: Option<f64>,
    pub svg: Option<&'a Path>,
    pub json: bool,
}

impl GripperArgs {
    /// Returns the first of these flags that differs from its default; such a flag is an error for other kinds of
    /// scene.
    pub fn first_given_flag(&self) -> Option<&'static str> {
        let flags = [
            (self.posture != PostureSpec::Run, "--posture"),
            (self.at.is_some(), "--at"),
            (self.within.is_some(), "--within"),
            (self.every != 24, "--every"),
        ];
        flags.into_iter().find(|(given, _)| *given).map(|(_, flag)| flag)
    }

    fn posture(&self) -> Result<PostureRequest, Failure> {
        self.posture.to_grasp_posture(self.at, self.within).map_err(Failure::bad_input)
    }
}

/// Runs the command for a gripper.
pub fn run(scene: &Scene, args: &GripperArgs, shared: &SharedArgs<'_>) -> Result<Status, Failure> {
    let posture = args.posture()?;
    let interrupt = Interrupt::listen()?;
    // A picture needs more directions than a table.
    let refinement = match shared.svg {
        Some(_) => (360.0 / MAX_PICTURE_SPACING_DEG / args.every as f64).ceil().max(1.0) as usize,
        None => 1,
    };
    let request = GripperGraspRequest {
        posture,
        mu_static: shared.mu_static.to_vec(),
        motor_n_m: shared.motor_n_m,
        directions: args.every * refinement,
    };
    let grasp = gripper_grasp(scene, &request, &|| interrupt.signal().is_none()).map_err(|error| {
        match (error, interrupt.signal()) {
            (GripperGraspError::Stopped, Some(signal)) => Failure::incomplete(format!("interrupted by {signal}")),
            (error, _) => grasp_failure(error),
        }
    })?;
    let mut report = GripperStaticsReport::new(&grasp, refinement);
    if let Some(path) = shared.svg {
        save(path, &plot::balance(scene, &grasp, plot::PictureFormat::Standalone))?;
        report.svg = Some(path.display().to_string());
    }
    print_result(&report, shared.json)?;
    Ok(Status::Done)
}

fn grasp_failure(error: GripperGraspError) -> Failure {
    match &error {
        GripperGraspError::Run { .. }
        | GripperGraspError::Stopped
        | GripperGraspError::Statics { error: StaticsError::Balance { .. }, .. } => Failure::incomplete(error),
        _ => Failure::bad_input(error),
    }
}

fn parse_time(text: &str) -> Result<f64, String> {
    parse_positive(text, Dimension::Time, "must be more than 0; expected a time such as \"20 ms\"")
}

fn parse_length(text: &str) -> Result<f64, String> {
    parse_positive(text, Dimension::Length, "must be more than 0; expected a length such as \"0.05 mm\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rejects_invalid_times_and_lengths() {
        assert_eq!((parse_time("20 ms"), parse_length("1 mm")), (Ok(0.02), Ok(1e-3)));
        assert!(parse_time("0 ms").expect_err("zero time").contains("more than 0"));
        assert!(parse_length("0 mm").expect_err("zero length").contains("more than 0"));
    }
}
