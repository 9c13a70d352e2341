//! Posture and contacts of the drawn finger.

use std::f64::consts::FRAC_PI_2;

use crate::gripper::{Joints, Lengths, Posture, close_loop, final_posture, joint_positions, straight_posture};
use crate::numeric::plane::{add, scale, sub};
use crate::scene::Scene;
use crate::shape::PlacedShape;

/// Geometry of the drawing, in metres and radians.
pub(super) struct Mechanism {
    pub lengths: Lengths,
    pub posture: Posture,
    pub joints: Joints,
    pub object: Option<PlacedShape>,
    pub palm: bool,
    /// Contact point of each phalanx, and direction of the contact force on the phalanx.
    pub contacts: Option<[([f64; 2], [f64; 2]); 2]>,
    /// Description of the posture.
    pub posture_name: &'static str,
}

pub(super) fn mechanism(scene: &Scene) -> Mechanism {
    let finger = scene.finger();
    let (lengths, assembly) = (finger.linkage.lengths, finger.linkage.assembly);
    let object = scene.object().map(|object| object.placed());
    let grasp = object.and_then(|object| Some((object, final_posture(&lengths, assembly, object).ok()?)));
    let start = || close_loop(&lengths, assembly, finger.initial.q11_rad, finger.initial.q21_rad).ok();
    // A scene whose initial linkage does not close is rejected elsewhere; the upright finger can always be drawn.
    let upright = || straight_posture(&lengths, FRAC_PI_2).ok();
    let stretched = Posture { q11_rad: 0.0, q21_rad: FRAC_PI_2, q12_rad: FRAC_PI_2, q22_rad: -lengths.phi22_rad };
    let (posture, posture_name) = match &grasp {
        Some((_, end)) => (end.posture, "at its grasp"),
        None => (start().or_else(upright).unwrap_or(stretched), "at its start"),
    };
    let joints = joint_positions(&lengths, &posture);
    let contacts = grasp.map(|(object, end)| {
        let contact = |from: [f64; 2], to: [f64; 2], part_m: f64, length_m: f64| {
            let outward = sub(add(from, scale(sub(to, from), part_m / length_m)), object.centre_m);
            let direction = outward.map(|k| k / outward[0].hypot(outward[1]));
            (object.furthest_point_m(direction), direction)
        };
        [
            contact([0.0; 2], joints.a22_m, end.l_c21_m, lengths.l21_m),
            contact(joints.a22_m, joints.tip_m, end.l_c22_m, lengths.t22_m),
        ]
    });
    Mechanism { lengths, posture, joints, object, palm: scene.system.palm.is_some(), contacts, posture_name }
}
