//! Geometric posture of a gripper around its object.

use crate::gripper::{GraspError, final_posture};
use crate::scene::{Scene, Side};

/// Returns (q11, q21) of right and left finger at which all phalanges touch the object at its position in the scene.
///
/// # Errors
/// Returns the first finger that does not reach around the object, and the reason.
pub fn geometric_posture(scene: &Scene) -> Result<[[f64; 2]; 2], (Side, GraspError)> {
    let object = scene.system.grasped().placed();
    let mut angles_rad = [[0.0; 2]; 2];
    for side in Side::BOTH {
        let finger = &scene.system.finger(side).linkage;
        let object_in_finger_frame = object.in_finger_frame(side.mirror(), 0.5 * scene.system.palm_width_m);
        let end =
            final_posture(&finger.lengths, finger.assembly, object_in_finger_frame).map_err(|error| (side, error))?;
        angles_rad[side as usize] = [end.posture.q11_rad, end.posture.q21_rad];
    }
    Ok(angles_rad)
}
