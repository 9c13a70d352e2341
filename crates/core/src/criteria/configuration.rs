//! Grasps at rest: configuration, normal forces and closures of a gripper's grasp in a sample, and the final posture and
//! contact forces of a finger.

use crate::gripper::{FinalPosture, FingerContact, GraspError, final_posture};
use crate::scene::{HandContact, Object, Scene, Side};
use crate::shape::{PlacedShape, max_radius};
use crate::statics::{
    Blocked, Equilibrium, ForceClosure, FrictionContact, GraspConfiguration, PerContact, StaticsError, drive_loads,
    equilibrium_with_mu, force_closure, gripper_closure,
};
use crate::trace::{BodyState, ContactSample, FingerState, Sample};

/// Returns the configuration of fingers and object in a sample.
pub fn grasp_configuration<'a>(scene: &'a Scene, sample: &Sample) -> GraspConfiguration<'a> {
    let angles = |FingerState { q11_rad, q21_rad, .. }: FingerState| [q11_rad, q21_rad];
    let BodyState { centre_m, angle_rad, .. } = sample.object(&scene.hand);
    GraspConfiguration {
        fingers: Side::BOTH.map(|side| &scene.hand.finger(side).linkage),
        angles_rad: Side::BOTH.map(|side| angles(sample.finger(side as usize))),
        palm_width_m: scene.hand.palm_width_m,
        object: PlacedShape { shape: scene.hand.grasped().shape, centre_m, angle_rad },
    }
}

/// Returns the normal forces of phalanges and palm in a sample, N.
pub fn normal_forces(scene: &Scene, sample: &Sample) -> PerContact<f64> {
    let force = |contact| sample.hand_contact(&scene.hand, contact).normal_n;
    let phalanges = |side| {
        [FingerContact::Proximal, FingerContact::Distal].map(|contact| force(HandContact::Finger(side, contact)))
    };
    PerContact { phalanges: Side::BOTH.map(phalanges), palm: force(HandContact::Palm) }
}

/// Returns whether the active contacts of a sample form-close the object while both motors are blocked, or the input of
/// the differential is blocked. `None` if form closure cannot be decided.
pub fn is_form_closed(scene: &Scene, sample: &Sample) -> Option<bool> {
    let blocked = if scene.hand.differential.is_some() { Blocked::Input } else { Blocked::Outputs };
    let active = normal_forces(scene, sample).map(|normal_n| normal_n > 0.0);
    gripper_closure(&grasp_configuration(scene, sample), &active, blocked).ok().map(|closure| closure.closed)
}

/// Returns the static friction coefficients of phalanges and palm.
pub(super) fn friction_coefficients(scene: &Scene) -> PerContact<f64> {
    let palm =
        scene.hand.law(HandContact::Palm).and_then(|law| law.friction).map_or(0.0, |friction| friction.mu_static);
    PerContact { phalanges: Side::BOTH.map(|side| scene.hand.finger(side).contact.mu_static()), palm }
}

/// Returns the force closure of the active contacts of phalanges and palm in a sample. It does not depend on their
/// forces.
pub fn sample_force_closure(scene: &Scene, sample: &Sample) -> ForceClosure {
    let contacts = scene.hand.contacts().zip(sample.contacts()).filter(|(_, contact)| contact.normal_n > 0.0);
    let object_m = max_radius(&scene.hand.grasped().shape);
    selected_force_closure(&friction_coefficients(scene), (sample.object(&scene.hand).centre_m, object_m), contacts)
}

/// Returns the force closure by these contacts of phalanges and palm. The object has its centre and the distance of its
/// outermost point from there.
pub(super) fn selected_force_closure(
    friction: &PerContact<f64>,
    (centre_m, object_m): ([f64; 2], f64),
    contacts: impl Iterator<Item = (HandContact, ContactSample)>,
) -> ForceClosure {
    let friction_contact = |(contact_id, contact): (HandContact, ContactSample)| {
        let mu = match contact_id {
            HandContact::Finger(side, FingerContact::Proximal) => friction.phalanges[side as usize][0],
            HandContact::Finger(side, FingerContact::Distal) => friction.phalanges[side as usize][1],
            HandContact::Palm => friction.palm,
            HandContact::Finger(_, FingerContact::Limit) | HandContact::Table => return None,
        };
        // Normals of a sample point away from the object.
        let push = contact.normal.map(|component| -component);
        Some(FrictionContact { point_m: contact.point_m, push, mu })
    };
    let contacts: Vec<FrictionContact> = contacts.filter_map(friction_contact).collect();
    force_closure(&contacts, centre_m, object_m)
}

/// The two angles of the geometric final configuration, in which both phalanges touch the object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FinalAngles {
    pub q11_rad: f64,
    pub q21_rad: f64,
}

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

    /// Returns the normal forces of the proximal and the distal phalanx, N; `None` if the statics cannot be computed.
    pub fn static_forces_n(&self) -> Option<[f64; 2]> {
        self.forces.as_ref().ok().map(|forces| [forces.f21_n, forces.f22_n])
    }

    /// Returns whether the grasp is force-positive; also true if the statics cannot be computed.
    pub fn is_stable(&self) -> bool {
        self.forces.as_ref().map_or(true, Equilibrium::is_force_positive)
    }
}

/// Returns the static grasp of the finger of a scene. Returns an error if there is no object, or if the finger cannot
/// grasp it.
pub fn scene_static_grasp(scene: &Scene) -> Result<StaticGrasp, String> {
    let object = scene.object().ok_or_else(|| "there is no object".to_string())?;
    static_grasp(scene, object).map_err(|error| error.to_string())
}

/// Returns the static grasp of the finger of a scene on an object. Returns an error if the finger cannot grasp it.
pub fn static_grasp(scene: &Scene, object: &Object) -> Result<StaticGrasp, GraspError> {
    let finger = scene.finger();
    let end = final_posture(&finger.linkage.lengths, finger.linkage.assembly, object.placed())?;
    let mu_static = finger.contact.mu_static();
    let motor_n_m = finger.motor.actuation.at(scene.duration_s).0;
    let forces = drive_loads(&finger.linkage, &end, motor_n_m, finger.spring.as_ref())
        .and_then(|loads| equilibrium_with_mu(&finger.linkage, &end, loads, mu_static));
    Ok(StaticGrasp { end, forces, mu_static })
}
