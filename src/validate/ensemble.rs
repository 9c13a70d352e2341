//! The members of the ensemble: the scene with its motor torque changed by parts in 1e9.

use crate::scene::{Scene, scaled};

/// Runs of which the worst counts.
pub const MEMBERS: usize = 5;

/// Relative difference of the motor torque from one member to the next: far below any bound in its effect, and enough
/// to shift where steps fall.
pub const TORQUE_STEP: f64 = 1e-9;

/// The scene as the member `index` has it; member 0 is the scene itself.
pub fn member(scene: &Scene, index: usize) -> Scene {
    Scene { actuation: scaled(&scene.actuation, 1.0 + index as f64 * TORQUE_STEP), ..scene.clone() }
}
