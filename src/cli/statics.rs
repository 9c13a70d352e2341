//! `phalanx statics`: the grasp of a scene at rest.

use std::path::PathBuf;

use clap::Args;

use super::output::answer;
use super::own::Form;
use super::saved::save;
use super::set::{SetArgs, files};
use super::statics_gripper::{self, GripperArgs, Shared};
use super::targets::{Kind, NONE, reserve};
use super::{Failure, Status};
use crate::grasp::finger::{GraspStudyError, Instead, grasp};
use crate::plot;
use crate::report::statics::StaticsReport;
use crate::scene::words::SceneKind;
use crate::statics::StaticsError;
use crate::units::{self, Dimension};

/// Look at the grasp at rest: contact forces, ejection, form and force closure, what acceleration it bears.
///
/// Of a finger: both phalanges are taken to touch the object, at the final posture that the geometry gives. Forces are those that
/// balance the motor and the spring there (thesis, eq. 2.32), with friction on the object towards the palm, and the same in Birglen's
/// frame. Form closure asks whether finger, mirrored finger and palm leave the object any way out while the motors cannot be
/// turned back; the answer comes with its certificate: the motion that is free, or forces in balance that exclude one.
///
/// Of a gripper: the posture is that of the end of its run (or of when its fingers let go), or another one (--posture), symmetric or
/// not. Beside form closure: force closure with friction, with Q1 and the wrench that is balanced least; and in every direction the
/// largest acceleration of the palm that contact forces within their friction cones can balance, with the motors blocked and at their
/// torque, and what gives way there.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx statics scenes/experiment-95.toml\n  phalanx statics scenes/experiment-95.toml \
                  --mu-static 0,0.4,0.8 --svg grasp.svg\n  phalanx statics my-finger.toml --motor \"500 N*mm\" --json\n  phalanx statics \
                  scenes/gripper/cycle.toml --at \"200 ms\" --svg polar.svg\n  phalanx statics scenes/gripper/design-95.toml --posture \
                  geometric --mu-static 0.2,0.4 --every \"30 deg\"\n  phalanx statics scenes/gripper/design-95.toml --posture \"q11=2.09 \
                  deg, q21=65.02 deg\"\n\nExit status: 0 done, whatever the grasp is like; 2 bad input, such as a finger that does not \
                  reach its object; 3 form closure of a finger or what forces balance could not be decided, a run not be completed, or \
                  a file not be written."
)]
pub struct StaticsArgs {
    /// Scene of a finger with an object, or of a gripper (TOML)
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Friction coefficients of all contacts, instead of 0 and those of the scene; of a gripper instead of those of the scene, in the
    /// posture that those lead to
    #[arg(long, value_name = "MU,...", value_delimiter = ',', value_parser = friction)]
    mu_static: Vec<f64>,

    /// Motor torque with its unit, such as "500 N*mm", instead of the one at the end of the scene
    #[arg(long, value_name = "TORQUE", value_parser = torque)]
    motor: Option<f64>,

    /// Draw the grasp into a picture, with the forces of the last of the friction coefficients, or of a gripper the accelerations that it
    /// bears; an older file is replaced only when the new one is whole
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    gripper: GripperArgs,
}

impl StaticsArgs {
    fn shared(&self) -> Shared<'_> {
        Shared { mu_static: &self.mu_static, motor_n_m: self.motor, svg: self.svg.as_deref(), json: self.json }
    }
}

/// Runs the command.
pub fn run(args: &StaticsArgs) -> Result<Status, Failure> {
    let svg = ("--svg", args.svg.as_deref(), Kind::File(Form::Picture));
    reserve(&[("the scene", &files(&args.scene))], &[svg], NONE)?;
    let scene = args.set.load_any(&args.scene)?;
    match scene.kind() {
        SceneKind::Finger => {}
        SceneKind::Gripper => return statics_gripper::run(&scene, &args.gripper, &args.shared()),
        SceneKind::Bodies => {
            return Err(Failure::bad_input(format!(
                "{} is a scene of discs (kind = \"bodies\"), and statics is about the grasp of a finger or a gripper; give a scene \
                 like scenes/experiment-95.toml or scenes/gripper/design-95.toml",
                args.scene.display()
            )));
        }
    }
    if let Some(flag) = args.gripper.given() {
        return Err(Failure::bad_input(format!(
            "{flag} is for a gripper, and {} is a scene of one finger, whose posture is the geometric one: take it out, or give a \
             scene like scenes/gripper/design-95.toml",
            args.scene.display()
        )));
    }
    let instead = Instead { mu_static: args.mu_static.clone(), motor_n_m: args.motor };
    let found = grasp(&scene, &instead).map_err(refused)?;
    let mut report = StaticsReport::new(&found);
    if let Some(path) = &args.svg {
        save(path, &plot::grasp(&scene, &found, plot::Form::Sheet))?;
        report.svg = Some(path.display().to_string());
    }
    answer(&report, args.json)?;
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
