//! Drawing of a scene: the shapes of its bodies in their own frames, and the poses of these frames at an instant.
//!
//! The pictures in a log and the animated page both use this module, so they show the same bodies.
//!
//! | file | contents |
//! |---|---|
//! | `body` | bodies, shapes and poses of a drawing |
//! | `links`, `planes` | the links of a finger; palm, ground and table |
//! | `arrows` | length of force arrows |

mod arrows;
mod body;
mod links;
mod planes;

use std::f64::consts::PI;

pub use body::{Body, BodyRole, Drawing, Pose, Shape};

use crate::gripper::{Posture, close_loop, final_posture};
use crate::scene::{ContactId, Disc, DrivenFinger, Scene, Side, System};
use crate::trace::{BodyState, FingerState, Sample};
use arrows::arrow_scale;
use body::view_extent;
use links::{link_bodies, link_poses, link_velocities, mirrored};
use planes::{plane_bodies, plane_poses};

impl Drawing {
    /// Builds the drawing of a scene of any kind: palm, table, discs in their order, and the links of the right finger,
    /// then of the left one.
    pub fn from_scene(scene: &Scene) -> Self {
        let system = &scene.system;
        let mut bodies = plane_bodies(system);
        let role = if system.fingers.is_empty() { BodyRole::Disc } else { BodyRole::Object };
        bodies.extend(system.discs.iter().map(|disc| Body {
            name: disc.name.clone(),
            role,
            fixed: !disc.motion.moves(),
            shapes: vec![Shape::from_shape(&disc.shape)],
        }));
        for (side, finger) in system.fingers_by_side() {
            bodies.extend(link_bodies(&finger.linkage.lengths).map(|body| Body {
                name: if system.fingers.len() == 1 { body.name } else { format!("{}_{}", side.name(), body.name) },
                shapes: body.shapes.into_iter().map(|shape| mirrored(shape, side)).collect(),
                ..body
            }));
        }
        let (arrow_m_per_n, longest_arrow_m) = arrow_scale(system);
        Drawing { contacts: contacts(system), arrow_m_per_n, longest_arrow_m, extent_m: view(system, &bodies), bodies }
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

/// Names of the existing contacts between surfaces.
fn contacts(system: &System) -> Vec<String> {
    let exists = |contact: &ContactId| !contact.is_stop() && system.contact_laws(*contact).is_some();
    system.contact_ids().into_iter().filter(exists).map(|contact| system.contact_name(contact)).collect()
}

/// Poses of the bodies of a scene's [`Drawing`], in their order.
pub fn poses(scene: &Scene, sample: &Sample) -> Vec<Pose> {
    let pose = |body: &BodyState| Pose { position_m: body.centre_m, angle_rad: body.angle_rad };
    let postures = sample.fingers.iter().map(finger_posture).collect::<Vec<_>>();
    poses_at(&scene.system, sample.time_s, sample.bodies.iter().map(pose), &postures)
}

/// Poses of the bodies with the fingers in these postures and everything else at its start.
pub fn poses_for_postures(scene: &Scene, postures: &[Posture]) -> Vec<Pose> {
    poses_at(&scene.system, 0.0, scene.system.reported_discs().iter().map(pose_at_start), postures)
}

/// `reported` are the poses of the discs that samples contain.
fn poses_at(system: &System, time_s: f64, reported: impl Iterator<Item = Pose>, postures: &[Posture]) -> Vec<Pose> {
    let mut poses: Vec<Pose> = plane_poses(system, time_s).map(|(pose, _)| pose).collect();
    poses.extend(unreported_discs(system).map(pose_at_start).chain(reported));
    for ((side, finger), posture) in system.fingers_by_side().zip(postures) {
        let half_palm_m = 0.5 * system.palm_width_m;
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
    let system = &scene.system;
    let mut velocities: Vec<Pose> = plane_poses(system, sample.time_s).map(|(_, motion)| motion).collect();
    velocities.extend(unreported_discs(system).map(|_| Pose::default()));
    velocities.extend(
        sample.bodies.iter().map(|BodyState { velocity_m_s, spin_rad_s, .. }| Pose {
            position_m: *velocity_m_s,
            angle_rad: *spin_rad_s,
        }),
    );
    for ((side, finger), state) in system.fingers_by_side().zip(&sample.fingers) {
        velocities.extend(link_velocities(&finger.linkage.lengths, state).map(|motion| {
            let [x, y] = motion.position_m;
            Pose { position_m: [side.mirror() * x, y], angle_rad: side.mirror() * motion.angle_rad }
        }));
    }
    velocities
}

/// Discs that samples do not contain because they are fixed.
fn unreported_discs(system: &System) -> impl Iterator<Item = &Disc> {
    system.discs[..system.discs.len() - system.reported_discs().len()].iter()
}

/// Pose of a disc at the start.
fn pose_at_start(disc: &Disc) -> Pose {
    Pose { position_m: disc.centre_m, angle_rad: disc.angle_rad }
}

fn finger_posture(finger: &FingerState) -> Posture {
    Posture { q11_rad: finger.q11_rad, q21_rad: finger.q21_rad, q12_rad: finger.q12_rad, q22_rad: finger.q22_rad }
}

/// Corners of a view of the start and, if the fingers can close on the object, of their grasp.
fn view(system: &System, bodies: &[Body]) -> [[f64; 2]; 2] {
    // A start whose loop does not close fails before the first step; the straight finger stands in for it.
    let upright = Posture { q11_rad: 0.0, q21_rad: 0.5 * PI, q12_rad: 0.0, q22_rad: 0.0 };
    let postures = system.fingers_by_side().map(|(side, DrivenFinger { linkage, initial, .. })| {
        let start = close_loop(&linkage.lengths, linkage.assembly, initial.q11_rad, initial.q21_rad).unwrap_or(upright);
        let grasp = system.object().and_then(|object| {
            let object_in_finger_frame = object.placed().in_finger_frame(side.mirror(), 0.5 * system.palm_width_m);
            final_posture(&linkage.lengths, linkage.assembly, object_in_finger_frame).ok()
        });
        [start, grasp.map_or(start, |end| end.posture)]
    });
    let postures: Vec<[Posture; 2]> = postures.collect();
    let initial_poses = |index: usize| {
        let postures: Vec<Posture> = postures.iter().map(|posture| posture[index]).collect();
        bodies.iter().zip(poses_at(system, 0.0, system.reported_discs().iter().map(pose_at_start), &postures))
    };
    view_extent(&[0, 1].into_iter().flat_map(initial_poses).collect::<Vec<_>>())
}
