//! The finger, its object and its palm.

use super::parts::{Body, Drawing, Part, Pose, Shape, extent};
use crate::gripper::{Lengths, Posture, close, final_posture, link_outline, tip_outline};
use crate::numeric::elementary::{cos, sin};
use crate::scene::{Actuation, Scene};
use crate::trace::FingerState;

/// What the scene of a finger looks like.
pub fn finger(scene: &Scene) -> Drawing {
    let lengths = &scene.finger.lengths;
    let mut bodies = Vec::with_capacity(6);
    if scene.palm {
        let shapes = vec![Shape::HalfPlane { level_m: 0.0 }];
        bodies.push(Body { name: "palm".to_string(), part: Part::Palm, fixed: true, shapes });
    }
    if let Some(object) = scene.object {
        let shapes = vec![Shape::Disc { radius_m: object.radius_m }];
        bodies.push(Body { name: "object".to_string(), part: Part::Object, fixed: true, shapes });
    }
    bodies.extend(links(lengths));

    let usual_n = peak_torque(&scene.actuation) / lengths.l11_m;
    Drawing {
        contacts: match scene.object {
            Some(_) => vec!["proximal".to_string(), "distal".to_string()],
            None => Vec::new(),
        },
        arrow_m_per_n: 0.5 * lengths.l21_m / if usual_n > 0.0 { usual_n } else { 1.0 },
        longest_arrow_m: lengths.l21_m,
        extent_m: view(scene, &bodies),
        bodies,
    }
}

/// Where the bodies of [`finger`] are, in their order.
///
/// l11 and l21 turn about the origin, l12 about A12, the distal body about A22 with its x-axis along the arm.
pub fn finger_poses(scene: &Scene, finger: &FingerState) -> Vec<Pose> {
    finger_poses_at(scene, &posture_of(finger))
}

pub(super) fn posture_of(finger: &FingerState) -> Posture {
    Posture { q11_rad: finger.q11_rad, q21_rad: finger.q21_rad, q12_rad: finger.q12_rad, q22_rad: finger.q22_rad }
}

/// The same of a posture.
pub fn finger_poses_at(scene: &Scene, posture: &Posture) -> Vec<Pose> {
    let mut poses = Vec::with_capacity(6);
    if scene.palm {
        poses.push(Pose::default());
    }
    if let Some(object) = scene.object {
        poses.push(Pose { position_m: object.centre_m, angle_rad: 0.0 });
    }
    poses.extend(link_poses(&scene.finger.lengths, posture));
    poses
}

/// Of the four links, in the frame of the finger.
pub(super) fn link_poses(lengths: &Lengths, posture: &Posture) -> [Pose; 4] {
    let Lengths { l11_m, l21_m, .. } = *lengths;
    let along = |length: f64, angle: f64| [length * cos(angle), length * sin(angle)];
    let turned = |position_m, angle_rad| Pose { position_m, angle_rad };
    [
        turned([0.0; 2], posture.q11_rad),
        turned(along(l11_m, posture.q11_rad), posture.q11_rad + posture.q12_rad),
        turned([0.0; 2], posture.q21_rad),
        turned(along(l21_m, posture.q21_rad), posture.q21_rad + posture.q22_rad),
    ]
}

/// How fast the poses of [`finger_poses`] change: velocities and angular velocities in place of positions and angles.
pub fn finger_motions(scene: &Scene, finger: &FingerState) -> Vec<Pose> {
    let fixed = usize::from(scene.palm) + usize::from(scene.object.is_some());
    let mut motions = vec![Pose::default(); fixed];
    motions.extend(link_motions(&scene.finger.lengths, finger));
    motions
}

/// Of the four links, in the frame of the finger.
pub(super) fn link_motions(lengths: &Lengths, finger: &FingerState) -> [Pose; 4] {
    let Lengths { l11_m, l21_m, .. } = *lengths;
    let turning = |position_m, angle_rad| Pose { position_m, angle_rad };
    // d/dt of L (cos q, sin q).
    let end = |length: f64, q: f64, rate: f64| [-length * rate * sin(q), length * rate * cos(q)];
    let FingerState { q11_rad, q21_rad, qd11_rad_s, qd12_rad_s, qd21_rad_s, qd22_rad_s, .. } = *finger;
    [
        turning([0.0; 2], qd11_rad_s),
        turning(end(l11_m, q11_rad, qd11_rad_s), qd11_rad_s + qd12_rad_s),
        turning([0.0; 2], qd21_rad_s),
        turning(end(l21_m, q21_rad, qd21_rad_s), qd21_rad_s + qd22_rad_s),
    ]
}

/// The four links: what they weigh by, and where they touch.
pub(super) fn links(lengths: &Lengths) -> [Body; 4] {
    let w = lengths.half_width_m;
    let body = |name: &str, part, shapes| Body { name: name.to_string(), part, fixed: false, shapes };
    let bar = |length_m| Shape::Polygon { corners_m: link_outline(length_m, w).to_vec() };
    let surface = |angle: f64, length: f64| Shape::Capsule {
        from_m: [0.0; 2],
        to_m: [length * cos(angle), length * sin(angle)],
        radius_m: w,
    };
    let mut distal = vec![surface(lengths.phi22_rad, lengths.t22_m)];
    match tip_outline(lengths) {
        Ok(corners) => distal.insert(0, Shape::Polygon { corners_m: corners.to_vec() }),
        // A triangle that is flat has no outline of its own; its mass is given then.
        Err(_) => distal.insert(0, surface(0.0, lengths.l22_m)),
    }
    [
        body("l11", Part::Driver, vec![bar(lengths.l11_m)]),
        body("l12", Part::Coupler, vec![bar(lengths.l12_m)]),
        body("l21", Part::Proximal, vec![bar(lengths.l21_m), surface(0.0, lengths.l21_m)]),
        body("l22", Part::Distal, distal),
    ]
}

/// The start and, if there is one, the grasp.
fn view(scene: &Scene, bodies: &[Body]) -> [[f64; 2]; 2] {
    let finger = &scene.finger;
    let start = close(&finger.lengths, finger.assembly, scene.initial.q11_rad, scene.initial.q21_rad);
    let end = scene.object.and_then(|object| {
        let disc = object.circle();
        final_posture(&finger.lengths, finger.assembly, disc).ok().map(|end| end.posture)
    });
    // A start that does not close is the end of a run before its first step: the straight finger shows what was meant.
    let upright = Posture { q11_rad: 0.0, q21_rad: 0.5 * std::f64::consts::PI, q12_rad: 0.0, q22_rad: 0.0 };
    let postures = [Some(start.unwrap_or(upright)), end];
    let places: Vec<(&Body, Pose)> =
        postures.iter().flatten().flat_map(|posture| bodies.iter().zip(finger_poses_at(scene, posture))).collect();
    extent(&places)
}

/// Largest size of the motor torque.
pub(super) fn peak_torque(actuation: &Actuation) -> f64 {
    match actuation {
        Actuation::Constant { torque_n_m }
        | Actuation::Ramp { torque_n_m, .. }
        | Actuation::HalfSine { torque_n_m, .. }
        | Actuation::Reversal { torque_n_m, .. } => torque_n_m.abs(),
        Actuation::Table { points, .. } => points.iter().map(|point| point.1.abs()).fold(0.0, f64::max),
    }
}
