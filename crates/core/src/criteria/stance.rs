//! The posture of a gripper in a sample, for those who judge how it is held.

use crate::gripper::Site;
use crate::scene::{Place, Scene, Side};
use crate::shape::{Placed, reach};
use crate::statics::{Blocked, ForceClosure, Holding, PerContact, Stance, force_closure, gripper_closure};
use crate::trace::{ContactSample, FingerState, Sample};

/// Where fingers and object of a gripper are in a sample of its run.
pub fn stance<'a>(scene: &'a Scene, sample: &Sample) -> Stance<'a> {
    let angles = |FingerState { q11_rad, q21_rad, .. }: &FingerState| [*q11_rad, *q21_rad];
    Stance {
        fingers: Side::BOTH.map(|side| &scene.system.finger(side).linkage),
        angles_rad: Side::BOTH.map(|side| angles(&sample.fingers[side as usize])),
        palm_width_m: scene.system.palm_width_m,
        object: Placed {
            shape: scene.system.grasped().shape,
            centre_m: sample.bodies[0].centre_m,
            angle_rad: sample.bodies[0].angle_rad,
        },
    }
}

/// Normal forces in a sample of those contacts that can hold an object fast, N.
pub fn normal_forces(sample: &Sample) -> PerContact<f64> {
    let force = |wanted: Place| {
        let all = Place::ALL.into_iter().zip(&sample.contacts);
        all.filter(|(place, _)| *place == wanted).map(|(_, contact)| contact.normal_n).sum()
    };
    let phalanges = |side| [Site::Proximal, Site::Distal].map(|site| force(Place::Finger(side, site)));
    PerContact { phalanges: Side::BOTH.map(phalanges), palm: force(Place::Palm) }
}

/// Whether the grasp of a sample is form-closed by the contacts that press in it, with both motors blocked, or the input of the
/// differential that drives both fingers; `None` where that cannot be decided.
pub fn is_form_closed(scene: &Scene, sample: &Sample) -> Option<bool> {
    let blocked = if scene.system.differential.is_some() { Blocked::Input } else { Blocked::Outputs };
    let touching = normal_forces(sample).map(|normal_n| normal_n > 0.0);
    gripper_closure(&stance(scene, sample), &touching, blocked).ok().map(|found| found.closed)
}

/// Friction coefficients that contacts of a scene hold with.
pub fn friction(scene: &Scene) -> PerContact<f64> {
    let palm = scene.system.law(Place::Palm).and_then(|law| law.friction).map_or(0.0, |friction| friction.mu_static);
    PerContact { phalanges: Side::BOTH.map(|side| scene.system.finger(side).contact.mu_static()), palm }
}

/// How the contacts in the hand (phalanges and palm) that press in a sample hold the object with friction, whatever their forces are.
pub fn force_closure_of(scene: &Scene, sample: &Sample) -> ForceClosure {
    let presses = |_, contact: &ContactSample| contact.normal_n > 0.0;
    closure_with(&friction(scene), reach(&scene.system.grasped().shape), sample, presses)
}

/// The same of the contacts in the hand that a predicate selects by their index. `object_m` is the distance of the object's outermost point
/// from its centre.
pub(super) fn closure_with(
    friction: &PerContact<f64>,
    object_m: f64,
    sample: &Sample,
    selects: impl Fn(usize, &ContactSample) -> bool,
) -> ForceClosure {
    let holding = |(index, (place, contact)): (usize, (Place, &ContactSample))| {
        let mu = match place {
            Place::Finger(side, Site::Proximal) => friction.phalanges[side as usize][0],
            Place::Finger(side, Site::Distal) => friction.phalanges[side as usize][1],
            Place::Palm => friction.palm,
            Place::Finger(_, Site::Limit) | Place::Table => return None,
        };
        // A sample's normals point away from the object.
        let push = contact.normal.map(|part| -part);
        selects(index, contact).then_some(Holding { point_m: contact.point_m, push, mu })
    };
    let all = Place::ALL.into_iter().zip(&sample.contacts).enumerate();
    let contacts: Vec<Holding> = all.filter_map(holding).collect();
    force_closure(&contacts, sample.bodies[0].centre_m, object_m)
}
