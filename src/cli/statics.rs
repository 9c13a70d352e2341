//! Commands without a simulation of their own: `phalanx size`, which sizes the spring and motor of a finger, and `phalanx
//! statics`, the statics of the grasp of a scene.

use std::path::PathBuf;

use clap::Args;

use super::output::{NO_DIRECTORY, OutputArgs, picture_target, print_result, reserve, save_picture};
use super::parsers::{PICTURE, number, picture, positive, quantity, rule};
use super::progress::Interrupt;
use super::set::{SetArgs, source_files};
use super::{Failure, Status};
use crate::format::ToReport;
use crate::grasp::finger::{GraspOverrides, GraspStudyError, grasp};
use crate::grasp::gripper::{GripperGraspError, GripperGraspRequest, PostureRequest, gripper_grasp};
use crate::grasp::mechanism::{MechanismGraspError, MechanismGraspRequest, mechanism_grasp};
use crate::plot;
use crate::report::statics::{GripperStaticsReport, MechanismStaticsReport, StaticsReport};
use crate::report::studies::sizing_csv;
use crate::scene::{self, Scene};
use crate::sizing::Rule;
use crate::statics::StaticsError;
use crate::study::posture::{END_OF_RUN, parse_direction_count, parse_posture, with_options};
use crate::study::size::{SizingOptions, size_finger};
use crate::units::Dimension;

/// Size the spring and motor of a finger from a test trajectory.
///
/// The motor link moves from the initial posture to the closed finger in 10 ms. The spring must keep the finger
/// straight until the proximal phalanx contacts the object; the motor provides the RMS torque. The torques in the scene
/// are shown for comparison.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx size scenes/experiment-95.toml\n  phalanx size scenes/experiment-95.toml --closing-time \"8 \
                  ms\" --json\n  phalanx size my-gripper.toml --out sizing\n\n--out writes size.txt, .json, .csv (the profile), trajectory.svg, springs.svg and spring-types.svg. A scene with sizing = \"rigid\" (or \"whole\") at \
                  its top uses these torques automatically. Exit status: 0 done; 2 bad input, or a finger that cannot be sized."
)]
pub(crate) struct SizeArgs {
    /// Finger scene file (TOML)
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Time span over which the motor torque is averaged
    #[arg(long, value_parser = rule(), default_value = "rigid")]
    rule: Rule,

    /// Duration of the test trajectory with its unit [default: 10 ms]
    #[arg(long, value_name = "TIME", value_parser = positive(Dimension::Time, "a time such as \"10 ms\""))]
    closing_time: Option<f64>,

    /// Deflection of the torsional spring, which is compared with the constant one, when the finger is straight
    /// [default: the preload of the scene's torsional spring, or 90 deg]
    #[arg(long, value_name = "ANGLE", value_parser = positive(Dimension::Angle, "an angle such as \"90 deg\""))]
    preload: Option<f64>,

    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run_size(args: &SizeArgs) -> Result<Status, Failure> {
    let scene = scene::parse_layers_as(&scene::load_layers(&args.scene)?, &args.set.set, scene::parse)?;
    let files = ["size.txt", "size.json", "size.csv", "trajectory.svg", "springs.svg", "spring-types.svg"];
    let directory = reserve(&[("the scene", &source_files(&args.scene))], &[], (args.output.out.as_deref(), &files))?;
    let defaults = SizingOptions::default();
    let options = SizingOptions {
        rule: args.rule,
        closing_s: args.closing_time.unwrap_or(defaults.closing_s),
        preload_rad: args.preload,
    };
    let sizing = size_finger(&scene, options).map_err(Failure::bad_input)?;
    let profile = &sizing.profile;
    directory.write(files, || {
        let [trajectory, springs, spring_types] = plot::sizing(&scene.name, profile);
        [sizing.report().to_string(), sizing.json(), sizing_csv(profile), trajectory, springs, spring_types]
    })?;
    print_result(&sizing, args.output.json)
}

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
///
/// For a mechanism, the posture is the one at the end of its run, or at --at; the results are those of a gripper, for the
/// body named by --object and any contacts. The body named by --base is accelerated; actuators that move it are blocked.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx statics scenes/experiment-95.toml\n  phalanx statics scenes/experiment-95.toml \
                  --mu-static 0,0.4,0.8 --plot grasp.svg\n  phalanx statics my-finger.toml --motor \"500 N*mm\" --json\n  phalanx statics \
                  scenes/gripper/cycle.toml --at \"200 ms\" --plot polar.svg\n  phalanx statics scenes/gripper/design-95.toml --posture \
                  geometric --mu-static 0.2,0.4 --every \"30 deg\"\n  phalanx statics scenes/real/2f85-pinch.toml --object object\n  phalanx statics scenes/gripper/design-95.toml --posture \"q11=2.09 \
                  deg, q21=65.02 deg\"\n\nExit status: 0 done, whatever the result; 2 bad input, such as a finger that does not \
                  reach its object; 3 form closure of a finger or the balance of forces could not be decided, a run could not be \
                  completed, or a file could not be written."
)]
pub(crate) struct StaticsArgs {
    /// Scene file (TOML) of a finger with an object, of a gripper, or of a mechanism
    scene: PathBuf,

    #[command(flatten)]
    set: SetArgs,

    /// Friction coefficients of all contacts, comma-separated [default: 0 and those of the scene; for a gripper only
    /// those of the scene, which always determine its posture]
    #[arg(long, value_name = "MU,...", value_delimiter = ',', value_parser = number(|mu| (0.0..=f64::MAX).contains(mu), FRICTION))]
    mu_static: Vec<f64>,

    /// Motor torque with its unit, such as "500 N*mm" [default: the torque at the end of the scene]
    #[arg(long, value_name = "TORQUE", value_parser = quantity(Dimension::Torque))]
    motor: Option<f64>,

    /// Draw the grasp to this file, with the forces for the last friction coefficient, or for a gripper with its
    /// admissible accelerations; an existing file is replaced only when the new one is complete
    #[arg(long, value_name = "FILE.svg|png|html", value_parser = picture(PICTURE))]
    plot: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    gripper: GripperArgs,
}

/// Arguments for grippers and mechanisms only.
#[derive(Clone, Debug, Args)]
pub(crate) struct GripperArgs {
    /// Posture: "run" is the posture of a run of the scene; "geometric" has all phalanges on the object at its position
    /// in the scene; or angles with units, such as "q11=2 deg, q21=65 deg" for both fingers, q11_r, q21_r, q11_l, q21_l
    /// for one finger, and x and y for the object's centre
    #[arg(long, value_name = "POSTURE", value_parser = parse_posture, default_value = "run", help_heading = "For a gripper")]
    posture: PostureRequest,

    /// Time of the run, with its unit [default: its end, or when the fingers release the object]
    #[arg(long, value_name = "TIME", value_parser = positive(Dimension::Time, "a time such as \"20 ms\""), help_heading = "For a gripper or a mechanism")]
    at: Option<f64>,

    /// Largest gap at which a surface counts as in contact [default: 0.05 mm for given angles; for a run only surfaces
    /// with a contact force]
    #[arg(long, value_name = "LENGTH", value_parser = positive(Dimension::Length, "a length such as \"0.05 mm\""), help_heading = "For a gripper or a mechanism")]
    within: Option<f64>,

    /// Angle between neighbouring directions of acceleration, with its unit; must divide a full turn
    #[arg(long, value_name = "ANGLE", value_parser = parse_direction_count, default_value = "15 deg", help_heading = "For a gripper or a mechanism")]
    every: usize,

    /// The held body of a mechanism [default: the only body without joints that has contacts]
    #[arg(long, value_name = "BODY", help_heading = "For a mechanism")]
    object: Option<String>,

    /// The body of a mechanism that is accelerated, or "ground" [default: the last body that carries all bodies of the hand
    /// that can touch the object, such as the palm of a hand on a lift]
    #[arg(long, value_name = "BODY", help_heading = "For a mechanism")]
    base: Option<String>,
}

/// Accepted values in messages.
const FRICTION: &str = "one or more comma-separated numbers, each 0 or more, such as 0,0.4,0.8";

/// Largest angle between neighbouring directions in a picture, degrees.
const MAX_PICTURE_SPACING_DEG: f64 = 1.0;

impl GripperArgs {
    /// Returns the first of these flags that differs from its default; such a flag is an error for other kinds of
    /// scene.
    fn first_given_flag(&self) -> Option<&'static str> {
        let flags = [
            (self.posture != END_OF_RUN, "--posture"),
            (self.at.is_some(), "--at"),
            (self.within.is_some(), "--within"),
            (self.every != 24, "--every"),
            (self.object.is_some(), "--object"),
            (self.base.is_some(), "--base"),
        ];
        flags.into_iter().find(|(given, _)| *given).map(|(_, flag)| flag)
    }
}

pub(super) fn run_statics(args: &StaticsArgs) -> Result<Status, Failure> {
    let svg = picture_target(args.plot.as_deref());
    reserve(&[("the scene", &source_files(&args.scene))], &[svg], NO_DIRECTORY)?;
    let scene = args.set.load_any(&args.scene)?;
    match scene.finger_count() {
        0 => run_mechanism(args, &scene),
        1 => run_finger(args, &scene),
        _ => run_gripper(args, &scene),
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
    let grasp =
        grasp(scene, &overrides).map_err(|error| match &error {
            GraspStudyError::Statics {
                error:
                    StaticsError::Undecided { .. }
                    | StaticsError::NeitherMotionNorMultipliers
                    | StaticsError::Program { .. },
                ..
            } => Failure::incomplete(error),
            _ => Failure::bad_input(error),
        })?;
    let svg = args.save_picture(|| plot::grasp(scene, &grasp, plot::PictureFormat::Standalone))?;
    print_result(&StaticsReport { svg, ..StaticsReport::new(&grasp) }, args.json)
}

fn run_gripper(args: &StaticsArgs, scene: &Scene) -> Result<Status, Failure> {
    let GripperArgs { posture, at, within, every, .. } = &args.gripper;
    let interrupt = Interrupt::listen()?;
    if args.gripper.object.is_some() {
        return Err(Failure::bad_input("--object is for mechanisms; a gripper has one object: remove the flag"));
    }
    if args.gripper.base.is_some() {
        return Err(Failure::bad_input("--base is for mechanisms; the base of a gripper is its palm: remove the flag"));
    }
    let refinement = refinement(args.plot.is_some(), *every);
    let request = GripperGraspRequest {
        posture: with_options(*posture, *at, *within).map_err(Failure::bad_input)?,
        mu_static: args.mu_static.clone(),
        motor_n_m: args.motor,
        directions: every * refinement,
    };
    let grasp = gripper_grasp(scene, &request, &|| interrupt.keep_running()).map_err(|error| {
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
    print_result(&report, args.json)
}

fn run_mechanism(args: &StaticsArgs, scene: &Scene) -> Result<Status, Failure> {
    let GripperArgs { posture, at, within, every, .. } = &args.gripper;
    if *posture != END_OF_RUN || args.motor.is_some() {
        let flag = if args.motor.is_some() { "--motor" } else { "--posture" };
        return Err(Failure::bad_input(format!(
            "{flag} is for fingers and grippers, but {} is a mechanism: remove the flag; --at selects the time of its run, and \
             --set changes its actuators",
            args.scene.display()
        )));
    }
    let interrupt = Interrupt::listen()?;
    let refinement = refinement(args.plot.is_some(), *every);
    let request = MechanismGraspRequest {
        at_s: *at,
        within_m: *within,
        object: args.gripper.object.clone(),
        base: args.gripper.base.clone(),
        mu_static: args.mu_static.clone(),
        directions: every * refinement,
    };
    let grasp = mechanism_grasp(scene, &request, &|| interrupt.keep_running()).map_err(|error| {
        match (&error, interrupt.signal()) {
            (MechanismGraspError::Stopped, Some(signal)) => Failure::incomplete(format!("interrupted by {signal}")),
            (
                MechanismGraspError::Run { .. } | MechanismGraspError::Stopped | MechanismGraspError::Statics { .. },
                _,
            ) => Failure::incomplete(error),
            _ => Failure::bad_input(error),
        }
    })?;
    let svg = args.save_picture(|| plot::mechanism_balance(scene, &grasp, plot::PictureFormat::Standalone))?;
    let mut report = MechanismStaticsReport::new(&grasp, refinement);
    report.svg = svg;
    print_result(&report, args.json)
}

/// Directions of a picture per direction of the table.
fn refinement(has_picture: bool, every: usize) -> usize {
    match has_picture {
        true => (360.0 / MAX_PICTURE_SPACING_DEG / every as f64).ceil().max(1.0) as usize,
        false => 1,
    }
}

impl StaticsArgs {
    /// Writes the picture if it was requested, and returns its path.
    fn save_picture(&self, draw: impl FnOnce() -> String) -> Result<Option<String>, Failure> {
        let Some(path) = &self.plot else { return Ok(None) };
        save_picture(path, &self.scene.display().to_string(), &draw())?;
        Ok(Some(path.display().to_string()))
    }
}
