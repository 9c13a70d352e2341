//! A gripper at rest with its object, for [`balanced_acceleration`](crate::statics::balanced_acceleration).

use super::grasp_configuration::{friction_coefficients, grasp_configuration, normal_forces};
use crate::gripper::FingerContact;
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::rotate;
use crate::scene::{DiscMotion, GripperContact, Motor, Scene, Side, torque};
use crate::statics::{Drive, GraspConfiguration, HandAtRest, PerContact};
use crate::trace::Sample;

/// Whether drives resist being driven back while the palm is accelerated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveMode {
    /// Motors exert their torque, and brakes up to their holding torque; one-way brakes only resist opening. A motor
    /// without a brake is blocked at any torque. With a differential, this applies to its input.
    Blocked,
    /// Motors exert their torque, and nothing blocks them.
    AtTorque,
}

impl DriveMode {
    pub const BOTH: [Self; 2] = [DriveMode::Blocked, DriveMode::AtTorque];
}

/// Configuration of a gripper and its active contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraspState<'a> {
    pub configuration: GraspConfiguration<'a>,
    /// Active contacts of phalanges and palm. The table is excluded, because the gripper lifts its object from it.
    pub active: PerContact<bool>,
    /// Whether the joint limits are active, right and left.
    pub at_limit: [bool; 2],
    /// Time at which motor torques and palm angle are evaluated, s.
    pub time_s: f64,
}

/// Returns the grasp state of a sample.
pub fn grasp_state<'a>(scene: &'a Scene, sample: &Sample) -> GraspState<'a> {
    let is_at_limit = |side| sample.contacts[GripperContact::Finger(side, FingerContact::Limit).index()].normal_n > 0.0;
    GraspState {
        configuration: grasp_configuration(scene, sample),
        active: normal_forces(sample).map(|normal_n| normal_n > 0.0),
        at_limit: Side::BOTH.map(is_at_limit),
        time_s: sample.time_s,
    }
}

/// Returns the gripper at rest with its active contacts; `None` if its object is fixed.
pub fn hand_at_rest<'a>(scene: &'a Scene, grasp_state: &GraspState<'a>, mode: DriveMode) -> Option<HandAtRest<'a>> {
    let DiscMotion::Free { mass_kg, .. } = scene.system.grasped().motion else { return None };
    let GraspState { configuration, active, at_limit, time_s } = *grasp_state;
    let drive = |motor: &Motor, weights: [f64; 2]| Drive {
        weights,
        torque_n_m: torque(&motor.actuation, time_s).0,
        brake_n_m: match (mode, motor.brake) {
            (DriveMode::AtTorque, _) => [0.0; 2],
            (DriveMode::Blocked, None) => [f64::NEG_INFINITY, f64::INFINITY],
            (DriveMode::Blocked, Some(brake)) => {
                [if brake.one_way { 0.0 } else { -brake.torque_n_m }, brake.torque_n_m]
            }
        },
    };
    let drives = match &scene.system.differential {
        Some(differential) => vec![drive(&differential.motor, [0.5, 0.5])],
        None => vec![
            drive(&scene.system.finger(Side::Right).motor, [1.0, 0.0]),
            drive(&scene.system.finger(Side::Left).motor, [0.0, 1.0]),
        ],
    };
    let (sin, cos) = sin_cos(scene.system.palm_motion.as_ref().map_or(0.0, |motion| motion.pose(time_s).position[2]));
    Some(HandAtRest {
        configuration,
        friction: friction_coefficients(scene).zip_with(active, |mu, is_active| is_active.then_some(mu)),
        limits: at_limit,
        springs: Side::BOTH.map(|side| scene.system.finger(side).spring),
        drives,
        mass_kg,
        gravity_m_s2: rotate(scene.system.gravity_m_s2, [cos, -sin]),
    })
}

/// Returns [`hand_at_rest`] with the grasp state of a sample.
pub fn sampled_hand_at_rest<'a>(scene: &'a Scene, sample: &Sample, mode: DriveMode) -> Option<HandAtRest<'a>> {
    hand_at_rest(scene, &grasp_state(scene, sample), mode)
}
