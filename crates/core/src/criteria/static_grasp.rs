//! The static grasp of a finger: final posture and contact forces.

use super::FinalAngles;
use crate::gripper::{FinalPosture, GraspError, final_posture};
use crate::scene::{self, Disc, Scene};
use crate::statics::{Equilibrium, StaticsError, drive_loads, equilibrium_with_mu};

/// A static grasp of a finger.
#[derive(Clone, Debug, PartialEq)]
pub struct StaticGrasp {
    pub end: FinalPosture,
    /// Contact forces at the final motor torque.
    pub forces: Result<Equilibrium, StaticsError>,
    /// μ_s of the proximal and of the distal contact.
    pub mu_static: [f64; 2],
}

impl StaticGrasp {
    /// Returns the angles at which the finger is in position.
    pub fn final_angles(&self) -> FinalAngles {
        FinalAngles { q11_rad: self.end.posture.q11_rad, q21_rad: self.end.posture.q21_rad }
    }

    /// Returns the normal forces of proximal and distal phalanx, N; `None` if statics fails.
    pub fn static_forces_n(&self) -> Option<[f64; 2]> {
        self.forces.as_ref().ok().map(|forces| [forces.f21_n, forces.f22_n])
    }

    /// Returns whether the grasp is force-positive; true if statics fails.
    pub fn is_stable(&self) -> bool {
        self.forces.as_ref().map_or(true, Equilibrium::is_force_positive)
    }
}

/// Returns the static grasp of the finger of a scene.
///
/// # Errors
/// Returns an error if there is no object or the finger cannot grasp it.
pub fn scene_static_grasp(scene: &Scene) -> Result<StaticGrasp, String> {
    let object = scene.object().ok_or_else(|| "there is no object".to_string())?;
    static_grasp(scene, object).map_err(|error| error.to_string())
}

/// Returns the static grasp of the finger of a scene on an object.
///
/// # Errors
/// Returns an error if the finger cannot grasp the object.
pub fn static_grasp(scene: &Scene, object: &Disc) -> Result<StaticGrasp, GraspError> {
    let finger = scene.finger();
    let end = final_posture(&finger.linkage.lengths, finger.linkage.assembly, object.placed())?;
    let mu_static = finger.contact.mu_static();
    let motor_n_m = scene::torque(&finger.motor.actuation, scene.duration_s).0;
    let forces = drive_loads(&finger.linkage, &end, motor_n_m, finger.spring.as_ref())
        .and_then(|loads| equilibrium_with_mu(&finger.linkage, &end, loads, mu_static));
    Ok(StaticGrasp { end, forces, mu_static })
}
