//! The four links of a finger, in its own frame.

use super::body::{Body, BodyRole, Pose, Shape};
use crate::gripper::{Lengths, Posture, link_outline, tip_outline};
use crate::numeric::elementary::{cos, sin};
use crate::scene::Side;
use crate::trace::FingerState;

/// Returns the four links with their outlines and contact surfaces.
pub(super) fn link_bodies(lengths: &Lengths) -> [Body; 4] {
    let w = lengths.half_width_m;
    let body = |name: &str, role, shapes| Body { name: name.to_string(), role, fixed: false, shapes };
    let bar = |length_m| Shape::Polygon { corners_m: link_outline(length_m, w).to_vec() };
    let surface = |angle: f64, length: f64| Shape::Capsule {
        from_m: [0.0; 2],
        to_m: [length * cos(angle), length * sin(angle)],
        radius_m: w,
    };
    let mut distal = vec![surface(lengths.phi22_rad, lengths.t22_m)];
    match tip_outline(lengths) {
        Ok(corners) => distal.insert(0, Shape::Polygon { corners_m: corners.to_vec() }),
        // A degenerate triangle has no outline; its mass is given in the scene.
        Err(_) => distal.insert(0, surface(0.0, lengths.l22_m)),
    }
    [
        body("l11", BodyRole::Driver, vec![bar(lengths.l11_m)]),
        body("l12", BodyRole::Coupler, vec![bar(lengths.l12_m)]),
        body("l21", BodyRole::Proximal, vec![bar(lengths.l21_m), surface(0.0, lengths.l21_m)]),
        body("l22", BodyRole::Distal, distal),
    ]
}

/// Poses of the links: l11 and l21 rotate about the origin, l12 about A12, the distal body about A22 with its x-axis
/// along the arm.
pub(super) fn link_poses(lengths: &Lengths, posture: &Posture) -> [Pose; 4] {
    let Lengths { l11_m, l21_m, .. } = *lengths;
    let along = |length: f64, angle: f64| [length * cos(angle), length * sin(angle)];
    let pose = |position_m, angle_rad| Pose { position_m, angle_rad };
    [
        pose([0.0; 2], posture.q11_rad),
        pose(along(l11_m, posture.q11_rad), posture.q11_rad + posture.q12_rad),
        pose([0.0; 2], posture.q21_rad),
        pose(along(l21_m, posture.q21_rad), posture.q21_rad + posture.q22_rad),
    ]
}

/// Time derivatives of the poses: velocities and angular velocities instead of positions and angles.
pub(super) fn link_velocities(lengths: &Lengths, finger: &FingerState) -> [Pose; 4] {
    let Lengths { l11_m, l21_m, .. } = *lengths;
    let velocity = |position_m, angle_rad| Pose { position_m, angle_rad };
    // d/dt of L (cos q, sin q).
    let end_velocity = |length: f64, q: f64, rate: f64| [-length * rate * sin(q), length * rate * cos(q)];
    let FingerState { q11_rad, q21_rad, qd11_rad_s, qd12_rad_s, qd21_rad_s, qd22_rad_s, .. } = *finger;
    [
        velocity([0.0; 2], qd11_rad_s),
        velocity(end_velocity(l11_m, q11_rad, qd11_rad_s), qd11_rad_s + qd12_rad_s),
        velocity([0.0; 2], qd21_rad_s),
        velocity(end_velocity(l21_m, q21_rad, qd21_rad_s), qd21_rad_s + qd22_rad_s),
    ]
}

/// Mirrors a link's shape for a left finger.
pub(super) fn mirrored(shape: Shape, side: Side) -> Shape {
    let flip = |[x, y]: [f64; 2]| [x, side.mirror() * y];
    match shape {
        Shape::Polygon { corners_m } => {
            let mut corners_m: Vec<[f64; 2]> = corners_m.into_iter().map(flip).collect();
            if side == Side::Left {
                corners_m.reverse();
            }
            Shape::Polygon { corners_m }
        }
        Shape::Capsule { from_m, to_m, radius_m } => {
            Shape::Capsule { from_m: flip(from_m), to_m: flip(to_m), radius_m }
        }
        other => other,
    }
}
