//! `phalanx scene`: showing and checking scene files.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Subcommand;

pub use super::command_output::CommandOutput;
use super::output::{print, print_diagnostic, print_report};
use super::set::SetArgs;
use super::{Failure, Status, scene_figure};
use crate::format::Report;
use crate::gripper::Finger;
use crate::gripper::total_mass;
use crate::scene::keywords::SceneKind;
use crate::scene::{self, DiscMotion, DrivenFinger, Scene, Side};
use crate::shape::{self, Shape};

/// Show, check and describe scene files.
#[derive(Clone, Debug, Subcommand)]
pub enum SceneCommand {
    /// Print a scene with all defaults filled in, as a scene file, or draw its linkage
    #[command(
        after_help = "Examples:\n  phalanx scene show my-gripper.toml\n  phalanx scene show my-gripper.toml --resolved\n  \
                      phalanx scene show my-gripper.toml --figure letters.svg"
    )]
    Show {
        /// Scene file (TOML)
        scene: PathBuf,

        #[command(flatten)]
        set: SetArgs,

        /// Draw the finger with the symbols of scenes and results (l11, φ22, q21, F22, …) instead of printing the scene
        #[arg(long, value_name = "FILE.svg")]
        figure: Option<PathBuf>,

        /// Print the simulated values in full precision: lengths and masses instead of design and material, initial
        /// angles, and the law of each contact
        #[arg(long, conflicts_with = "figure")]
        resolved: bool,
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
    /// Print the JSON Schema of scene files, for editors
    #[command(after_help = "Examples:\n  phalanx scene schema > scene.schema.json")]
    Schema,
}

/// Runs a command and prints its output.
pub fn run(command: &SceneCommand) -> Result<Status, Failure> {
    let output = execute(command);
    match command {
        // Only the summary lines of `check` are wrapped; the other outputs are files.
        SceneCommand::Check { .. } => print_report(&Report::from(output.stdout.as_str())),
        _ => print(&output.stdout),
    }?;
    if !output.stderr.is_empty() {
        print_diagnostic(output.stderr.trim_end());
    }
    Ok(if output.is_valid { Status::Done } else { Status::BadInput })
}

/// Returns the output of a command without printing it.
pub fn execute(command: &SceneCommand) -> CommandOutput {
    match command {
        SceneCommand::Schema => CommandOutput { stdout: scene::schema(), is_valid: true, ..CommandOutput::default() },
        SceneCommand::Show { scene, set, figure: Some(figure), .. } => scene_figure::execute(scene, set, figure),
        SceneCommand::Show { scene, set, figure: None, resolved } => match set.load_any(scene) {
            Ok(scene) => {
                let stdout = if *resolved { scene::show(&scene) } else { scene::show_written(&scene) };
                CommandOutput { stdout, is_valid: true, ..CommandOutput::default() }
            }
            Err(error) => CommandOutput { stderr: format!("{error}\n"), ..CommandOutput::default() },
        },
        SceneCommand::Check { scenes, set } => check(scenes, set),
    }
}

fn check(files: &[PathBuf], set: &SetArgs) -> CommandOutput {
    let mut output = CommandOutput { is_valid: true, ..CommandOutput::default() };
    for file in files {
        match set.load_any(file) {
            Ok(scene) => {
                let _ = writeln!(output.stdout, "{}: valid: {}", file.display(), summarize(&scene));
            }
            Err(error) => {
                output.is_valid = false;
                let _ = writeln!(output.stderr, "{error}\n");
            }
        }
    }
    output
}

/// Summarizes a scene in one line.
fn summarize(scene: &Scene) -> String {
    match scene.kind() {
        SceneKind::Finger => summarize_finger(scene),
        SceneKind::Bodies => summarize_discs(scene),
        SceneKind::Gripper => summarize_gripper(scene),
    }
}

fn summarize_discs(scene: &Scene) -> String {
    let names_with = |is_kind: fn(&DiscMotion) -> bool| {
        let names = scene.system.discs.iter().filter(|disc| is_kind(&disc.motion)).map(|disc| disc.name.as_str());
        names.collect::<Vec<_>>().join(", ")
    };
    let kinds = [
        ("free", names_with(|motion| matches!(motion, DiscMotion::Free { .. }))),
        ("driven", names_with(|motion| matches!(motion, DiscMotion::Driven { .. }))),
        ("fixed", names_with(|motion| matches!(motion, DiscMotion::Fixed))),
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

fn summarize_gripper(scene: &Scene) -> String {
    let describe_finger = |side: Side| {
        let DrivenFinger { linkage, initial, .. } = scene.system.finger(side);
        let starts = format!("q11 {:.2}°, q21 {:.2}°", initial.q11_rad.to_degrees(), initial.q21_rad.to_degrees());
        format!("{}; starts at {starts}", format_lengths(linkage))
    };
    let [right, left] = Side::BOTH.map(describe_finger);
    let fingers = if right == left { format!("two fingers: {right}") } else { format!("right: {right}; left: {left}") };
    let disc = scene.system.grasped();
    let object = match disc.motion {
        DiscMotion::Free { mass_kg, .. } => format!("free, {:.2} g", mass_kg * 1e3),
        DiscMotion::Fixed | DiscMotion::Driven { .. } => "fixed".to_string(),
    };
    let [x, y] = disc.centre_m.map(|coordinate| coordinate * 1e3);
    let mut parts = vec![
        format!(
            "palm {:.2} mm wide{}",
            scene.system.palm_width_m * 1e3,
            if scene.system.palm.is_some() { "" } else { " and open" }
        ),
        format!("object {} at ({x:.2}, {y:.2}) mm, {object}", format_size(&disc.shape)),
    ];
    parts.extend(scene.system.table.map(|table| format!("table at {:.2} mm", table.level_m * 1e3)));
    parts.extend(scene.system.differential.as_ref().map(|_| "differential".to_string()));
    format!("{fingers}; {}; {:.1} ms", parts.join("; "), scene.duration_s * 1e3)
}

/// Formats the dimensions of a shape.
fn format_size(shape: &Shape) -> String {
    let sizes = shape::dimensions(shape).map(|(name, size_m)| format!("{:.1} mm in {name}", size_m * 1e3));
    sizes.collect::<Vec<_>>().join(" and ")
}

fn summarize_finger(scene: &Scene) -> String {
    let object = match scene.object() {
        Some(disc) => format!("object {}", format_size(&disc.shape)),
        None => "no object".to_string(),
    };
    format!(
        "{}; {object}; starts at q11 {:.2}°, q21 {:.2}°; {:.1} ms",
        format_lengths(&scene.finger().linkage),
        scene.finger().initial.q11_rad.to_degrees(),
        scene.finger().initial.q21_rad.to_degrees(),
        scene.duration_s * 1e3,
    )
}

/// Formats the lengths and the mass of a finger.
fn format_lengths(finger: &Finger) -> String {
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
