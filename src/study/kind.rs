//! Check of the scene kind for gripper studies.

use crate::scene::Scene;
use crate::scene::keywords::SceneKind;

/// Returns the scene if it is of a gripper. Messages call it `name` and suggest `example`.
///
/// # Errors
/// Returns an error if the scene is of another kind.
pub fn require_gripper(scene: Scene, name: &str, example: &str) -> Result<Scene, String> {
    match scene.kind() {
        SceneKind::Gripper => Ok(scene),
        _ => Err(format!(
            "{name} is not a gripper; this study requires a scene of kind = \"gripper\", such as {example}"
        )),
    }
}
