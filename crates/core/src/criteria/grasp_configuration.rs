//! Configuration, normal forces and closure of a gripper's grasp in a sample.

use crate::gripper::FingerContact;
use crate::scene::{GripperContact, Scene, Side};
use crate::shape::{PlacedShape, max_radius};
use crate::statics::{
    Blocked, ForceClosure, FrictionContact, GraspConfiguration, PerContact, force_closure, gripper_closure,
};
use crate::trace::{ContactSample, FingerState, Sample};

/// Returns the configuration of fingers and object in a sample.
pub fn grasp_configuration<'a>(scene: &'a Scene, sample: &Sample) -> GraspConfiguration<'a> {
    let angles = |FingerState { q11_rad, q21_rad, .. }: &FingerState| [*q11_rad, *q21_rad];
    GraspConfiguration {
        fingers: Side::BOTH.map(|side| &scene.system.finger(side).linkage),
        angles_rad: Side::BOTH.map(|side| angles(&sample.fingers[side as usize])),
        palm_width_m: scene.system.palm_width_m,
        object: PlacedShape {
            shape: scene.system.grasped().shape,
            centre_m: sample.bodies[0].centre_m,
            angle_rad: sample.bodies[0].angle_rad,
        },
    }
}

/// Returns the normal forces of phalanges and palm in a sample, N.
pub fn normal_forces(sample: &Sample) -> PerContact<f64> {
    let force = |required: GripperContact| {
        let all = GripperContact::ALL.into_iter().zip(&sample.contacts);
        all.filter(|(contact_id, _)| *contact_id == required).map(|(_, contact)| contact.normal_n).sum()
    };
    let phalanges = |side| {
        [FingerContact::Proximal, FingerContact::Distal].map(|contact| force(GripperContact::Finger(side, contact)))
    };
    PerContact { phalanges: Side::BOTH.map(phalanges), palm: force(GripperContact::Palm) }
}

/// Returns whether the active contacts of a sample form-close the object with both motors blocked, or with the input of
/// the differential blocked; `None` if form closure cannot be decided.
pub fn is_form_closed(scene: &Scene, sample: &Sample) -> Option<bool> {
    let blocked = if scene.system.differential.is_some() { Blocked::Input } else { Blocked::Outputs };
    let active = normal_forces(sample).map(|normal_n| normal_n > 0.0);
    gripper_closure(&grasp_configuration(scene, sample), &active, blocked).ok().map(|closure| closure.closed)
}

/// Returns the static friction coefficients of phalanges and palm.
pub fn friction_coefficients(scene: &Scene) -> PerContact<f64> {
    let palm =
        scene.system.law(GripperContact::Palm).and_then(|law| law.friction).map_or(0.0, |friction| friction.mu_static);
    PerContact { phalanges: Side::BOTH.map(|side| scene.system.finger(side).contact.mu_static()), palm }
}

/// Returns the force closure by the active contacts of phalanges and palm in a sample, independent of their forces.
pub fn sample_force_closure(scene: &Scene, sample: &Sample) -> ForceClosure {
    let is_active = |_, contact: &ContactSample| contact.normal_n > 0.0;
    selected_force_closure(&friction_coefficients(scene), max_radius(&scene.system.grasped().shape), sample, is_active)
}

/// Returns the force closure by the contacts of phalanges and palm that a predicate selects. `object_m` is the distance
/// of the object's outermost point from its centre.
pub(super) fn selected_force_closure(
    friction: &PerContact<f64>,
    object_m: f64,
    sample: &Sample,
    is_selected: impl Fn(usize, &ContactSample) -> bool,
) -> ForceClosure {
    let friction_contact = |(index, (contact_id, contact)): (usize, (GripperContact, &ContactSample))| {
        let mu = match contact_id {
            GripperContact::Finger(side, FingerContact::Proximal) => friction.phalanges[side as usize][0],
            GripperContact::Finger(side, FingerContact::Distal) => friction.phalanges[side as usize][1],
            GripperContact::Palm => friction.palm,
            GripperContact::Finger(_, FingerContact::Limit) | GripperContact::Table => return None,
        };
        // Normals of a sample point away from the object.
        let push = contact.normal.map(|component| -component);
        is_selected(index, contact).then_some(FrictionContact { point_m: contact.point_m, push, mu })
    };
    let all = GripperContact::ALL.into_iter().zip(&sample.contacts).enumerate();
    let contacts: Vec<FrictionContact> = all.filter_map(friction_contact).collect();
    force_closure(&contacts, sample.bodies[0].centre_m, object_m)
}
