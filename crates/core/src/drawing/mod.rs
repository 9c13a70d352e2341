//! What a scene looks like: the shapes of its bodies, each in its own frame, and where these frames are at an instant.
//!
//! The pictures in a log and the page with the moving finger are both drawn from this, so they show the same bodies.
//!
//! | file | job |
//! |---|---|
//! | `parts` | what a drawing is made of |
//! | `links`, `planes` | the links of a finger; palm, ground and table |
//! | `arrows` | how long forces are drawn |

mod arrows;
mod links;
mod parts;
mod planes;

use std::f64::consts::PI;

pub use parts::{Body, Drawing, Part, Pose, Shape};

use crate::gripper::{Posture, close, final_posture};
use crate::scene::{Disc, DrivenFinger, Scene, Side, System, Touching};
use crate::trace::{BodyState, FingerState, Sample};
use arrows::arrows;
use links::{link_motions, link_poses, links, mirrored};
use parts::extent;
use planes::{plane_poses, planes};

impl Drawing {
    /// Of a scene of any kind: palm, table, discs in their order, and the links of the right finger, then of the left one.
    pub fn of(scene: &Scene) -> Self {
        let system = &scene.system;
        let mut bodies = planes(system);
        let part = if system.fingers.is_empty() { Part::Disc } else { Part::Object };
        bodies.extend(system.discs.iter().map(|disc| Body {
            name: disc.name.clone(),
            part,
            fixed: !disc.motion.moves(),
            shapes: vec![Shape::of(&disc.shape)],
        }));
        for (side, finger) in system.sided() {
            bodies.extend(links(&finger.linkage.lengths).map(|body| Body {
                name: if system.fingers.len() == 1 { body.name } else { format!("{}_{}", side.word(), body.name) },
                shapes: body.shapes.into_iter().map(|shape| mirrored(shape, side)).collect(),
                ..body
            }));
        }
        let (arrow_m_per_n, longest_arrow_m) = arrows(system);
        Drawing { contacts: contacts(system), arrow_m_per_n, longest_arrow_m, extent_m: view(system, &bodies), bodies }
    }

    /// Length of the arrow of a force, with its sign.
    pub fn arrow_m(&self, force_n: f64) -> f64 {
        (force_n * self.arrow_m_per_n).clamp(-self.longest_arrow_m, self.longest_arrow_m)
    }

    /// The longer side of the view.
    pub fn view_m(&self) -> f64 {
        let [low, high] = self.extent_m;
        (high[0] - low[0]).max(high[1] - low[1])
    }
}

/// Names of the contacts between surfaces that are there.
fn contacts(system: &System) -> Vec<String> {
    let is_there = |touching: &Touching| !touching.is_stop() && system.laws(*touching).is_some();
    system.touching().into_iter().filter(is_there).map(|touching| system.touching_name(touching)).collect()
}

/// Where the bodies of a scene's [`Drawing`] are, in their order.
pub fn poses(scene: &Scene, sample: &Sample) -> Vec<Pose> {
    let pose = |body: &BodyState| Pose { position_m: body.centre_m, angle_rad: body.angle_rad };
    let postures = sample.fingers.iter().map(posture_of).collect::<Vec<_>>();
    poses_at(&scene.system, sample.time_s, sample.bodies.iter().map(pose), &postures)
}

/// The same of fingers in these postures, with all else as it starts.
pub fn poses_in(scene: &Scene, postures: &[Posture]) -> Vec<Pose> {
    poses_at(&scene.system, 0.0, scene.system.told_discs().iter().map(start), postures)
}

/// `told` are the discs that samples tell of.
fn poses_at(system: &System, time_s: f64, told: impl Iterator<Item = Pose>, postures: &[Posture]) -> Vec<Pose> {
    let mut poses: Vec<Pose> = plane_poses(system, time_s).map(|(pose, _)| pose).collect();
    poses.extend(untold(system).map(start).chain(told));
    for ((side, finger), posture) in system.sided().zip(postures) {
        let half_palm_m = 0.5 * system.palm_width_m;
        poses.extend(link_poses(&finger.linkage.lengths, posture).map(|pose| {
            let [x, y] = pose.position_m;
            let angle_rad = if side == Side::Right { pose.angle_rad } else { PI - pose.angle_rad };
            Pose { position_m: [side.mirror() * (x + half_palm_m), y], angle_rad }
        }));
    }
    poses
}

/// How fast these change: velocities and angular velocities in place of positions and angles.
pub fn motions(scene: &Scene, sample: &Sample) -> Vec<Pose> {
    let system = &scene.system;
    let mut motions: Vec<Pose> = plane_poses(system, sample.time_s).map(|(_, motion)| motion).collect();
    motions.extend(untold(system).map(|_| Pose::default()));
    motions.extend(
        sample.bodies.iter().map(|BodyState { velocity_m_s, spin_rad_s, .. }| Pose {
            position_m: *velocity_m_s,
            angle_rad: *spin_rad_s,
        }),
    );
    for ((side, finger), state) in system.sided().zip(&sample.fingers) {
        motions.extend(link_motions(&finger.linkage.lengths, state).map(|motion| {
            let [x, y] = motion.position_m;
            Pose { position_m: [side.mirror() * x, y], angle_rad: side.mirror() * motion.angle_rad }
        }));
    }
    motions
}

/// Discs that no sample tells of, for they do not move.
fn untold(system: &System) -> impl Iterator<Item = &Disc> {
    system.discs[..system.discs.len() - system.told_discs().len()].iter()
}

/// Where a disc starts.
fn start(disc: &Disc) -> Pose {
    Pose { position_m: disc.centre_m, angle_rad: disc.angle_rad }
}

fn posture_of(finger: &FingerState) -> Posture {
    Posture { q11_rad: finger.q11_rad, q21_rad: finger.q21_rad, q12_rad: finger.q12_rad, q22_rad: finger.q22_rad }
}

/// The start and, where the fingers can close on what they grasp, their grasp of it.
fn view(system: &System, bodies: &[Body]) -> [[f64; 2]; 2] {
    // A start that does not close is the end of a run before its first step: the straight finger shows what was meant.
    let upright = Posture { q11_rad: 0.0, q21_rad: 0.5 * PI, q12_rad: 0.0, q22_rad: 0.0 };
    let postures = system.sided().map(|(side, DrivenFinger { linkage, initial, .. })| {
        let start = close(&linkage.lengths, linkage.assembly, initial.q11_rad, initial.q21_rad).unwrap_or(upright);
        let grasp = system.object().and_then(|object| {
            let seen = object.placed().in_finger(side.mirror(), 0.5 * system.palm_width_m);
            final_posture(&linkage.lengths, linkage.assembly, seen).ok()
        });
        [start, grasp.map_or(start, |end| end.posture)]
    });
    let postures: Vec<[Posture; 2]> = postures.collect();
    let at = |index: usize| {
        let postures: Vec<Posture> = postures.iter().map(|posture| posture[index]).collect();
        bodies.iter().zip(poses_at(system, 0.0, system.told_discs().iter().map(start), &postures))
    };
    extent(&[0, 1].into_iter().flat_map(at).collect::<Vec<_>>())
}
