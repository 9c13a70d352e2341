//! Scene files: `phalanx new` writes one as a starting point, `phalanx scene` shows and checks them.

use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum};

use super::output::{
    FileKind, NO_DIRECTORY, picture_target, print, print_diagnostic, print_report, reserve, save_picture,
};
use super::parsers::{PICTURE, picture};
use super::set::{SetArgs, source_files};
use super::{Failure, Status};
use crate::files::{cannot_write, is_forced, replace_file};
use crate::format::Report;
use crate::format::report::list;
use crate::gripper::{Finger, total_mass};
use crate::mechanism::Mechanism;
use crate::mjcf::mujoco_model;
use crate::plot::linkage;
use crate::scene::{self, HandFinger, ObjectMotion, Scene, Side};
use crate::shape::{self, Shape};
use crate::shipped::{SHIPPED_SCENES, ShippedScene, shipped_scene};
use crate::trace::{Model, Simulation};

/// Write a commented scene file as a starting point for your own gripper or mechanism; it runs without changes.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx new my-finger.toml\n  phalanx new my-gripper.toml --kind two-pivot\n  phalanx new --list\n  phalanx new my-lift.toml --from \
                        real/2f85-lift\n  phalanx run my-gripper.toml --open"
)]
pub(crate) struct NewArgs {
    /// File to write; an existing file is replaced only with --force
    #[arg(value_name = "FILE.toml", required_unless_present = "list")]
    file: Option<PathBuf>,

    /// Kind of scene
    #[arg(long, value_enum, default_value_t = NewKind::Finger)]
    kind: NewKind,

    /// Write this shipped scene, by its name in --list
    #[arg(long, value_name = "NAME", conflicts_with = "kind")]
    from: Option<String>,

    /// List all shipped scenes with a line each
    #[arg(long, conflicts_with_all = ["file", "kind", "from"])]
    list: bool,
}

/// File with the JSON Schema of scenes, beside them.
const SCHEMA_FILE: &str = "scene.schema.json";

/// Kind of a scene to begin with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum NewKind {
    /// One finger of a gripper like that of the thesis
    Finger,
    /// Two such fingers and a free object
    Gripper,
    /// A finger with a loop, as a mechanism of bodies and joints
    Mechanism,
    /// A gripper whose fingers have two pivots each on the palm
    TwoPivot,
    /// A hand whose fingers are closed by tendons
    Tendon,
    /// Two parallel jaws
    Jaw,
}

impl NewKind {
    /// The name of its shipped scene, and its content; `None` for a finger.
    fn shipped(self) -> Option<(&'static str, &'static str)> {
        match self {
            NewKind::Finger => None,
            NewKind::Gripper => Some(("gripper/hold", "a gripper of two fingers with a free object")),
            NewKind::Mechanism => Some(("mechanisms/f85-finger", "a mechanism, a finger with a loop")),
            NewKind::TwoPivot => {
                Some(("mechanisms/two-pivot", "a mechanism, a gripper whose fingers have two pivots each"))
            }
            NewKind::Tendon => {
                Some(("mechanisms/tendon-hand", "a mechanism, a hand whose fingers are closed by tendons"))
            }
            NewKind::Jaw => Some(("mechanisms/jaws", "a mechanism, two jaws on sliders")),
        }
    }
}

pub(super) fn run_new(args: &NewArgs) -> Result<Status, Failure> {
    let Some(target) = args.file.as_ref().filter(|_| !args.list) else {
        let lines: Vec<Vec<String>> =
            SHIPPED_SCENES.iter().map(|scene| vec![scene.name().to_string(), scene.title()]).collect();
        return print_report(&list(&lines));
    };
    let (name, content) = match (&args.from, args.kind.shipped()) {
        (Some(name), _) => (Some(&name[..]), None),
        (None, Some((name, content))) => (Some(name), Some(content)),
        (None, None) => (None, Some("one finger of a gripper; the other finger is its mirror image")),
    };
    let unknown = |reason| Failure::bad_input(format!("{reason}; `phalanx new --list` prints all names"));
    let shipped = name.map(shipped_scene).transpose().map_err(unknown)?;
    let text = match shipped {
        Some(shipped) => shipped.standalone_text().map_err(Failure::bad_input)?,
        None => include_str!("new.toml").to_string(),
    };
    let content = match content {
        Some(content) => format!("a commented scene of {content}"),
        None => format!("the shipped scene {}", shipped.map_or("", ShippedScene::name)),
    };
    let path = target.display();
    let bad_input = |reason: &str, advice: &str| Failure::bad_input(format!("cannot write {path}: {reason}; {advice}"));
    let mut file =
        OpenOptions::new().write(true).create_new(!is_forced()).create(true).truncate(true).open(target).map_err(
            |error| match error.kind() {
                ErrorKind::AlreadyExists => {
                    bad_input("a file or directory of that name already exists", "give another name")
                }
                _ => bad_input(&error.to_string(), "give a file in a directory where you may write"),
            },
        )?;
    // The directive of TOML language servers; see src/docs/scene_files.md.
    let text = format!("#:schema ./{SCHEMA_FILE}\n{text}");
    if let Err(error) = file.write_all(text.as_bytes()).and_then(|()| file.sync_all()) {
        let _ = fs::remove_file(target);
        return Err(Failure::incomplete(format!("cannot write {path}: {error}")));
    }
    let figure = match (args.kind, &args.from) {
        (NewKind::Finger, None) => format!("draw its symbols:   phalanx scene show {path} --plot FILE.svg\n"),
        _ => String::new(),
    };
    print(&format!(
        "wrote {path}: {content}\n\
         watch it close:     phalanx run {path} --open        (or --plot FILE.html)\n\
         show all fields:    phalanx scene show {path}\n{figure}\
         keys in an editor:  phalanx schema scene > {}\n",
        target.with_file_name(SCHEMA_FILE).display()
    ))
}

/// Show, check and describe scene files.
#[derive(Debug, Subcommand)]
pub(crate) enum SceneCommand {
    /// Print a scene with all defaults filled in, as a scene file, or draw the linkage of a finger
    #[command(
        after_help = "Examples:\n  phalanx scene show my-gripper.toml\n  phalanx scene show my-gripper.toml --resolved\n  \
                      phalanx scene show my-gripper.toml --plot letters.svg\n  phalanx scene show my-gripper.toml --as-mechanism > my-linkage.toml"
    )]
    Show {
        /// Scene file (TOML)
        scene: PathBuf,

        #[command(flatten)]
        set: SetArgs,

        /// Draw the finger with the symbols of scenes and results (l11, φ22, q21, F22, …) instead of printing the scene
        #[arg(long, value_name = "FILE.svg|png|html", value_parser = picture(PICTURE))]
        plot: Option<PathBuf>,

        /// Print the simulated values in full precision: lengths and masses instead of design and material, initial
        /// angles, and the law of each contact
        #[arg(long, conflicts_with = "plot")]
        resolved: bool,

        /// Print a finger, a gripper or discs as the mechanism that they are: bodies, joints and contacts, as simulated
        #[arg(long, conflicts_with_all = ["plot", "resolved"])]
        as_mechanism: bool,
    },
    /// Check scene files; exit status 2 if one is invalid
    #[command(after_help = "Examples:\n  phalanx scene check my-gripper.toml\n  phalanx scene check scenes/*.toml")]
    Check {
        /// Scene files (TOML)
        #[arg(required = true)]
        scenes: Vec<PathBuf>,

        #[command(flatten)]
        set: SetArgs,
    },
    /// Write the mechanism of a scene as a model for MuJoCo, to run it there; contacts are then MuJoCo's own
    #[command(after_help = "Examples:\n  phalanx scene export my-linkage.toml --mjcf my-linkage.xml")]
    Export {
        /// Scene file (TOML)
        scene: PathBuf,

        #[command(flatten)]
        set: SetArgs,

        /// MJCF file to write; its key frame `start` is the start of the scene
        #[arg(long, value_name = "FILE.xml")]
        mjcf: PathBuf,
    },
}

pub(super) fn run(command: &SceneCommand) -> Result<Status, Failure> {
    match command {
        SceneCommand::Show { scene, set, plot: Some(plot), .. } => draw(scene, set, plot),
        SceneCommand::Show { scene, set, plot: None, resolved, as_mechanism } => {
            let found = set.load_any(scene)?;
            if *as_mechanism {
                let bad_input = |error| Failure::bad_input(format!("{}: {error}", scene.display()));
                return print(&scene::show(&found.as_mechanism().map_err(bad_input)?));
            }
            print(&if *resolved { scene::show(&found) } else { scene::show_written(&found) })
        }
        SceneCommand::Check { scenes, set } => check(scenes, set),
        SceneCommand::Export { scene, set, mjcf } => export(scene, set, mjcf),
    }
}

/// Writes the MuJoCo model of a scene, and prints what it lacks.
fn export(path: &Path, set: &SetArgs, target: &Path) -> Result<Status, Failure> {
    let scene = set.load_any(path)?;
    let output = ("--mjcf", Some(target), FileKind::Model);
    reserve(&[("the scene", &source_files(path))], &[output], NO_DIRECTORY)?;
    let bad_input = |reason: &str| Failure::bad_input(format!("{}: {reason}", path.display()));
    let mechanism = scene.mechanism().map_err(|error| bad_input(&error.to_string()))?;
    let model =
        mujoco_model(&scene.name, &mechanism, scene.duration_s).map_err(|error| bad_input(&error.to_string()))?;
    replace_file(target, |out| out.write_all(model.xml.as_bytes()))
        .map_err(|error| Failure::bad_input(cannot_write(target, error)))?;
    let omissions: String =
        model.omissions.iter().map(|omission| format!("  {}\n", scene::one_line(omission))).collect();
    let lacks = if omissions.is_empty() { "it lacks nothing" } else { "what it lacks:" };
    print(&format!("wrote {}: a model for MuJoCo; {lacks}\n{omissions}", target.display()))
}

/// Prints summaries of the valid scenes and errors of the others.
fn check(files: &[PathBuf], set: &SetArgs) -> Result<Status, Failure> {
    let (mut summaries, mut errors) = (String::new(), Vec::new());
    for file in files {
        match set.load_any(file) {
            Ok(scene) => summaries += &format!("{}: valid: {}\n", file.display(), summarize(&scene)),
            Err(error) => errors.push(error.to_string()),
        }
    }
    print_report(&Report::from(summaries))?;
    if errors.is_empty() {
        return Ok(Status::Done);
    }
    print_diagnostic(&errors.join("\n\n"));
    Ok(Status::BadInput)
}

fn draw(path: &Path, set: &SetArgs, figure: &Path) -> Result<Status, Failure> {
    let scene = set.load_any(path)?;
    let bad_input = |advice: &str| {
        let path = path.display();
        Err(Failure::bad_input(format!("--plot: {path} is {advice} phalanx run {path} --plot FILE.html")))
    };
    match scene.finger_count() {
        0 => return bad_input("a scene without five-bar finger, but the symbols are those of one; view it with"),
        1 => {}
        _ => {
            let advice = "only the scene of one finger can be drawn; give such a scene, or view the gripper with";
            return bad_input(&format!("a gripper, but {advice}"));
        }
    }
    let target = picture_target(Some(figure));
    reserve(&[("the scene", &source_files(path))], &[target], NO_DIRECTORY)?;
    let (figure_name, svg) = (figure.display(), linkage(&scene).svg);
    save_picture(figure, &scene.display_name(), &svg)?;
    print(&format!("wrote {figure_name}: the linkage of {} with its symbols\n", scene.display_name()))
}

fn summarize(scene: &Scene) -> String {
    let summary = match (&scene.mechanism, scene.finger_count()) {
        (Some(mechanism), _) => summarize_mechanism(mechanism),
        (None, 1) => {
            let object = scene.object().map(|disc| format!("object {}", format_size(&disc.shape)));
            let object = object.unwrap_or("no object".to_string());
            let finger = scene.finger();
            format!("{}; {object}; {}", format_lengths(&finger.linkage), format_start(finger))
        }
        (None, _) => summarize_gripper(scene),
    };
    let unsupported = scene.mechanism.as_ref().and_then(|_| Simulation::new(scene, Model::Analytic).err());
    let unsupported = unsupported.map_or_else(String::new, |error| format!("; not for the analytic model: {error}"));
    format!("{summary}; {:.1} ms{unsupported}", scene.duration_s * 1e3)
}

fn summarize_mechanism(mechanism: &Mechanism) -> String {
    let count = |count: usize, one: &str, several: &str| format!("{count} {}", if count == 1 { one } else { several });
    let pulls = mechanism.tendons.iter().filter(|tendon| tendon.actuator.is_some());
    let actuators = mechanism.actuators.len() + pulls.count();
    let moving = mechanism.bodies.iter().flat_map(|body| body.moves_by_forces()).filter(|moves| *moves).count();
    let freedoms = moving.saturating_sub(mechanism.constraint_count());
    [
        count(mechanism.bodies.len(), "body", "bodies"),
        count(mechanism.joints.len(), "joint", "joints"),
        count(freedoms, "degree of freedom", "degrees of freedom"),
        count(actuators, "actuator", "actuators"),
        count(mechanism.point_contacts().len(), "contact", "contacts"),
    ]
    .join(", ")
}

fn summarize_gripper(scene: &Scene) -> String {
    let describe_finger = |side: Side| {
        let finger = scene.hand.finger(side);
        format!("{}; {}", format_lengths(&finger.linkage), format_start(finger))
    };
    let [right, left] = Side::BOTH.map(describe_finger);
    let fingers = if right == left { format!("two fingers: {right}") } else { format!("right: {right}; left: {left}") };
    let disc = scene.hand.grasped();
    let object = match disc.motion {
        ObjectMotion::Free { mass_kg, .. } => format!("free, {:.2} g", mass_kg * 1e3),
        ObjectMotion::Fixed => "fixed".to_string(),
    };
    let [x, y] = disc.centre_m.map(|coordinate| coordinate * 1e3);
    let open = if scene.hand.palm.is_some() { "" } else { " and open" };
    let mut parts = vec![
        format!("palm {:.2} mm wide{open}", scene.hand.palm_width_m * 1e3),
        format!("object {} at ({x:.2}, {y:.2}) mm, {object}", format_size(&disc.shape)),
    ];
    parts.extend(scene.hand.table.map(|table| format!("table at {:.2} mm", table.level_m * 1e3)));
    parts.extend(scene.hand.differential.as_ref().map(|_| "differential".to_string()));
    format!("{fingers}; {}", parts.join("; "))
}

fn format_start(HandFinger { initial, .. }: &HandFinger) -> String {
    format!("starts at q11 {:.2}°, q21 {:.2}°", initial.q11_rad.to_degrees(), initial.q21_rad.to_degrees())
}

fn format_size(shape: &Shape) -> String {
    let sizes = shape::dimensions(shape).map(|(name, size_m)| format!("{:.1} mm in {name}", size_m * 1e3));
    sizes.collect::<Vec<_>>().join(" and ")
}

fn format_lengths(finger: &Finger) -> String {
    let l = &finger.lengths;
    let [l11, l12, l21, l22, t22] = [l.l11_m, l.l12_m, l.l21_m, l.l22_m, l.t22_m].map(|length| length * 1e3);
    let (phi22, mass_g) = (l.phi22_rad.to_degrees(), total_mass(&finger.bodies) * 1e3);
    format!("l11 {l11:.2}, l12 {l12:.2}, l21 {l21:.2}, l22 {l22:.2}, t22 {t22:.2} mm, phi22 {phi22:.1}°; {mass_g:.2} g")
}
