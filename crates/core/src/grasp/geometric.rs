//! Where the fingers of a gripper close around its object.

use crate::gripper::{GraspError, final_posture};
use crate::scene::{Scene, Side};

/// (q11, q21) of right and left at which all phalanges touch the object where the scene has it.
///
/// # Errors
/// The first finger that does not reach around it, and why.
pub fn geometric(scene: &Scene) -> Result<[[f64; 2]; 2], (Side, GraspError)> {
    let object = scene.system.grasped().placed();
    let mut angles_rad = [[0.0; 2]; 2];
    for side in Side::BOTH {
        let finger = &scene.system.finger(side).linkage;
        let seen = object.in_finger(side.mirror(), 0.5 * scene.system.palm_width_m);
        let end = final_posture(&finger.lengths, finger.assembly, seen).map_err(|error| (side, error))?;
        angles_rad[side as usize] = [end.posture.q11_rad, end.posture.q21_rad];
    }
    Ok(angles_rad)
}
