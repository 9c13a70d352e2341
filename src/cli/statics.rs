//! `phalanx statics`: statics of the grasp of a scene.

use std::path::PathBuf;

use clap::Args;

use super::output::print_result;
use super::set::{SetArgs, source_files};
use super::statics_gripper::{self, GripperArgs, SharedArgs};
use super::targets::{FileKind, NO_DIRECTORY, TargetKind, reserve, save};
use super::{Failure, Status};
use crate::grasp::finger::{GraspOverrides, GraspStudyError, grasp};
use crate::plot;
use crate::report::statics::StaticsReport;
use crate::scene::keywords::SceneKind;
use crate::statics::StaticsError;
use crate::units::{self, Dimension};

/// Analyse the static grasp: contact forces, ejection, form and force closure, and admissible accelerations.
///
/// For a finger, both phalanges are assumed to contact the object in the final posture that follows from the geometry.
/// Contact forces balance the motor and the spring (thesis, eq. 2.32), with friction on the object towards the palm;
/// they are also given in Birglen's frame. The form-closure test determines whether the object can move between finger,
/// mirrored finger and palm while the motors cannot be backdriven. Its result includes a certificate: a free motion, or
/// balanced forces that exclude any free motion.
///
/// For a gripper, the posture is the one at the end of its run (or when its fingers release the object), or the one given
/// by --posture, symmetric or not. Further results are force closure with friction, with its quality Q1 and weakest
/// wrench, and the largest palm acceleration in each direction that contact forces within their friction cones can
/// balance, with blocked motors and with motors at their torque, and the cause of failure beyond it.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx statics scenes/experiment-95.toml\n  phalanx statics scenes/experiment-95.toml \
                  --mu-static 0,0.4,0.8 --svg grasp.svg\n  phalanx statics my-finger.toml --motor \"500 N*mm\" --json\n  phalanx statics \
                  scenes/gripper/cycle.toml --at \"200 ms\" --svg polar.svg\n  phalanx statics scenes/gripper/design-95.toml --posture \
                  geometric --mu-static 0.2,0.4 --every \"30 deg\"\n  phalanx statics scenes/gripper/design-95.toml --posture \"q11=2.09 \
                  deg, q21=65.02 deg\"\n\nExit status: 0 done, whatever the result; 2 bad input, such as a finger that does not \
                  reach its object; 3 form closure of a finger or the balance of forces could not be decided, a run could not be \
                  completed, or a file could not be written."
)]
pub struct StaticsArgs {
    /// Scene file (TOML) of a finger with an object, or of a gripper
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Friction coefficients of all contacts, comma-separated [default: 0 and those of the scene; for a gripper only
    /// those of the scene, which always determine its posture]
    #[arg(long, value_name = "MU,...", value_delimiter = ',', value_parser = parse_friction)]
    mu_static: Vec<f64>,

    /// Motor torque with its unit, such as "500 N*mm" [default: the torque at the end of the scene]
    #[arg(long, value_name = "TORQUE", value_parser = parse_torque)]
    motor: Option<f64>,

    /// Draw the grasp to this file, with the forces for the last friction coefficient, or for a gripper with its
    /// admissible accelerations; an existing file is replaced only when the new one is complete
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    gripper: GripperArgs,
}

impl StaticsArgs {
    fn shared(&self) -> SharedArgs<'_> {
        SharedArgs { mu_static: &self.mu_static, motor_n_m: self.motor, svg: self.svg.as_deref(), json: self.json }
    }
}

/// Runs `phalanx statics`.
pub fn run(args: &StaticsArgs) -> Result<Status, Failure> {
    let svg = ("--svg", args.svg.as_deref(), TargetKind::File(FileKind::Picture));
    reserve(&[("the scene", &source_files(&args.scene))], &[svg], NO_DIRECTORY)?;
    let scene = args.set.load_any(&args.scene)?;
    match scene.kind() {
        SceneKind::Finger => {}
        SceneKind::Gripper => return statics_gripper::run(&scene, &args.gripper, &args.shared()),
        SceneKind::Bodies => {
            return Err(Failure::bad_input(format!(
                "{} is a scene of discs (kind = \"bodies\"), but statics needs the grasp of a finger or a gripper; give a scene \
                 such as scenes/experiment-95.toml or scenes/gripper/design-95.toml",
                args.scene.display()
            )));
        }
    }
    if let Some(flag) = args.gripper.first_given_flag() {
        return Err(Failure::bad_input(format!(
            "{flag} needs a gripper, but {} is a scene of one finger, whose posture follows from the geometry; remove the flag, or \
             give a scene such as scenes/gripper/design-95.toml",
            args.scene.display()
        )));
    }
    let overrides = GraspOverrides { mu_static: args.mu_static.clone(), motor_n_m: args.motor };
    let grasp_statics = grasp(&scene, &overrides).map_err(grasp_failure)?;
    let mut report = StaticsReport::new(&grasp_statics);
    if let Some(path) = &args.svg {
        save(path, &plot::grasp(&scene, &grasp_statics, plot::PictureFormat::Standalone))?;
        report.svg = Some(path.display().to_string());
    }
    print_result(&report, args.json)?;
    Ok(Status::Done)
}

fn grasp_failure(error: GraspStudyError) -> Failure {
    match &error {
        GraspStudyError::Statics { error: StaticsError::Undecided { .. } | StaticsError::Program { .. }, .. } => {
            Failure::incomplete(error)
        }
        _ => Failure::bad_input(error),
    }
}

fn parse_friction(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(mu) if mu.is_finite() && mu >= 0.0 => Ok(mu),
        _ => Err("expected one or more comma-separated numbers, each 0 or more, such as 0,0.4,0.8".to_string()),
    }
}

fn parse_torque(text: &str) -> Result<f64, String> {
    units::parse(text, Dimension::Torque).map_err(|error| error.to_string())
}
