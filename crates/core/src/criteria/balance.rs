//! A gripper of a scene at rest in its hand, for [`balanced_acceleration`](crate::statics::balanced_acceleration).

use super::stance::{friction, normal_forces, stance};
use crate::gripper::Site;
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::rotate;
use crate::scene::{DiscMotion, Motor, Place, Scene, Side, torque};
use crate::statics::{Drive, HandAtRest, PerContact, Stance};
use crate::trace::Sample;

/// What holds the fingers while the palm is accelerated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Driven {
    /// Motors give their torque, and brakes as much as they hold, against opening only where they are one-way. A motor without a brake is
    /// blocked whatever it takes; of a differential the input is.
    Blocked,
    /// Motors give their torque, and nothing blocks them.
    AtTorque,
}

impl Driven {
    pub const BOTH: [Self; 2] = [Driven::Blocked, Driven::AtTorque];
}

/// A posture of a scene's gripper, and what presses in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pressed<'a> {
    pub stance: Stance<'a>,
    /// Phalanges and palm; a table is none of them: the gripper carries its object away from it.
    pub touching: PerContact<bool>,
    /// Whether tips are on their joint limits, right and left.
    pub limits: [bool; 2],
    /// When, s: motors have their torque, and the palm its angle, of then.
    pub time_s: f64,
}

/// What presses in a sample of a run.
pub fn pressed<'a>(scene: &'a Scene, sample: &Sample) -> Pressed<'a> {
    let limit = |side| sample.contacts[Place::Finger(side, Site::Limit).index()].normal_n > 0.0;
    Pressed {
        stance: stance(scene, sample),
        touching: normal_forces(sample).map(|normal_n| normal_n > 0.0),
        limits: Side::BOTH.map(limit),
        time_s: sample.time_s,
    }
}

/// The gripper at rest with what presses; `None` where its object is fixed, which nothing need hold.
pub fn hand_at_rest<'a>(scene: &'a Scene, pressed: &Pressed<'a>, driven: Driven) -> Option<HandAtRest<'a>> {
    let DiscMotion::Free { mass_kg, .. } = scene.system.grasped().motion else { return None };
    let Pressed { stance, touching, limits, time_s } = *pressed;
    let drive = |motor: &Motor, weights: [f64; 2]| Drive {
        weights,
        torque_n_m: torque(&motor.actuation, time_s).0,
        brake_n_m: match (driven, motor.brake) {
            (Driven::AtTorque, _) => [0.0; 2],
            (Driven::Blocked, None) => [f64::NEG_INFINITY, f64::INFINITY],
            (Driven::Blocked, Some(brake)) => [if brake.one_way { 0.0 } else { -brake.torque_n_m }, brake.torque_n_m],
        },
    };
    let drives = match &scene.system.differential {
        Some(differential) => vec![drive(&differential.motor, [0.5, 0.5])],
        None => vec![
            drive(&scene.system.finger(Side::Right).motor, [1.0, 0.0]),
            drive(&scene.system.finger(Side::Left).motor, [0.0, 1.0]),
        ],
    };
    let (sin, cos) = sin_cos(scene.system.palm_motion.as_ref().map_or(0.0, |motion| motion.pose(time_s).place[2]));
    Some(HandAtRest {
        stance,
        friction: friction(scene).with(touching, |mu, touches| touches.then_some(mu)),
        limits,
        springs: Side::BOTH.map(|side| scene.system.finger(side).spring),
        drives,
        mass_kg,
        gravity_m_s2: rotate(scene.system.gravity_m_s2, [cos, -sin]),
    })
}

/// [`hand_at_rest`] with what presses in a sample of a run.
pub fn held_at_rest<'a>(scene: &'a Scene, sample: &Sample, driven: Driven) -> Option<HandAtRest<'a>> {
    hand_at_rest(scene, &pressed(scene, sample), driven)
}
