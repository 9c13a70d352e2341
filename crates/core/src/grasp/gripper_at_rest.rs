//! A gripper at rest in a posture: its mechanism in the frame of the palm, with the active contacts.

use crate::criteria::{grasp_configuration, normal_forces};
use crate::drive::{Brake, Profile};
use crate::gripper::FingerContact;
use crate::mechanism::{Actuator, Command, Mechanism, Pose, coordinate_in};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::rotate;
use crate::scene::{Hand, HandContact, Initial, Object, Scene, Side};
use crate::statics::{
    ContactAtRest, DriveState, GraspConfiguration, MechanismAtRest, PerContact, Roles, StaticsError, roles,
};
use crate::trace::Sample;

/// Whether the drives resist being driven back while the palm is accelerated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveMode {
    /// Motors exert their torque, and brakes up to their holding torque; one-way brakes only resist opening. A motor
    /// without a brake is blocked at any torque. With a differential, this applies to its input.
    Blocked,
    /// Motors exert their torque, and nothing blocks them.
    AtTorque,
}

/// Configuration of a gripper and its active contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraspState<'a> {
    pub configuration: GraspConfiguration<'a>,
    /// Active contacts of phalanges and palm. The table is excluded, because the gripper lifts its object off the
    /// table.
    pub active: PerContact<bool>,
    /// Whether the joint limits of the right and of the left finger are active.
    pub at_limit: [bool; 2],
    /// Time at which the motor torques and the angle of the palm are evaluated, s.
    pub time_s: f64,
}

/// Returns the configuration and the active contacts of a sample.
pub fn grasp_state<'a>(scene: &'a Scene, sample: &Sample) -> GraspState<'a> {
    let limit = |side| HandContact::Finger(side, FingerContact::Limit);
    GraspState {
        configuration: grasp_configuration(scene, sample),
        active: normal_forces(scene, sample).map(|normal_n| normal_n > 0.0),
        at_limit: Side::BOTH.map(|side| sample.hand_contact(&scene.hand, limit(side)).normal_n > 0.0),
        time_s: sample.time_s,
    }
}

/// A gripper at rest: palm and object do not move relative to the ground, which represents the palm.
#[derive(Clone, Debug, PartialEq)]
pub struct GripperAtRest {
    /// Mechanism of the gripper. The mode of the drives decides whether its brakes are engaged or missing. Its joint
    /// limits are those that are reached.
    pub mechanism: Mechanism,
    pub poses: Vec<Pose>,
    pub time_s: f64,
    /// Index of the object.
    pub object: usize,
    /// Active contacts, in the order of [`HandContact::ALL`].
    pub contacts: Vec<ContactAtRest>,
    pub roles: Roles,
}

impl GripperAtRest {
    pub fn at_rest(&self) -> MechanismAtRest<'_> {
        let Self { mechanism, poses, time_s, contacts, roles, .. } = self;
        MechanismAtRest { mechanism, poses, time_s: *time_s, contacts, drives: DriveState::AtEffort, roles }
    }

    /// Returns the gripper with another torque of all motors.
    pub fn with_motor_torque(mut self, motor_n_m: Option<f64>) -> Self {
        if let Some(value) = motor_n_m {
            let actuators = self.mechanism.actuators.iter_mut();
            actuators.for_each(|actuator| actuator.command = Command::Effort(Profile::Constant { value }));
        }
        self
    }
}

/// Returns the gripper at rest with its active contacts.
///
/// # Errors
/// Returns an error if the loop of a finger does not close, or if its posture is singular.
///
/// # Panics
/// Panics if the object is fixed.
pub fn gripper_at_rest(hand: &Hand, grasp: &GraspState<'_>, mode: DriveMode) -> Result<GripperAtRest, StaticsError> {
    let points = grasp.configuration.contact_points()?;
    let hand = in_posture(hand, grasp);
    let mut mechanism = hand.mechanism().map_err(|error| StaticsError::Balance { reason: error.to_string() })?;
    let poses: Vec<Pose> = mechanism.bodies.iter().map(|body| body.pose).collect();
    mechanism.actuators.iter_mut().for_each(|actuator| set_brake(actuator, mode));
    for joint in mechanism.joints.iter_mut().filter(|joint| joint.limit.is_some()) {
        joint.lower = Some(coordinate_in(joint, &poses));
    }
    let object = mechanism.bodies.iter().position(|body| body.name == Object::NAME).expect("a moving object");
    let pairs = hand.contacts().zip(&mechanism.contacts).filter(|(id, _)| contact_value(&grasp.active, *id));
    let contacts: Vec<ContactAtRest> = pairs
        .map(|(id, pair)| {
            let (point, mu) = (contact_value(&points, id), pair.law.friction.map_or(0.0, |law| law.mu_static));
            let bodies = [pair.points.body, pair.face.body];
            ContactAtRest { bodies, point_m: point.point_m, normal: point.normal, mu }
        })
        .collect();
    let roles = roles(&mechanism, (object, None), &[], contacts.iter().map(|contact| contact.bodies));
    Ok(GripperAtRest { mechanism, poses, time_s: grasp.time_s, object, contacts, roles })
}

/// Returns the hand in a posture and in the frame of its palm, with the joint limits that are reached.
fn in_posture(hand: &Hand, grasp: &GraspState<'_>) -> Hand {
    let GraspState { configuration: GraspConfiguration { angles_rad, object, .. }, at_limit, time_s, .. } = *grasp;
    let (sin, cos) = sin_cos(hand.palm_motion.as_ref().map_or(0.0, |motion| motion.pose(time_s).position[2]));
    let gravity_m_s2 = rotate(hand.gravity_m_s2, [cos, -sin]);
    let mut hand = Hand { palm_motion: None, table: None, gravity_m_s2, ..hand.clone() };
    for ((finger, [q11_rad, q21_rad]), is_at_limit) in hand.fingers.iter_mut().zip(angles_rad).zip(at_limit) {
        finger.initial = Initial { q11_rad, q21_rad, qd11_rad_s: 0.0, qd21_rad_s: 0.0 };
        finger.limit = finger.limit.filter(|_| is_at_limit);
    }
    hand.grasped_mut().centre_m = object.centre_m;
    hand
}

/// Engages the brake of an actuator, or removes it. A motor without a brake is blocked at any torque.
fn set_brake(actuator: &mut Actuator, mode: DriveMode) {
    const UNLIMITED: Brake = Brake {
        torque_n_m: f64::INFINITY,
        start_s: f64::NEG_INFINITY,
        rise_s: 1.0,
        release_s: None,
        one_way: false,
        v_static_rad_s: 1.0,
        bristle: None,
    };
    actuator.brake = match mode {
        DriveMode::Blocked => {
            let brake = actuator.brake.unwrap_or(UNLIMITED);
            Some(Brake { start_s: UNLIMITED.start_s, release_s: None, ..brake })
        }
        DriveMode::AtTorque => None,
    };
}

/// Returns the value of a contact. A joint limit has the value of its distal phalanx, the table that of the palm.
pub(super) fn contact_value<T: Copy>(all: &PerContact<T>, id: HandContact) -> T {
    match id {
        HandContact::Finger(side, contact) => {
            all.phalanges[side as usize][usize::from(contact != FingerContact::Proximal)]
        }
        HandContact::Palm | HandContact::Table => all.palm,
    }
}
