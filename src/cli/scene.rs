//! `phalanx scene`: showing and checking scene files.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Subcommand;

pub use super::answer::Answer;
use super::output::{complain, print, show};
use super::set::SetArgs;
use super::{Failure, Status, scene_figure};
use crate::gripper::Finger;
use crate::gripper::total_mass;
use crate::scene::words::SceneKind;
use crate::scene::{self, DiscMotion, DrivenFinger, Scene, Side};
use crate::shape::{self, Shape};
use crate::wording::Report;

/// Show, check and describe scene files.
#[derive(Clone, Debug, Subcommand)]
pub enum SceneCommand {
    /// Print a scene as it was written with every default filled in, as a scene file; or draw its linkage
    #[command(
        after_help = "Examples:\n  phalanx scene show my-gripper.toml\n  phalanx scene show my-gripper.toml --resolved\n  \
                      phalanx scene show my-gripper.toml --figure letters.svg"
    )]
    Show {
        /// Scene file (TOML)
        scene: PathBuf,

        #[command(flatten)]
        set: SetArgs,

        /// Instead of printing it: draw the finger with the letters of scenes and results on it (l11, φ22, q21, F22, …)
        #[arg(long, value_name = "FILE.svg")]
        figure: Option<PathBuf>,

        /// Print what is simulated instead, in full precision: lengths and masses in place of a design and a material, angles
        /// of the start, the law of each contact
        #[arg(long, conflicts_with = "figure")]
        resolved: bool,
    },
    /// Check scene files; exit status 2 if one is wrong
    #[command(after_help = "Examples:\n  phalanx scene check my-gripper.toml\n  phalanx scene check scenes/*.toml")]
    Check {
        /// Scene files (TOML)
        #[arg(required = true)]
        scenes: Vec<PathBuf>,

        #[command(flatten)]
        set: SetArgs,
    },
    /// Print the JSON Schema of scene files, for editors
    #[command(after_help = "Examples:\n  phalanx scene schema > scene.schema.json")]
    Schema,
}

/// Runs a command and prints its answer.
pub fn run(command: &SceneCommand) -> Result<Status, Failure> {
    let answer = answer(command);
    match command {
        // Sentences for people; the others are documents.
        SceneCommand::Check { .. } => show(&Report::from(answer.stdout.as_str())),
        _ => print(&answer.stdout),
    }?;
    if !answer.stderr.is_empty() {
        complain(answer.stderr.trim_end());
    }
    Ok(if answer.good { Status::Done } else { Status::BadInput })
}

/// The answer to a command.
pub fn answer(command: &SceneCommand) -> Answer {
    match command {
        SceneCommand::Schema => Answer { stdout: scene::schema(), good: true, ..Answer::default() },
        SceneCommand::Show { scene, set, figure: Some(figure), .. } => scene_figure::answer(scene, set, figure),
        SceneCommand::Show { scene, set, figure: None, resolved } => match set.load_any(scene) {
            Ok(scene) => {
                let stdout = if *resolved { scene::show(&scene) } else { scene::show_written(&scene) };
                Answer { stdout, good: true, ..Answer::default() }
            }
            Err(error) => Answer { stderr: format!("{error}\n"), ..Answer::default() },
        },
        SceneCommand::Check { scenes, set } => check(scenes, set),
    }
}

fn check(files: &[PathBuf], set: &SetArgs) -> Answer {
    let mut answer = Answer { good: true, ..Answer::default() };
    for file in files {
        match set.load_any(file) {
            Ok(scene) => {
                let _ = writeln!(answer.stdout, "{}: good: {}", file.display(), summary(&scene));
            }
            Err(error) => {
                answer.good = false;
                let _ = writeln!(answer.stderr, "{error}\n");
            }
        }
    }
    answer
}

/// One line on what a scene holds.
fn summary(scene: &Scene) -> String {
    match scene.kind() {
        SceneKind::Finger => finger(scene),
        SceneKind::Bodies => discs(scene),
        SceneKind::Gripper => gripper(scene),
    }
}

fn discs(scene: &Scene) -> String {
    let of = |wanted: fn(&DiscMotion) -> bool| {
        let names = scene.system.discs.iter().filter(|disc| wanted(&disc.motion)).map(|disc| disc.name.as_str());
        names.collect::<Vec<_>>().join(", ")
    };
    let kinds = [
        ("free", of(|motion| matches!(motion, DiscMotion::Free { .. }))),
        ("driven", of(|motion| matches!(motion, DiscMotion::Driven { .. }))),
        ("fixed", of(|motion| matches!(motion, DiscMotion::Fixed))),
    ];
    let mut parts: Vec<String> =
        kinds.iter().filter(|(_, names)| !names.is_empty()).map(|(kind, names)| format!("{kind} {names}")).collect();
    if let Some(plane) = scene.system.palm {
        parts.push(format!("half plane at {:.2} mm", plane.level_m * 1e3));
    }
    let pairs = scene.system.pairs().len();
    let plural = if pairs == 1 { "" } else { "s" };
    format!("discs: {}; {pairs} pair{plural}; {:.1} ms", parts.join("; "), scene.duration_s * 1e3)
}

fn gripper(scene: &Scene) -> String {
    let links = |side: Side| {
        let DrivenFinger { linkage, initial, .. } = scene.system.finger(side);
        let starts = format!("q11 {:.2}°, q21 {:.2}°", initial.q11_rad.to_degrees(), initial.q21_rad.to_degrees());
        format!("{}; starts at {starts}", lengths(linkage))
    };
    let [right, left] = Side::BOTH.map(links);
    let fingers = if right == left { format!("two fingers: {right}") } else { format!("right: {right}; left: {left}") };
    let disc = scene.system.grasped();
    let object = match disc.motion {
        DiscMotion::Free { mass_kg, .. } => format!("free, {:.2} g", mass_kg * 1e3),
        DiscMotion::Fixed | DiscMotion::Driven { .. } => "fixed".to_string(),
    };
    let [x, y] = disc.centre_m.map(|place| place * 1e3);
    let mut parts = vec![
        format!(
            "palm {:.2} mm wide{}",
            scene.system.palm_width_m * 1e3,
            if scene.system.palm.is_some() { "" } else { " and open" }
        ),
        format!("object {} at ({x:.2}, {y:.2}) mm, {object}", size(&disc.shape)),
    ];
    parts.extend(scene.system.table.map(|table| format!("table at {:.2} mm", table.level_m * 1e3)));
    parts.extend(scene.system.differential.as_ref().map(|_| "differential".to_string()));
    format!("{fingers}; {}; {:.1} ms", parts.join("; "), scene.duration_s * 1e3)
}

/// How large a shape is.
fn size(shape: &Shape) -> String {
    let sizes = shape::sizes(shape).map(|(name, size_m)| format!("{:.1} mm in {name}", size_m * 1e3));
    sizes.collect::<Vec<_>>().join(" and ")
}

fn finger(scene: &Scene) -> String {
    let object = match scene.object() {
        Some(disc) => format!("object {}", size(&disc.shape)),
        None => "no object".to_string(),
    };
    format!(
        "{}; {object}; starts at q11 {:.2}°, q21 {:.2}°; {:.1} ms",
        lengths(&scene.finger().linkage),
        scene.finger().initial.q11_rad.to_degrees(),
        scene.finger().initial.q21_rad.to_degrees(),
        scene.duration_s * 1e3,
    )
}

/// Lengths and mass of a finger.
fn lengths(finger: &Finger) -> String {
    let l = &finger.lengths;
    format!(
        "l11 {:.2}, l12 {:.2}, l21 {:.2}, l22 {:.2}, t22 {:.2} mm, phi22 {:.1}°; {:.2} g",
        l.l11_m * 1e3,
        l.l12_m * 1e3,
        l.l21_m * 1e3,
        l.l22_m * 1e3,
        l.t22_m * 1e3,
        l.phi22_rad.to_degrees(),
        total_mass(&finger.bodies) * 1e3,
    )
}
