//! The members of the ensemble: the scene with its motor torque, or the speeds of its discs and gravity, changed by
//! parts in 1e9.

use crate::check::perturbed;
use crate::scene::keywords::SceneKind;
use crate::scene::{DiscMotion, Scene};

/// Number of runs of a scene with a finger or discs; the worst one determines the result.
pub const ENSEMBLE_SIZE: usize = 5;
/// Number of runs of a gripper scene, which take 50 times as long: the scene itself and one perturbed scene.
pub const GRIPPER_ENSEMBLE_SIZE: usize = 2;

/// Returns the number of runs of a scene; the worst one determines the result.
pub fn ensemble_size(scene: &Scene) -> usize {
    if scene.kind() == SceneKind::Gripper { GRIPPER_ENSEMBLE_SIZE } else { ENSEMBLE_SIZE }
}

/// Relative difference between the motor torques of consecutive members. It shifts the integrator's steps, but its
/// effect is far below any bound.
pub const MEMBER_PERTURBATION: f64 = 1e-9;

/// Returns the scene of member `index`; member 0 is the scene itself. For scenes of discs, all velocities and gravity
/// are scaled.
pub fn ensemble_member(scene: &Scene, index: usize) -> Scene {
    let perturbation = index as f64 * MEMBER_PERTURBATION;
    if !scene.system.fingers.is_empty() {
        return perturbed(scene, perturbation);
    }
    let scaled = |vector: [f64; 2]| vector.map(|component| (1.0 + perturbation) * component);
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
