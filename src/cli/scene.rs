//! `phalanx scene`: showing and checking scene files.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Subcommand;

use super::output::{print, print_diagnostic, print_report};
use super::set::{SetArgs, source_files};
use super::targets::{FileKind, NO_DIRECTORY, TargetKind, reserve};
use super::{Failure, Status};
use crate::files::replace_file;
use crate::format::Report;
use crate::gripper::{Finger, total_mass};
use crate::plot::linkage;
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

/// Output of a command.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CommandOutput {
    pub stdout: String,
    pub stderr: String,
    /// Whether all input was valid.
    pub is_valid: bool,
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
    let result = match command {
        SceneCommand::Schema => Ok(scene::schema()),
        SceneCommand::Show { scene, set, figure: Some(figure), .. } => draw(scene, set, figure),
        SceneCommand::Show { scene, set, figure: None, resolved } => {
            let show = if *resolved { scene::show } else { scene::show_written };
            set.load_any(scene).map(|scene| show(&scene)).map_err(Failure::from)
        }
        SceneCommand::Check { scenes, set } => return check(scenes, set),
    };
    match result {
        Ok(stdout) => CommandOutput { stdout, is_valid: true, ..CommandOutput::default() },
        Err(Failure { message, .. }) => CommandOutput { stderr: format!("{message}\n"), ..CommandOutput::default() },
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

/// Draws the linkage of a finger with its symbols.
fn draw(path: &Path, set: &SetArgs, figure: &Path) -> Result<String, Failure> {
    let scene = set.load_any(path)?;
    let advice = match scene.kind() {
        SceneKind::Finger => None,
        SceneKind::Gripper => Some(
            "a gripper, but only the scene of one finger can be drawn; give such a scene, or view the gripper with",
        ),
        SceneKind::Bodies => {
            Some("a scene of discs, which has no linkage; give the scene of a finger, or view the discs with")
        }
    };
    if let Some(advice) = advice {
        let path = path.display();
        return Err(Failure::bad_input(format!("--figure: {path} is {advice} phalanx run {path} --html FILE.html")));
    }
    let target = ("--figure", Some(figure), TargetKind::File(FileKind::Picture));
    reserve(&[("the scene", &source_files(path))], &[target], NO_DIRECTORY)?;
    let (figure_name, svg) = (figure.display(), linkage(&scene).svg);
    replace_file(figure, |out| out.write_all(svg.as_bytes())).map_err(|error| {
        Failure::bad_input(format!(
            "cannot write {figure_name}: {error}; give a file in a directory where you may write"
        ))
    })?;
    Ok(format!("wrote {figure_name}: the linkage of {} with its symbols\n", scene.name))
}

/// Summarizes a scene in one line.
fn summarize(scene: &Scene) -> String {
    let summary = match scene.kind() {
        SceneKind::Finger => {
            let object = scene.object().map(|disc| format!("object {}", format_size(&disc.shape)));
            let object = object.unwrap_or("no object".to_string());
            let finger = scene.finger();
            format!("{}; {object}; {}", format_lengths(&finger.linkage), format_start(finger))
        }
        SceneKind::Bodies => summarize_discs(scene),
        SceneKind::Gripper => summarize_gripper(scene),
    };
    format!("{summary}; {:.1} ms", scene.duration_s * 1e3)
}

fn summarize_discs(scene: &Scene) -> String {
    let motion = |motion: &DiscMotion| match motion {
        DiscMotion::Free { .. } => "free",
        DiscMotion::Driven { .. } => "driven",
        DiscMotion::Fixed => "fixed",
    };
    let names_with = |kind: &&str| {
        let discs = scene.system.discs.iter().filter(|disc| motion(&disc.motion) == *kind);
        let names: Vec<&str> = discs.map(|disc| disc.name.as_str()).collect();
        (!names.is_empty()).then(|| format!("{kind} {}", names.join(", ")))
    };
    let mut parts: Vec<String> = ["free", "driven", "fixed"].iter().filter_map(names_with).collect();
    parts.extend(scene.system.palm.map(|plane| format!("half plane at {:.2} mm", plane.level_m * 1e3)));
    let pairs = scene.system.pairs().len();
    format!("discs: {}; {pairs} pair{}", parts.join("; "), if pairs == 1 { "" } else { "s" })
}

fn summarize_gripper(scene: &Scene) -> String {
    let describe_finger = |side: Side| {
        let finger = scene.system.finger(side);
        format!("{}; {}", format_lengths(&finger.linkage), format_start(finger))
    };
    let [right, left] = Side::BOTH.map(describe_finger);
    let fingers = if right == left { format!("two fingers: {right}") } else { format!("right: {right}; left: {left}") };
    let disc = scene.system.grasped();
    let object = match disc.motion {
        DiscMotion::Free { mass_kg, .. } => format!("free, {:.2} g", mass_kg * 1e3),
        DiscMotion::Fixed | DiscMotion::Driven { .. } => "fixed".to_string(),
    };
    let [x, y] = disc.centre_m.map(|coordinate| coordinate * 1e3);
    let open = if scene.system.palm.is_some() { "" } else { " and open" };
    let mut parts = vec![
        format!("palm {:.2} mm wide{open}", scene.system.palm_width_m * 1e3),
        format!("object {} at ({x:.2}, {y:.2}) mm, {object}", format_size(&disc.shape)),
    ];
    parts.extend(scene.system.table.map(|table| format!("table at {:.2} mm", table.level_m * 1e3)));
    parts.extend(scene.system.differential.as_ref().map(|_| "differential".to_string()));
    format!("{fingers}; {}", parts.join("; "))
}

/// Formats the initial angles of a finger.
fn format_start(DrivenFinger { initial, .. }: &DrivenFinger) -> String {
    format!("starts at q11 {:.2}°, q21 {:.2}°", initial.q11_rad.to_degrees(), initial.q21_rad.to_degrees())
}

/// Formats the dimensions of a shape.
fn format_size(shape: &Shape) -> String {
    let sizes = shape::dimensions(shape).map(|(name, size_m)| format!("{:.1} mm in {name}", size_m * 1e3));
    sizes.collect::<Vec<_>>().join(" and ")
}

/// Formats the lengths and the mass of a finger.
fn format_lengths(finger: &Finger) -> String {
    let l = &finger.lengths;
    let [l11, l12, l21, l22, t22] = [l.l11_m, l.l12_m, l.l21_m, l.l22_m, l.t22_m].map(|length| length * 1e3);
    let (phi22, mass_g) = (l.phi22_rad.to_degrees(), total_mass(&finger.bodies) * 1e3);
    format!("l11 {l11:.2}, l12 {l12:.2}, l21 {l21:.2}, l22 {l22:.2}, t22 {t22:.2} mm, phi22 {phi22:.1}°; {mass_g:.2} g")
}
