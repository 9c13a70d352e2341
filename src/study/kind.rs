//! Studies that are about grippers.

use crate::scene::Scene;
use crate::scene::words::SceneKind;

/// The gripper of a scene; `what` is what messages call that, `like` a scene that would do.
///
/// # Errors
/// A scene of another kind.
pub fn only_gripper(scene: Scene, what: &str, like: &str) -> Result<Scene, String> {
    match scene.kind() {
        SceneKind::Gripper => Ok(scene),
        _ => Err(format!("{what} is no gripper; this study takes a scene of kind = \"gripper\", like {like}")),
    }
}
