//! `phalanx statics`: the grasp of a scene at rest.

use std::path::PathBuf;

use clap::Args;

use super::output::{print, show};
use super::own::{Form, writable};
use super::saved::{broken, save};
use super::set::SetArgs;
use super::{Failure, Status};
use crate::plot;
use crate::report::{StaticsReport, statics_json, statics_text};
use crate::scene::AnyScene;
use crate::statics::StaticsError;
use crate::study::grasp::{GraspStudyError, Instead, grasp};
use crate::units::{self, Dimension};

/// Look at the grasp at rest: contact forces, force on the palm, ejection, form closure.
///
/// Both phalanges are taken to touch the object, at the final posture that the geometry gives. Forces are those that balance
/// the motor and the spring there (thesis (2.32)), with friction on the object towards the palm, and the same in Birglen's
/// frame. Form closure asks whether finger, mirrored finger and palm leave the object any way out while the motors cannot be
/// turned back; the answer comes with its certificate: the motion that is free, or forces in balance that exclude one.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx statics scenes/experiment-95.toml\n  phalanx statics scenes/experiment-95.toml \
                  --mu-static 0,0.4,0.8 --svg grasp.svg\n  phalanx statics my-gripper.toml --motor \"500 N*mm\" --json\n\nExit \
                  status: 0 done, whatever the grasp is like; 2 bad input, such as a finger that does not reach its object; 3 \
                  form closure could not be decided, or a file not be written."
)]
pub struct StaticsArgs {
    /// Scene of a finger with an object (TOML)
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Friction coefficients of both contacts, instead of 0 and those of the scene
    #[arg(long, value_name = "MU,...", value_delimiter = ',', value_parser = friction)]
    mu_static: Vec<f64>,

    /// Motor torque with its unit, such as "500 N*mm", instead of the one at the end of the scene
    #[arg(long, value_name = "TORQUE", value_parser = torque)]
    motor: Option<f64>,

    /// Draw the grasp into a picture, with the forces of the last of the friction coefficients; an older file is replaced
    /// only when the new one is whole
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &StaticsArgs) -> Result<Status, Failure> {
    if let Some(path) = &args.svg {
        writable(path, Form::Picture)?;
    }
    let AnyScene::Finger(scene) = args.set.load_any(&args.scene)? else {
        return Err(Failure::bad_input(format!(
            "{} is a scene of discs (kind = \"bodies\"), and statics is about the grasp of a finger; give a scene like \
             scenes/experiment-95.toml",
            args.scene.display()
        )));
    };
    let instead = Instead { mu_static: args.mu_static.clone(), motor_n_m: args.motor };
    let found = grasp(&scene, &instead).map_err(refused)?;
    let mut report = StaticsReport::new(&found);
    if let Some(path) = &args.svg {
        let picture = plot::grasp(&scene, &found).map_err(|error| broken(path, error))?;
        save(path, &picture)?;
        report.svg = Some(path.display().to_string());
    }
    match args.json {
        true => print(&statics_json(&report)),
        false => show(&statics_text(&report)),
    }?;
    Ok(Status::Done)
}

fn refused(error: GraspStudyError) -> Failure {
    match &error {
        GraspStudyError::Statics { error: StaticsError::Undecided { .. } | StaticsError::Program { .. }, .. } => {
            Failure::incomplete(error)
        }
        _ => Failure::bad_input(error),
    }
}

fn friction(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(mu) if mu.is_finite() && mu >= 0.0 => Ok(mu),
        _ => Err("expected a number, 0 or more, or several with commas between them, such as 0,0.4,0.8".to_string()),
    }
}

fn torque(text: &str) -> Result<f64, String> {
    units::parse(text, Dimension::Torque).map_err(|error| error.to_string())
}
