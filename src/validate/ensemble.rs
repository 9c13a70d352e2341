//! The members of the ensemble: the scene with its motor torque, or the speeds of its discs and gravity, changed by parts in 1e9.

use crate::check::pushed;
use crate::scene::words::SceneKind;
use crate::scene::{DiscMotion, Scene};

/// Runs of which the worst counts, of a finger or of discs…
pub const MEMBERS: usize = 5;
/// …and of a gripper, whose runs take 50 times as long: the scene itself, and one other.
pub const GRIPPER_MEMBERS: usize = 2;

/// Runs of a scene of which the worst counts.
pub fn members(scene: &Scene) -> usize {
    if scene.kind() == SceneKind::Gripper { GRIPPER_MEMBERS } else { MEMBERS }
}

/// Relative difference of the motor torque from one member to the next: far below any bound in its effect, and enough
/// to shift where steps fall.
pub const TORQUE_STEP: f64 = 1e-9;

/// The scene as the member `index` has it; member 0 is the scene itself. Of discs everything that moves, and gravity, is a little faster.
pub fn member(scene: &Scene, index: usize) -> Scene {
    let part = index as f64 * TORQUE_STEP;
    if !scene.system.fingers.is_empty() {
        return pushed(scene, part);
    }
    let scaled = |vector: [f64; 2]| vector.map(|component| (1.0 + part) * component);
    let mut member = scene.clone();
    member.system.gravity_m_s2 = scaled(scene.system.gravity_m_s2);
    for disc in &mut member.system.discs {
        match &mut disc.motion {
            DiscMotion::Fixed => {}
            DiscMotion::Driven { velocity_m_s, acceleration_m_s2, .. } => {
                (*velocity_m_s, *acceleration_m_s2) = (scaled(*velocity_m_s), scaled(*acceleration_m_s2));
            }
            DiscMotion::Free { velocity_m_s, .. } => *velocity_m_s = scaled(*velocity_m_s),
        }
    }
    member
}
