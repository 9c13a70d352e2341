//! A gripper: two fingers, their object, palm and table.

use super::finger::{link_motions, link_poses, links, peak_torque, posture_of};
use super::parts::{Body, Drawing, Part, Pose, Shape, extent};
use crate::gripper::{Lengths, Posture, close, final_posture};
use crate::numeric::elementary::sin_cos;
use crate::scene::{GripperScene, ObjectMotion, PalmMotion, Place, Side};
use crate::trace::{BodyState, Sample};

/// What a gripper looks like: palm, table, object, the links of the right finger, those of the left one.
pub fn gripper(scene: &GripperScene) -> Drawing {
    let mut bodies = Vec::with_capacity(11);
    let plane = |name: &str, fixed: bool| Body {
        name: name.to_string(),
        part: Part::Palm,
        fixed,
        shapes: vec![Shape::HalfPlane { level_m: 0.0 }],
    };
    bodies.extend(scene.palm.map(|_| plane("palm", true)));
    bodies.extend(scene.table.map(|_| plane("table", scene.palm_motion.is_none())));
    bodies.push(Body {
        name: "object".to_string(),
        part: Part::Object,
        fixed: scene.object.motion == ObjectMotion::Fixed,
        shapes: vec![Shape::Disc { radius_m: scene.object.radius_m }],
    });
    for side in Side::BOTH {
        bodies.extend(links(&scene.finger(side).finger.lengths).map(|body| Body {
            name: format!("{}_{}", side.word(), body.name),
            shapes: body.shapes.into_iter().map(|shape| mirrored(shape, side)).collect(),
            ..body
        }));
    }
    let Lengths { l11_m, l21_m, .. } = scene.finger(Side::Right).finger.lengths;
    let usual_n = largest_torque(scene) / l11_m;
    Drawing {
        contacts: places(scene).map(Place::name).collect(),
        arrow_m_per_n: 0.5 * l21_m / if usual_n > 0.0 { usual_n } else { 1.0 },
        longest_arrow_m: l21_m,
        extent_m: view(scene, &bodies),
        bodies,
    }
}

/// The contacts between surfaces that the scene has.
pub fn places(scene: &GripperScene) -> impl Iterator<Item = Place> {
    Place::ALL.into_iter().filter(|place| match place {
        Place::Palm => scene.palm.is_some(),
        Place::Table => scene.table.is_some(),
        Place::Finger(..) => !place.is_stop(),
    })
}

/// Where the bodies of [`gripper`] are, in their order.
pub fn gripper_poses(scene: &GripperScene, sample: &Sample) -> Vec<Pose> {
    let BodyState { centre_m, angle_rad, .. } = sample.bodies[0];
    let postures = [0, 1].map(|index| posture_of(&sample.fingers[index]));
    poses_at(scene, sample.time_s, Pose { position_m: centre_m, angle_rad }, postures)
}

fn poses_at(scene: &GripperScene, time_s: f64, object: Pose, postures: [Posture; 2]) -> Vec<Pose> {
    let mut poses: Vec<Pose> = planes(scene, time_s).map(|(pose, _)| pose).collect();
    poses.push(object);
    for (side, posture) in Side::BOTH.into_iter().zip(postures) {
        let half_palm_m = 0.5 * scene.palm_width_m;
        poses.extend(link_poses(&scene.finger(side).finger.lengths, &posture).map(|pose| {
            let [x, y] = pose.position_m;
            let angle_rad = if side == Side::Right { pose.angle_rad } else { std::f64::consts::PI - pose.angle_rad };
            Pose { position_m: [side.mirror() * (x + half_palm_m), y], angle_rad }
        }));
    }
    poses
}

/// How fast these change: velocities and angular velocities in place of positions and angles.
pub fn gripper_motions(scene: &GripperScene, sample: &Sample) -> Vec<Pose> {
    let BodyState { velocity_m_s, spin_rad_s, .. } = sample.bodies[0];
    let mut motions: Vec<Pose> = planes(scene, sample.time_s).map(|(_, motion)| motion).collect();
    motions.push(Pose { position_m: velocity_m_s, angle_rad: spin_rad_s });
    for (side, finger) in Side::BOTH.into_iter().zip(&sample.fingers) {
        motions.extend(link_motions(&scene.finger(side).finger.lengths, finger).map(|motion| {
            let [x, y] = motion.position_m;
            Pose { position_m: [side.mirror() * x, y], angle_rad: side.mirror() * motion.angle_rad }
        }));
    }
    motions
}

/// Palm and table in the palm's frame, and how they move there.
fn planes(scene: &GripperScene, time_s: f64) -> impl Iterator<Item = (Pose, Pose)> {
    let palm = scene.palm.map(|_| (Pose::default(), Pose::default()));
    palm.into_iter().chain(scene.table.map(|of| table(of.level_m, scene.palm_motion.as_ref(), time_s)))
}

/// A table, solid above its level, which stays where it is as the palm moves; its origin is the point of it that is over the palm's: how
/// it slides along itself nobody sees.
fn table(level_m: f64, palm: Option<&PalmMotion>, time_s: f64) -> (Pose, Pose) {
    let palm = palm.map_or_else(Default::default, |motion| motion.pose(time_s));
    let ([_, y, angle], [_, rise, turning]) = (palm.place, palm.rate);
    let ((sin, cos), height) = (sin_cos(angle), level_m - y);
    let pose = Pose { position_m: [height * sin, height * cos], angle_rad: std::f64::consts::PI - angle };
    let velocity = [turning * height * cos - rise * sin, -turning * height * sin - rise * cos];
    (pose, Pose { position_m: velocity, angle_rad: -turning })
}

/// A shape of a link as the finger of a side has it.
fn mirrored(shape: Shape, side: Side) -> Shape {
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

/// The start and, where the fingers can close on the object, their grasp of it.
fn view(scene: &GripperScene, bodies: &[Body]) -> [[f64; 2]; 2] {
    let upright = Posture { q11_rad: 0.0, q21_rad: 0.5 * std::f64::consts::PI, q12_rad: 0.0, q22_rad: 0.0 };
    let [x, y] = scene.object.centre_m;
    let postures = Side::BOTH.map(|side| {
        let (of, start) = (&scene.finger(side).finger, &scene.finger(side).initial);
        let start = close(&of.lengths, of.assembly, start.q11_rad, start.q21_rad).unwrap_or(upright);
        let centre_m = [side.mirror() * x - 0.5 * scene.palm_width_m, y];
        let disc = crate::gripper::Circle { radius_m: scene.object.radius_m, centre_m };
        [start, final_posture(&of.lengths, of.assembly, disc).map_or(start, |end| end.posture)]
    });
    let object = Pose { position_m: scene.object.centre_m, angle_rad: scene.object.angle_rad };
    let places: Vec<(&Body, Pose)> = [0, 1]
        .into_iter()
        .flat_map(|at| bodies.iter().zip(poses_at(scene, 0.0, object, postures.map(|postures| postures[at]))))
        .collect();
    extent(&places)
}

/// Largest torque on a driven link.
fn largest_torque(scene: &GripperScene) -> f64 {
    let motors = scene.fingers.iter().map(|finger| peak_torque(&finger.motor.actuation));
    let input = scene.differential.as_ref().map(|input| 0.5 * peak_torque(&input.motor.actuation));
    motors.chain(input).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Axis, Move};

    /// It rises and turns: the table sinks and turns back, at rates that are those of its places.
    #[test]
    fn a_table_stays_where_it_is_as_the_palm_moves() {
        let one = |axis, distance| Move { axis, distance, start_s: 0.1, length_s: 0.2 };
        let moves = vec![one(Axis::X, 0.2), one(Axis::Y, -0.03), one(Axis::Angle, 0.4)];
        let motion = PalmMotion { moves, ..PalmMotion::default() };
        let at = |time_s: f64| table(0.04, Some(&motion), time_s);
        assert_eq!(at(0.05), table(0.04, None, 0.05));
        let palm = motion.pose(0.17).place;
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
        assert!((beyond - 0.05).abs() < 1e-15, "it is solid above: {beyond}");
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
