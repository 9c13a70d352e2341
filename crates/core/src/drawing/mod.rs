//! Drawing of a scene: the shapes of its bodies in their own frames, and the poses of these frames at an instant.
//!
//! The pictures in a log and the animated page both use this module, so they show the same bodies.

mod mechanism;

use std::f64::consts::PI;

use serde::Serialize;

use crate::gripper::{Lengths, Posture, close_loop, final_posture, link_outline, tip_outline};
use crate::numeric::elementary::{cos, sin, sin_cos};
use crate::scene::{Hand, HandFinger, Object, ObjectMotion, PalmMotion, Scene, Side};
pub use mechanism::poses_at_start;

use crate::shape::{self, circle_radius};
use crate::trace::{BodyState, FingerState, Sample};

/// The drawing of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Fixed bodies first, so that moving bodies are drawn over them.
    pub bodies: Vec<Body>,
    /// Names of the contacts, in the order of samples.
    pub contacts: Vec<String>,
    /// Arrow length per newton.
    pub arrow_m_per_n: f64,
    /// Largest arrow length; impact forces can be a thousand times the usual ones.
    pub longest_arrow_m: f64,
    /// Lower left and upper right corner of a view of all bodies, at the start and (with five-bar fingers) in the grasp.
    pub extent_m: [[f64; 2]; 2],
}

/// A rigid body.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Body {
    /// `l11`, `l12`, `l21`, `l22`, `object`, `palm`, `plane`, or the name of a disc.
    pub name: String,
    #[serde(rename = "part")]
    pub role: BodyRole,
    /// Whether the body does not move.
    pub fixed: bool,
    pub shapes: Vec<Shape>,
    /// Points that pages mark by a ring: pins, and the centre of an object.
    pub marks_m: Vec<[f64; 2]>,
}

/// Role of a body in the mechanism.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BodyRole {
    /// Link l11.
    Driver,
    /// Link l12.
    Coupler,
    /// Link l21.
    Proximal,
    /// Distal body, l22 and t22.
    Distal,
    Object,
    Palm,
}

/// A shape in the frame of its body.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Shape {
    /// Outline of a body's mass, counter-clockwise.
    Polygon { corners_m: Vec<[f64; 2]> },
    /// Contact surface of a phalanx: a segment with a radius.
    Capsule { from_m: [f64; 2], to_m: [f64; 2], radius_m: f64 },
    /// A disc about the origin of the body.
    Disc { radius_m: f64 },
    /// Everything below y = level.
    HalfPlane { level_m: f64 },
}

impl Shape {
    /// Centres and radii of discs whose convex hull contains the shape; none for a half plane.
    fn discs(&self) -> Vec<([f64; 2], f64)> {
        match self {
            Shape::Polygon { corners_m } => corners_m.iter().map(|corner| (*corner, 0.0)).collect(),
            Shape::Capsule { from_m, to_m, radius_m } => vec![(*from_m, *radius_m), (*to_m, *radius_m)],
            Shape::Disc { radius_m } => vec![([0.0; 2], *radius_m)],
            Shape::HalfPlane { .. } => Vec::new(),
        }
    }

    /// Converts a shape: a disc if it is round, otherwise a polygon.
    fn from_shape(shape: &shape::Shape) -> Self {
        let polygon = || Shape::Polygon { corners_m: shape.at([0.0; 2]).outline_m() };
        circle_radius(shape).map_or_else(polygon, |radius_m| Shape::Disc { radius_m })
    }

    /// The same shape for a left finger, seen in its mirrored frame.
    fn mirrored(self) -> Self {
        let flip = |[x, y]: [f64; 2]| [x, -y];
        match self {
            Shape::Polygon { corners_m } => {
                Shape::Polygon { corners_m: corners_m.into_iter().rev().map(flip).collect() }
            }
            Shape::Capsule { from_m, to_m, radius_m } => {
                Shape::Capsule { from_m: flip(from_m), to_m: flip(to_m), radius_m }
            }
            other => other,
        }
    }
}

/// Pose of a body's frame in the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    pub position_m: [f64; 2],
    pub angle_rad: f64,
}

impl Pose {
    /// Transforms a point of the body to the world.
    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (s, c) = sin_cos(self.angle_rad);
        [self.position_m[0] + c * x - s * y, self.position_m[1] + s * x + c * y]
    }
}

impl Drawing {
    /// Builds the drawing of a scene of any kind: palm, table, object, and the links of the right finger,
    /// then of the left one; or the bodies of a mechanism.
    pub fn from_scene(scene: &Scene) -> Self {
        if let Some(mechanism) = &scene.mechanism {
            return mechanism::drawing(mechanism);
        }
        let hand = &scene.hand;
        let mut bodies = plane_bodies(hand);
        bodies.extend(hand.object.iter().map(|object| Body {
            name: Object::NAME.to_string(),
            role: BodyRole::Object,
            fixed: object.motion == ObjectMotion::Fixed,
            shapes: vec![Shape::from_shape(&object.shape)],
            marks_m: vec![[0.0; 2]],
        }));
        for (side, finger) in hand.fingers_by_side() {
            bodies.extend(link_bodies(&finger.linkage.lengths).map(|body| Body {
                name: if hand.fingers.len() == 1 { body.name } else { format!("{}_{}", side.name(), body.name) },
                shapes: match side {
                    Side::Right => body.shapes,
                    Side::Left => body.shapes.into_iter().map(Shape::mirrored).collect(),
                },
                ..body
            }));
        }
        let (arrow_m_per_n, longest_arrow_m) = arrow_scale(hand);
        let surfaces = hand.contacts().filter(|contact| !contact.is_stop() && hand.contact_laws(*contact).is_some());
        let contacts = surfaces.map(|contact| contact.name_for(hand.fingers.len())).collect();
        Drawing { contacts, arrow_m_per_n, longest_arrow_m, extent_m: view_extent(hand, &bodies), bodies }
    }

    /// Signed length of the arrow of a force.
    pub fn arrow_m(&self, force_n: f64) -> f64 {
        (force_n * self.arrow_m_per_n).clamp(-self.longest_arrow_m, self.longest_arrow_m)
    }

    /// Longer side of the view.
    pub fn view_m(&self) -> f64 {
        let [low, high] = self.extent_m;
        (high[0] - low[0]).max(high[1] - low[1])
    }
}

/// Poses of the bodies of a scene's [`Drawing`], in their order.
pub fn poses(scene: &Scene, sample: &Sample) -> Vec<Pose> {
    let pose = |body: BodyState| Pose { position_m: body.centre_m, angle_rad: body.angle_rad };
    let posture = |finger: FingerState| {
        let FingerState { q11_rad, q21_rad, q12_rad, q22_rad, .. } = finger;
        Posture { q11_rad, q21_rad, q12_rad, q22_rad }
    };
    if let Some(mechanism) = &scene.mechanism {
        return mechanism::poses(mechanism, sample);
    }
    let postures: Vec<Posture> = sample.fingers().map(posture).collect();
    poses_at(&scene.hand, sample.time_s, sample.bodies().map(pose), &postures)
}

/// Poses of the bodies with the fingers in these postures and everything else at its start.
pub fn poses_for_postures(scene: &Scene, postures: &[Posture]) -> Vec<Pose> {
    poses_at(&scene.hand, 0.0, scene.hand.reported_object().into_iter().map(pose_at_start), postures)
}

/// `reported` is the pose of the object, if samples contain it.
fn poses_at(hand: &Hand, time_s: f64, reported: impl Iterator<Item = Pose>, postures: &[Posture]) -> Vec<Pose> {
    let mut poses: Vec<Pose> = plane_poses(hand, time_s).map(|(pose, _)| pose).collect();
    poses.extend(unreported_object(hand).into_iter().map(pose_at_start).chain(reported));
    for ((side, finger), posture) in hand.fingers_by_side().zip(postures) {
        let half_palm_m = 0.5 * hand.palm_width_m;
        poses.extend(link_poses(&finger.linkage.lengths, posture).map(|pose| {
            let [x, y] = pose.position_m;
            let angle_rad = if side == Side::Right { pose.angle_rad } else { PI - pose.angle_rad };
            Pose { position_m: [side.mirror() * (x + half_palm_m), y], angle_rad }
        }));
    }
    poses
}

/// Time derivatives of [`poses`]: velocities and angular velocities instead of positions and angles.
pub fn velocities(scene: &Scene, sample: &Sample) -> Vec<Pose> {
    if let Some(mechanism) = &scene.mechanism {
        return mechanism::velocities(mechanism, sample);
    }
    let hand = &scene.hand;
    let mut velocities: Vec<Pose> = plane_poses(hand, sample.time_s).map(|(_, motion)| motion).collect();
    velocities.extend(unreported_object(hand).map(|_| Pose::default()));
    velocities.extend(
        sample
            .bodies()
            .map(|BodyState { velocity_m_s, spin_rad_s, .. }| Pose { position_m: velocity_m_s, angle_rad: spin_rad_s }),
    );
    for ((side, finger), state) in hand.fingers_by_side().zip(sample.fingers()) {
        velocities.extend(link_velocities(&finger.linkage.lengths, &state).map(|motion| {
            let [x, y] = motion.position_m;
            Pose { position_m: [side.mirror() * x, y], angle_rad: side.mirror() * motion.angle_rad }
        }));
    }
    velocities
}

/// The object, if samples do not contain it because it is fixed.
fn unreported_object(hand: &Hand) -> Option<&Object> {
    hand.object.as_ref().filter(|_| hand.reported_object().is_none())
}

/// Pose of the object at the start.
fn pose_at_start(object: &Object) -> Pose {
    Pose { position_m: object.centre_m, angle_rad: object.angle_rad }
}

/// Lower left and upper right corner of discs with centres and radii.
fn bounds(discs: &[([f64; 2], f64)]) -> [[f64; 2]; 2] {
    discs.iter().fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], ([x, y], radius)| {
        [[low[0].min(x - radius), low[1].min(y - radius)], [high[0].max(x + radius), high[1].max(y + radius)]]
    })
}

/// Lower left and upper right corner of everything except half planes, with a margin of a tenth, at the start and, if the
/// fingers can close on the object, in their grasp.
fn view_extent(hand: &Hand, bodies: &[Body]) -> [[f64; 2]; 2] {
    // A start whose loop does not close fails before the first step; the straight finger stands in for it.
    let upright = Posture { q11_rad: 0.0, q21_rad: 0.5 * PI, q12_rad: 0.0, q22_rad: 0.0 };
    let postures = hand.fingers_by_side().map(|(side, HandFinger { linkage, initial, .. })| {
        let start = close_loop(&linkage.lengths, linkage.assembly, initial.q11_rad, initial.q21_rad).unwrap_or(upright);
        let grasp = hand.object.as_ref().and_then(|object| {
            let object_in_finger_frame = object.placed().in_finger_frame(side.mirror(), 0.5 * hand.palm_width_m);
            final_posture(&linkage.lengths, linkage.assembly, object_in_finger_frame).ok()
        });
        (start, grasp.map_or(start, |end| end.posture))
    });
    let (start, end): (Vec<Posture>, Vec<Posture>) = postures.unzip();
    let mut discs = Vec::new();
    for postures in [start, end] {
        let poses = poses_at(hand, 0.0, hand.reported_object().into_iter().map(pose_at_start), &postures);
        for (body, pose) in bodies.iter().zip(poses) {
            discs.extend(
                body.shapes.iter().flat_map(Shape::discs).map(|(point, radius_m)| (pose.apply(point), radius_m)),
            );
        }
    }
    let [low, high] = bounds(&discs);
    let margin = 0.1 * (high[0] - low[0]).max(high[1] - low[1]);
    [low.map(|low| low - margin), high.map(|high| high + margin)]
}

/// Returns the four links with their outlines and contact surfaces.
fn link_bodies(lengths: &Lengths) -> [Body; 4] {
    let w = lengths.half_width_m;
    let link = |name: &str, role, shapes, marks_m| Body { name: name.to_string(), role, fixed: false, shapes, marks_m };
    let body = |name, role, shapes| link(name, role, shapes, vec![[0.0; 2]]);
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
        link("l12", BodyRole::Coupler, vec![bar(lengths.l12_m)], vec![[0.0; 2], [lengths.l12_m, 0.0]]),
        body("l21", BodyRole::Proximal, vec![bar(lengths.l21_m), surface(0.0, lengths.l21_m)]),
        body("l22", BodyRole::Distal, distal),
    ]
}

/// Poses of the links: l11 and l21 rotate about the origin, l12 about A12, the distal body about A22 with its x-axis
/// along the arm.
fn link_poses(lengths: &Lengths, posture: &Posture) -> [Pose; 4] {
    let Lengths { l11_m, l21_m, .. } = *lengths;
    let along = |length: f64, angle: f64| [length * cos(angle), length * sin(angle)];
    let Posture { q11_rad, q21_rad, q12_rad, q22_rad } = *posture;
    [
        Pose { position_m: [0.0; 2], angle_rad: q11_rad },
        Pose { position_m: along(l11_m, q11_rad), angle_rad: q11_rad + q12_rad },
        Pose { position_m: [0.0; 2], angle_rad: q21_rad },
        Pose { position_m: along(l21_m, q21_rad), angle_rad: q21_rad + q22_rad },
    ]
}

/// Time derivatives of the poses: velocities and angular velocities instead of positions and angles.
fn link_velocities(lengths: &Lengths, finger: &FingerState) -> [Pose; 4] {
    let Lengths { l11_m, l21_m, .. } = *lengths;
    // d/dt of L (cos q, sin q).
    let end_velocity = |length: f64, q: f64, rate: f64| [-length * rate * sin(q), length * rate * cos(q)];
    let FingerState { q11_rad, q21_rad, qd11_rad_s, qd12_rad_s, qd21_rad_s, qd22_rad_s, .. } = *finger;
    [
        Pose { position_m: [0.0; 2], angle_rad: qd11_rad_s },
        Pose { position_m: end_velocity(l11_m, q11_rad, qd11_rad_s), angle_rad: qd11_rad_s + qd12_rad_s },
        Pose { position_m: [0.0; 2], angle_rad: qd21_rad_s },
        Pose { position_m: end_velocity(l21_m, q21_rad, qd21_rad_s), angle_rad: qd21_rad_s + qd22_rad_s },
    ]
}

/// Returns the existing planes, in the order of their poses.
fn plane_bodies(hand: &Hand) -> Vec<Body> {
    let plane = |name: &str, fixed: bool, level_m: f64| Body {
        name: name.to_string(),
        role: BodyRole::Palm,
        fixed,
        shapes: vec![Shape::HalfPlane { level_m }],
        marks_m: Vec::new(),
    };
    let palm = hand.palm.map(|palm| plane("palm", true, palm.level_m));
    // The pose contains the level.
    let table = hand.table.map(|_| plane("table", hand.palm_motion.is_none(), 0.0));
    palm.into_iter().chain(table).collect()
}

/// Poses and velocities of the planes.
fn plane_poses(hand: &Hand, time_s: f64) -> impl Iterator<Item = (Pose, Pose)> {
    let palm = hand.palm.map(|_| (Pose::default(), Pose::default()));
    palm.into_iter().chain(hand.table.map(|surface| table(surface.level_m, hand.palm_motion.as_ref(), time_s)))
}

/// Pose and velocity of a table, solid above its level, which is at rest in the world while the palm moves. The origin
/// is the table point above the palm's origin; sliding along the surface is not visible and is ignored.
fn table(level_m: f64, palm: Option<&PalmMotion>, time_s: f64) -> (Pose, Pose) {
    let palm = palm.map_or_else(Default::default, |motion| motion.pose(time_s));
    let ([_, y, angle], [_, rise, turning]) = (palm.position, palm.rate);
    let ((sin, cos), height) = (sin_cos(angle), level_m - y);
    let pose = Pose { position_m: [height * sin, height * cos], angle_rad: PI - angle };
    let velocity = [turning * height * cos - rise * sin, -turning * height * sin - rise * cos];
    (pose, Pose { position_m: velocity, angle_rad: -turning })
}

/// Arrow length per newton, and the largest arrow length. The arrow of a usual force is about half as long as a
/// phalanx.
fn arrow_scale(hand: &Hand) -> (f64, f64) {
    // The largest torque on a driven link.
    let motors = hand.fingers.iter().map(|finger| finger.motor.actuation.largest());
    let input = hand.differential.as_ref().map(|input| 0.5 * input.motor.actuation.largest());
    let torque_n_m = motors.chain(input).fold(0.0, f64::max);
    let lengths = &hand.finger(Side::Right).linkage.lengths;
    let typical_n = torque_n_m / lengths.l11_m;
    (0.5 * lengths.l21_m / if typical_n > 0.0 { typical_n } else { 1.0 }, lengths.l21_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Axis, Move};

    /// The palm rises and turns; the table sinks and turns back, and its velocities match differences of its poses.
    #[test]
    fn a_table_at_rest_moves_against_the_palm() {
        let single_move = |axis, distance| Move { axis, distance, start_s: 0.1, length_s: 0.2 };
        let moves = vec![single_move(Axis::X, 0.2), single_move(Axis::Y, -0.03), single_move(Axis::Angle, 0.4)];
        let motion = PalmMotion { moves, ..PalmMotion::default() };
        let at = |time_s: f64| table(0.04, Some(&motion), time_s);
        assert_eq!(at(0.05), table(0.04, None, 0.05));
        let palm = motion.pose(0.17).position;
        let (pose, rates) = at(0.17);
        let in_world = |[x, y]: [f64; 2]| {
            let (sin, cos) = palm[2].sin_cos();
            [palm[0] + cos * x - sin * y, palm[1] + sin * x + cos * y]
        };
        for along_m in [-0.1, 0.0, 0.3] {
            let [_, y] = in_world(pose.apply([along_m, 0.0]));
            assert!((y - 0.04).abs() < 1e-15, "{y}");
        }
        let [_, beyond] = in_world(pose.apply([0.0, -0.01]));
        assert!((beyond - 0.05).abs() < 1e-15, "the table is solid above its level: {beyond}");
        let (ahead, behind) = (at(0.17 + 1e-6).0, at(0.17 - 1e-6).0);
        for (rate, [ahead, behind]) in [
            (rates.position_m[0], [ahead.position_m[0], behind.position_m[0]]),
            (rates.position_m[1], [ahead.position_m[1], behind.position_m[1]]),
            (rates.angle_rad, [ahead.angle_rad, behind.angle_rad]),
        ] {
            assert!((rate - (ahead - behind) / 2e-6).abs() < 1e-7, "{rate}");
        }
    }
}
