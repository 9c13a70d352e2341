//! Studies: how results depend on settings and on designs.

pub mod batch;
pub mod capture;
pub mod hold;
pub mod offsets;
pub mod optimisation;
pub mod parameter;
pub mod parts;
pub mod posture;
pub mod quantity;
pub mod results;
pub mod select;
pub mod size;
pub mod sweep;

use crate::scene::{HandFinger, Scene, SpringKind};
use phalanx_parallel::KeepRunning;

/// Returns the scene if it has a grasp: that of a gripper or of a mechanism.
///
/// # Errors
/// Returns an error that calls the scene `name` and suggests `example`.
pub fn require_grasp(scene: Scene, name: &str, example: &str) -> Result<Scene, String> {
    match scene.finger_count() {
        2 => Ok(scene),
        1 => Err(format!(
            "{name} is not a gripper; this study requires a gripper, or a mechanism with a grasp, such as {example}"
        )),
        _ => match scene.grasp_roles() {
            Ok(_) => Ok(scene),
            Err(error) => Err(format!("{name} has no grasp: {error}; see {example}")),
        },
    }
}

fn constant_spring(finger: &HandFinger) -> Option<f64> {
    match finger.spring?.kind {
        SpringKind::Constant { torque_n_m } => Some(torque_n_m),
        SpringKind::Torsional { .. } => None,
    }
}

/// Narrows a bracket of a value that passes and one that fails: tests the value that `next` returns for the bracket,
/// until it returns `None`. Returns the bracket, or the error of a test.
fn bisect<E>(
    mut bracket: [f64; 2],
    next: impl Fn(f64, f64) -> Option<f64>,
    mut passes: impl FnMut(f64) -> Result<bool, E>,
) -> Result<[f64; 2], E> {
    while let Some(value) = next(bracket[0], bracket[1]) {
        bracket[usize::from(!passes(value)?)] = value;
    }
    Ok(bracket)
}
