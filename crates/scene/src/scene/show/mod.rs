//! A scene as a complete scene file, which parses back to the same scene, bit for bit (its `source` excepted): as it is
//! simulated, or as it was written.

mod bodies;
mod finger;
mod gripper;
mod out;
mod parts;
mod written;

pub use bodies::show_bodies;
pub use finger::show;
pub use gripper::show_gripper;
pub use out::Out;
pub use written::show_written;

use super::AnyScene;

/// The scene with everything filled in as it is simulated.
pub fn show_any(scene: &AnyScene) -> String {
    match scene {
        AnyScene::Finger(scene) => show(scene),
        AnyScene::Bodies(scene) => show_bodies(scene),
        AnyScene::Gripper(scene) => show_gripper(scene),
    }
}
