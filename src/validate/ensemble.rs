//! The members of the ensemble: the scene with its motor torque, or the speeds of its discs and gravity, changed by parts in 1e9.

use crate::scene::{BodiesScene, DiscMotion, Scene, scaled};

/// Runs of which the worst counts.
pub const MEMBERS: usize = 5;

/// Relative difference of the motor torque from one member to the next: far below any bound in its effect, and enough
/// to shift where steps fall.
pub const TORQUE_STEP: f64 = 1e-9;

/// The scene as the member `index` has it; member 0 is the scene itself.
pub fn member(scene: &Scene, index: usize) -> Scene {
    Scene { actuation: scaled(&scene.actuation, 1.0 + index as f64 * TORQUE_STEP), ..scene.clone() }
}

/// The same of discs: everything that moves, and gravity, a little faster.
pub fn member_of_discs(scene: &BodiesScene, index: usize) -> BodiesScene {
    let factor = 1.0 + index as f64 * TORQUE_STEP;
    let scaled = |vector: [f64; 2]| vector.map(|part| factor * part);
    let mut member = scene.clone();
    member.gravity_m_s2 = scaled(scene.gravity_m_s2);
    for disc in &mut member.discs {
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
