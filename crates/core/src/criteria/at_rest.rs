//! The grasp of a scene at rest: where the finger ends if it grasps the object, and with what forces.

use super::FinalAngles;
use crate::gripper::{FinalPosture, GraspError, final_posture};
use crate::scene::{self, Disc, Scene};
use crate::statics::{Equilibrium, StaticsError, drive_loads, equilibrium_each};

/// The grasp of a scene at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct AtRest {
    pub end: FinalPosture,
    /// With the torque that the motor has in the end.
    pub forces: Result<Equilibrium, StaticsError>,
    /// μ_s of the proximal and of the distal contact.
    pub mu_static: [f64; 2],
}

impl AtRest {
    /// Where the finger is in position.
    pub fn angles(&self) -> FinalAngles {
        FinalAngles { q11_rad: self.end.posture.q11_rad, q21_rad: self.end.posture.q21_rad }
    }

    /// Normal forces of the proximal and of the distal phalanx, N; `None` where statics say nothing.
    pub fn static_forces_n(&self) -> Option<[f64; 2]> {
        self.forces.as_ref().ok().map(|forces| [forces.f21_n, forces.f22_n])
    }

    /// Force positiveness. Where statics say nothing, nothing speaks against what is seen to hold.
    pub fn is_stable(&self) -> bool {
        self.forces.as_ref().map_or(true, Equilibrium::is_force_positive)
    }
}

/// The grasp of a scene's finger, or in words why there is none.
///
/// # Errors
/// There is no object, or the finger cannot grasp it.
pub fn grasp_at_rest(scene: &Scene) -> Result<AtRest, String> {
    let object = scene.object().ok_or_else(|| "there is no object".to_string())?;
    at_rest(scene, object).map_err(|error| error.to_string())
}

/// The grasp of a scene's finger on its object.
///
/// # Errors
/// Why the finger cannot grasp the object.
pub fn at_rest(scene: &Scene, object: &Disc) -> Result<AtRest, GraspError> {
    let finger = scene.finger();
    let end = final_posture(&finger.linkage.lengths, finger.linkage.assembly, object.placed())?;
    let mu_static = finger.contact.mu_static();
    let motor_n_m = scene::torque(&finger.motor.actuation, scene.duration_s).0;
    let forces = drive_loads(&finger.linkage, &end, motor_n_m, finger.spring.as_ref())
        .and_then(|loads| equilibrium_each(&finger.linkage, &end, loads, mu_static));
    Ok(AtRest { end, forces, mu_static })
}
