//! Studies that are about grippers.

use crate::scene::{AnyScene, GripperScene};

/// The gripper of a scene; `what` is what messages call that, `like` a scene that would do.
///
/// # Errors
/// A scene of another kind.
pub fn only_gripper(scene: AnyScene, what: &str, like: &str) -> Result<GripperScene, String> {
    match scene {
        AnyScene::Gripper(scene) => Ok(*scene),
        _ => Err(format!("{what} is no gripper; this study takes a scene of kind = \"gripper\", like {like}")),
    }
}
