//! A scene as a complete scene file, which parses back to the same scene, bit for bit (its `source` excepted): as it is
//! simulated, or as it was written.

mod discs;
mod finger;
mod gripper;
mod out;
mod parts;
mod written;

pub use out::Out;
pub use written::show_written;

use super::table::bounds::{DiscBounds, FingerBounds, GripperBounds};
use super::table::show as show_table;
use super::words::SceneKind;
use super::{Bounds, Scene};

/// The scene with everything filled in as it is simulated.
pub fn show(scene: &Scene) -> String {
    shown(scene, Out::default())
}

fn shown(scene: &Scene, mut out: Out) -> String {
    let to = &mut out;
    let heading = parts::heading(to, scene);
    match scene.kind() {
        SceneKind::Finger => finger::system(to, heading, &scene.system),
        SceneKind::Bodies => discs::system(to, heading, &scene.system),
        SceneKind::Gripper => gripper::system(to, heading, &scene.system),
    }
    show_table(to, "integrator", &scene.integrator);
    show_table(to, "engine", &scene.engine);
    // A program may have shortened the run.
    let bounds = Bounds { until_s: scene.bounds.until_s.min(scene.duration_s), ..scene.bounds };
    match scene.kind() {
        SceneKind::Finger => show_table(to, "validate", &FingerBounds::from(bounds)),
        SceneKind::Bodies => show_table(to, "validate", &DiscBounds::from(bounds)),
        SceneKind::Gripper => show_table(to, "validate", &GripperBounds::from(bounds)),
    }
    show_table(to, "log", &scene.log);
    out.text
}
