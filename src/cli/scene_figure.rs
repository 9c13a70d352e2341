//! `phalanx scene show --figure`: draws the linkage of a scene with its symbols.

use std::path::Path;

use super::command_output::CommandOutput;
use super::set::{SetArgs, source_files};
use super::targets::{FileKind, NO_DIRECTORY, TargetKind, reserve};
use crate::files::replace_file;
use crate::plot::linkage;
use crate::scene::keywords::SceneKind;

/// Draws the figure and returns the output of the command.
pub(super) fn execute(scene: &Path, set: &SetArgs, figure: &Path) -> CommandOutput {
    let error_output =
        |message: String| CommandOutput { stderr: format!("error: {message}\n"), ..CommandOutput::default() };
    let loaded = match set.load_any(scene) {
        Ok(loaded) if loaded.kind() == SceneKind::Finger => loaded,
        Ok(other) => {
            let advice = match other.kind() {
                SceneKind::Gripper => {
                    "a gripper, but only the scene of one finger can be drawn; give such a scene, or view the gripper with"
                }
                _ => "a scene of discs, which has no linkage; give the scene of a finger, or view the discs with",
            };
            return error_output(format!(
                "--figure: {} is {advice} phalanx run {} --html FILE.html",
                scene.display(),
                scene.display()
            ));
        }
        Err(error) => return CommandOutput { stderr: format!("{error}\n"), ..CommandOutput::default() },
    };
    let target = ("--figure", Some(figure), TargetKind::File(FileKind::Picture));
    if let Err(error) = reserve(&[("the scene", &source_files(scene))], &[target], NO_DIRECTORY) {
        return CommandOutput { stderr: format!("{}\n", error.message), ..CommandOutput::default() };
    }
    match replace_file(figure, |out| out.write_all(linkage(&loaded).svg.as_bytes())) {
        Ok(()) => CommandOutput {
            stdout: format!("wrote {}: the linkage of {} with its symbols\n", figure.display(), loaded.name),
            is_valid: true,
            ..CommandOutput::default()
        },
        Err(error) => error_output(format!(
            "cannot write {}: {error}; give a file in a directory where you may write",
            figure.display()
        )),
    }
}
