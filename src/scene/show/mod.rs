//! A scene as a complete scene file, which parses back to the same scene, bit for bit (its `source` excepted).

mod bodies;
mod finger;
mod out;
mod parts;

pub use bodies::show_bodies;
pub use finger::show;

use super::AnyScene;

/// The scene with everything filled in.
pub fn show_any(scene: &AnyScene) -> String {
    match scene {
        AnyScene::Finger(scene) => show(scene),
        AnyScene::Bodies(scene) => show_bodies(scene),
    }
}
