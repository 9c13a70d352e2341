//! A gripper: two fingers, their object, palm and table.

use super::finger::{link_motions, link_poses, links, peak_torque, posture_of};
use super::parts::{Body, Drawing, Part, Pose, Shape, extent};
use crate::gripper::{Lengths, Posture, close, final_posture};
use crate::scene::{GripperScene, ObjectMotion, Place, Side};
use crate::trace::{BodyState, Sample};

/// What a gripper looks like: palm, table, object, the links of the right finger, those of the left one.
pub fn gripper(scene: &GripperScene) -> Drawing {
    let mut bodies = Vec::with_capacity(11);
    let plane = |name: &str| Body {
        name: name.to_string(),
        part: Part::Palm,
        fixed: true,
        shapes: vec![Shape::HalfPlane { level_m: 0.0 }],
    };
    bodies.extend(scene.palm.map(|_| plane("palm")));
    bodies.extend(scene.table.map(|_| plane("table")));
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
    poses_at(scene, Pose { position_m: centre_m, angle_rad }, postures)
}

fn poses_at(scene: &GripperScene, object: Pose, postures: [Posture; 2]) -> Vec<Pose> {
    let mut poses = planes(scene);
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
    let mut motions = vec![Pose::default(); planes(scene).len()];
    motions.push(Pose { position_m: velocity_m_s, angle_rad: spin_rad_s });
    for (side, finger) in Side::BOTH.into_iter().zip(&sample.fingers) {
        motions.extend(link_motions(&scene.finger(side).finger.lengths, finger).map(|motion| {
            let [x, y] = motion.position_m;
            Pose { position_m: [side.mirror() * x, y], angle_rad: side.mirror() * motion.angle_rad }
        }));
    }
    motions
}

/// Palm and table, which is solid above its level.
fn planes(scene: &GripperScene) -> Vec<Pose> {
    let table = |level_m| Pose { position_m: [0.0, level_m], angle_rad: std::f64::consts::PI };
    let table = scene.table.map(|of| table(of.level_m));
    scene.palm.map(|_| Pose::default()).into_iter().chain(table).collect()
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
        .flat_map(|at| bodies.iter().zip(poses_at(scene, object, postures.map(|postures| postures[at]))))
        .collect();
    extent(&places)
}

/// Largest torque on a driven link.
fn largest_torque(scene: &GripperScene) -> f64 {
    let motors = scene.fingers.iter().map(|finger| peak_torque(&finger.motor.actuation));
    let input = scene.differential.as_ref().map(|input| 0.5 * peak_torque(&input.motor.actuation));
    motors.chain(input).fold(0.0, f64::max)
}
