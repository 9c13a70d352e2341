//! `phalanx scene show --figure`: the linkage of a scene with its letters.

use std::path::Path;

use super::answer::Answer;
use super::own::Form;
use super::set::{SetArgs, files};
use super::targets::{Kind, NONE, reserve};
use crate::files::replace;
use crate::plot::linkage;
use crate::scene::words::SceneKind;

/// Draws the figure; says what was written, or why not.
pub(super) fn answer(scene: &Path, set: &SetArgs, figure: &Path) -> Answer {
    let refused = |why: String| Answer { stderr: format!("error: {why}\n"), ..Answer::default() };
    let found = match set.load_any(scene) {
        Ok(found) if found.kind() == SceneKind::Finger => found,
        Ok(other) => {
            let what = match other.kind() {
                SceneKind::Gripper => {
                    "a gripper, of which no letters are drawn; draw the scene of one finger, or see the gripper with"
                }
                _ => "a scene of discs, which has no linkage; draw the scene of a finger, or see the discs with",
            };
            return refused(format!(
                "--figure: {} is {what} phalanx run {} --html FILE.html",
                scene.display(),
                scene.display()
            ));
        }
        Err(error) => return Answer { stderr: format!("{error}\n"), ..Answer::default() },
    };
    let target = ("--figure", Some(figure), Kind::File(Form::Picture));
    if let Err(error) = reserve(&[("the scene", &files(scene))], &[target], NONE) {
        return Answer { stderr: format!("{}\n", error.message), ..Answer::default() };
    }
    match replace(figure, |out| out.write_all(linkage(&found).svg.as_bytes())) {
        Ok(()) => Answer {
            stdout: format!("wrote {}: the linkage of {} with its letters\n", figure.display(), found.name),
            good: true,
            ..Answer::default()
        },
        Err(error) => refused(format!(
            "cannot write {}: {error}; give a file in a directory where you may write",
            figure.display()
        )),
    }
}
