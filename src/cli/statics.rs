//! `phalanx statics`: statics of the grasp of a scene.

use std::path::PathBuf;

use clap::Args;

use super::interrupt::Interrupt;
use super::output::print_result;
use super::parsers::number;
use super::set::{SetArgs, source_files};
use super::targets::{FileKind, NO_DIRECTORY, TargetKind, reserve, save};
use super::{Failure, Status};
use crate::grasp::finger::{GraspOverrides, GraspStudyError, grasp};
use crate::grasp::gripper::{GripperGraspError, GripperGraspRequest, gripper_grasp};
use crate::plot;
use crate::report::statics::{GripperStaticsReport, StaticsReport};
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::statics::StaticsError;
use crate::study::posture::{PostureSpec, parse_direction_count, parse_posture};
use crate::units::{self, Dimension, parse_positive};

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
pub(crate) struct StaticsArgs {
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

/// Arguments for grippers only.
#[derive(Clone, Debug, Args)]
pub(crate) struct GripperArgs {
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

impl GripperArgs {
    /// Returns the first of these flags that differs from its default; such a flag is an error for other kinds of
    /// scene.
    pub(crate) fn first_given_flag(&self) -> Option<&'static str> {
        let flags = [
            (self.posture != PostureSpec::Run, "--posture"),
            (self.at.is_some(), "--at"),
            (self.within.is_some(), "--within"),
            (self.every != 24, "--every"),
        ];
        flags.into_iter().find(|(given, _)| *given).map(|(_, flag)| flag)
    }
}

/// Runs `phalanx statics`.
pub fn run(args: &StaticsArgs) -> Result<Status, Failure> {
    let svg = ("--svg", args.svg.as_deref(), TargetKind::File(FileKind::Picture));
    reserve(&[("the scene", &source_files(&args.scene))], &[svg], NO_DIRECTORY)?;
    let scene = args.set.load_any(&args.scene)?;
    match scene.kind() {
        SceneKind::Finger => run_finger(args, &scene),
        SceneKind::Gripper => run_gripper(args, &scene),
        SceneKind::Bodies => Err(Failure::bad_input(format!(
            "{} is a scene of discs (kind = \"bodies\"), but statics needs the grasp of a finger or a gripper; give a scene \
             such as scenes/experiment-95.toml or scenes/gripper/design-95.toml",
            args.scene.display()
        ))),
    }
}

fn run_finger(args: &StaticsArgs, scene: &Scene) -> Result<Status, Failure> {
    if let Some(flag) = args.gripper.first_given_flag() {
        return Err(Failure::bad_input(format!(
            "{flag} needs a gripper, but {} is a scene of one finger, whose posture follows from the geometry; remove the flag, or \
             give a scene such as scenes/gripper/design-95.toml",
            args.scene.display()
        )));
    }
    let overrides = GraspOverrides { mu_static: args.mu_static.clone(), motor_n_m: args.motor };
    let grasp = grasp(scene, &overrides).map_err(|error| match &error {
        GraspStudyError::Statics { error: StaticsError::Undecided { .. } | StaticsError::Program { .. }, .. } => {
            Failure::incomplete(error)
        }
        _ => Failure::bad_input(error),
    })?;
    let svg = args.save_picture(|| plot::grasp(scene, &grasp, plot::PictureFormat::Standalone))?;
    print_result(&StaticsReport { svg, ..StaticsReport::new(&grasp) }, args.json)?;
    Ok(Status::Done)
}

fn run_gripper(args: &StaticsArgs, scene: &Scene) -> Result<Status, Failure> {
    let GripperArgs { posture, at, within, every } = &args.gripper;
    let interrupt = Interrupt::listen()?;
    // A picture needs more directions than a table.
    let refinement = match args.svg {
        Some(_) => (360.0 / MAX_PICTURE_SPACING_DEG / *every as f64).ceil().max(1.0) as usize,
        None => 1,
    };
    let request = GripperGraspRequest {
        posture: posture.to_grasp_posture(*at, *within).map_err(Failure::bad_input)?,
        mu_static: args.mu_static.clone(),
        motor_n_m: args.motor,
        directions: every * refinement,
    };
    let grasp = gripper_grasp(scene, &request, &|| interrupt.signal().is_none()).map_err(|error| {
        match (&error, interrupt.signal()) {
            (GripperGraspError::Stopped, Some(signal)) => Failure::incomplete(format!("interrupted by {signal}")),
            (GripperGraspError::Run { .. } | GripperGraspError::Stopped, _)
            | (GripperGraspError::Statics { error: StaticsError::Balance { .. }, .. }, _) => Failure::incomplete(error),
            _ => Failure::bad_input(error),
        }
    })?;
    let svg = args.save_picture(|| plot::balance(scene, &grasp, plot::PictureFormat::Standalone))?;
    let mut report = GripperStaticsReport::new(&grasp, refinement);
    report.svg = svg;
    print_result(&report, args.json)?;
    Ok(Status::Done)
}

impl StaticsArgs {
    /// Writes the picture if it was requested, and returns its path.
    fn save_picture(&self, draw: impl FnOnce() -> String) -> Result<Option<String>, Failure> {
        let Some(path) = &self.svg else { return Ok(None) };
        save(path, &draw())?;
        Ok(Some(path.display().to_string()))
    }
}

fn parse_friction(text: &str) -> Result<f64, String> {
    let expected = "one or more comma-separated numbers, each 0 or more, such as 0,0.4,0.8";
    number(|mu: &f64| mu.is_finite() && *mu >= 0.0, expected)(text)
}

fn parse_torque(text: &str) -> Result<f64, String> {
    units::parse(text, Dimension::Torque).map_err(|error| error.to_string())
}

fn parse_time(text: &str) -> Result<f64, String> {
    parse_positive(text, Dimension::Time, "must be more than 0; expected a time such as \"20 ms\"")
}

fn parse_length(text: &str) -> Result<f64, String> {
    parse_positive(text, Dimension::Length, "must be more than 0; expected a length such as \"0.05 mm\"")
}
