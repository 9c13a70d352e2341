//! Components of a scene as plain lists: bodies, joints, gears, torques, drives, stops and contacts.
//!
//! The plan is independent of rapier; `mechanism` builds it.

use super::cable::PlannedCableFriction;
use super::coordinate::{BodyPoint, BodyPose, Circle, Coordinate, Twist};
use super::powertrain::PlannedPowertrain;
use crate::gripper::Body;
use crate::law::{ContactLaw, FrictionLaw, NormalForce, NormalLaw};
use crate::mechanism::{JointKind, PrescribedMotion};
use crate::numeric::elementary::{cos, sin};
use crate::numeric::plane::{add, rotate, sub};
use crate::scene::{Brake, PalmMotion, Profile, SpringKind};
use crate::shape;

/// A moving body with its initial state. A body without mass is moved by a drive; a body without inertia does not
/// rotate.
#[derive(Clone, Debug)]
pub struct PlannedBody {
    pub body: Body,
    /// Origin of the body frame (the preceding joint) at the start.
    pub origin_m: [f64; 2],
    pub angle_rad: f64,
    /// Velocity of the origin at the start.
    pub velocity_m_s: [f64; 2],
    pub rate_rad_s: f64,
    /// Arm with which an angular acceleration enters the choice of step sizes; 0 if only the acceleration of the centre
    /// of mass counts.
    pub gyration_m: f64,
    /// Surfaces in the frame of the body.
    pub surfaces: Vec<PlannedSurface>,
}

impl PlannedBody {
    /// Pose at the start.
    pub(crate) fn pose(&self) -> BodyPose {
        let direction = [cos(self.angle_rad), sin(self.angle_rad)];
        let com = add(self.origin_m, rotate(self.body.com_m, direction));
        BodyPose { com, direction, angle: self.angle_rad }
    }

    /// A body without mass and shape, at rest at the origin.
    pub(crate) fn at_origin(inertia_kg_m2: f64) -> Self {
        Self {
            body: Body { mass_kg: 0.0, com_m: [0.0; 2], inertia_kg_m2 },
            origin_m: [0.0; 2],
            angle_rad: 0.0,
            velocity_m_s: [0.0; 2],
            rate_rad_s: 0.0,
            gyration_m: 0.0,
            surfaces: Vec::new(),
        }
    }
}

/// A shape, in the frame of its surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    Capsule(Capsule),
    /// A convex shape around the origin of its frame.
    Disc(shape::Shape),
    /// The half-plane below the origin of its frame.
    HalfPlane,
    /// A convex polygon, enlarged by a radius; vertices are counter-clockwise.
    Polygon {
        vertices_m: Vec<[f64; 2]>,
        radius_m: f64,
    },
    /// An ellipse around the origin of its frame, with its first semi-axis along x.
    Ellipse {
        semi_axes_m: [f64; 2],
    },
}

/// A capsule from the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    pub end_m: [f64; 2],
    pub radius_m: f64,
}

/// A surface in the frame of its body, or in the world frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedSurface {
    pub shape: Shape,
    pub origin_m: [f64; 2],
    /// Direction of the x axis of the surface as a vector. Unlike an angle, it is exact for half a turn.
    pub direction: [f64; 2],
}

/// A joint between two bodies; `None` is the ground. Anchors are in the frames of the bodies.
#[derive(Clone, Copy, Debug)]
pub struct PlannedJoint {
    pub kind: JointKind,
    pub bodies: [Option<usize>; 2],
    pub anchors_m: [[f64; 2]; 2],
    /// Relative angle of the bodies when the angle of the joint is zero; for a prismatic joint, their constant relative
    /// angle.
    pub offset_rad: f64,
    /// Whether the order of the bodies is opposite to that in the mechanism. The coordinate then has the opposite sign.
    pub is_reversed: bool,
}

/// A motor: a torque or force along its shaft as a function of time.
#[derive(Clone, Debug)]
pub struct PlannedMotor {
    pub shaft: Coordinate,
    pub actuation: Profile,
    /// Largest magnitude of the torque.
    pub limit: f64,
    /// Shaft rate at which the torque is zero.
    pub no_load_speed_rad_s: Option<f64>,
}

/// A force along a coordinate that is linear in the value and the rate of the coordinate: that of a servo, or of a
/// damper.
#[derive(Clone, Debug)]
pub struct PlannedServo {
    pub coordinate: Coordinate,
    pub target: Profile,
    pub law: ServoLaw,
    /// Whether the work of the force is that of a motor; otherwise it is dissipated.
    pub is_motor: bool,
}

/// An actuator, given by its index among the motors, the servos or the powertrains.
#[derive(Clone, Copy, Debug)]
pub enum PlannedActuator {
    Motor(usize),
    Servo(usize),
    Powertrain(usize),
}

/// A tendon: its length, the stop that represents its spring and damper, and the motor that pulls it.
#[derive(Clone, Debug)]
pub struct PlannedTendon {
    pub length: Coordinate,
    pub stop: Option<usize>,
    pub motor: Option<usize>,
    /// The path elements; those that the cable is on change.
    pub circles: Vec<Circle>,
    /// Spools behind the last circle, with the factors of their coordinates in the length.
    pub far: Vec<(Coordinate, f64)>,
}

/// u = kp δ + kd δ̇, limited to |u| ≤ limit; δ is the error of the coordinate q. The force is u − |u| q̇/ω₀.
#[derive(Clone, Copy, Debug)]
pub struct ServoLaw {
    pub kp: f64,
    pub kd: f64,
    pub limit: f64,
    /// 1/ω₀.
    pub slope: f64,
    /// Rate of the target.
    pub target_rate: f64,
}

impl ServoLaw {
    /// Returns the force with its derivatives, from the error of the coordinate and its rate.
    #[inline(always)]
    pub(crate) fn force(&self, error: f64, error_rate: f64) -> NormalForce {
        let command = self.kp * error + self.kd * error_rate;
        let (u, gain) = if command.abs() > self.limit { (self.limit.copysign(command), 0.0) } else { (command, 1.0) };
        let rate = self.target_rate - error_rate;
        let gain = gain * (1.0 - u.signum() * rate * self.slope);
        NormalForce {
            force: u - u.abs() * rate * self.slope,
            d_delta: gain * self.kp,
            d_rate: gain * self.kd + u.abs() * self.slope,
        }
    }
}

impl PlannedServo {
    /// Returns the force at time `t` and these poses and velocities.
    pub fn force(&self, t: f64, poses: &[BodyPose], velocities: &[Twist]) -> f64 {
        let (target, target_rate) = self.target.at(t);
        let (value, rate) = (self.coordinate.value(poses), self.coordinate.row(poses).rate(velocities));
        ServoLaw { target_rate, ..self.law }.force(target - value, target_rate - rate).force
    }
}

/// A gear: up to two constraints. Each keeps the sum of its ratios times the coordinates, measured from the start, at
/// zero. A constraint whose ratios are all zero is omitted.
#[derive(Clone, Debug)]
pub struct PlannedGear {
    pub terms: Vec<(Coordinate, [f64; 2])>,
}

/// A body with prescribed motion.
#[derive(Clone, Debug)]
pub struct PlannedDrive {
    pub body: usize,
    pub motion: PrescribedMotion,
}

/// A brake on a shaft, or the friction of a joint.
#[derive(Clone, Debug)]
pub struct PlannedBrake {
    pub shaft: Coordinate,
    pub kind: BrakeKind,
    /// Index of its actuator in the mechanism.
    pub actuator: Option<usize>,
}

#[derive(Clone, Copy, Debug)]
pub enum BrakeKind {
    Brake(Brake),
    /// A law under a normal force of 1.
    Friction(FrictionLaw),
}

impl BrakeKind {
    /// Friction law under the force of [`BrakeKind::normal_force`].
    pub(crate) fn law(&self) -> FrictionLaw {
        match *self {
            BrakeKind::Brake(Brake { v_static_rad_s, bristle, .. }) => FrictionLaw {
                mu_static: 1.0,
                mu_dynamic: 1.0,
                v_static_m_s: v_static_rad_s,
                v_dynamic_m_s: 2.0 * v_static_rad_s,
                kind: bristle.into(),
            },
            BrakeKind::Friction(law) => law,
        }
    }

    pub(crate) fn is_one_way(&self) -> bool {
        matches!(self, BrakeKind::Brake(brake) if brake.one_way)
    }

    pub(crate) fn normal_force(&self, t: f64) -> f64 {
        match self {
            BrakeKind::Brake(brake) => brake.torque_n_m * brake.engagement(t).0,
            BrakeKind::Friction(_) => 1.0,
        }
    }

    fn next_discontinuity(&self, t: f64) -> f64 {
        match self {
            BrakeKind::Brake(brake) => brake.next_discontinuity(t),
            BrakeKind::Friction(_) => f64::INFINITY,
        }
    }
}

/// Inertia of a rotor on a body. Only the rate of the body relative to the palm drives it, not the rotation of the palm
/// itself.
#[derive(Clone, Copy, Debug)]
pub struct PlannedRotor {
    pub body: usize,
    pub inertia_kg_m2: f64,
}

/// A spring: a torque or force that opposes its extension.
#[derive(Clone, Debug)]
pub struct PlannedSpring {
    pub extension: Coordinate,
    pub kind: SpringKind,
}

/// A one-sided stop, which keeps its gap (an angle or a length) above zero.
#[derive(Clone, Debug)]
pub struct PlannedStop {
    pub gap: Coordinate,
    pub law: NormalLaw,
}

/// A surface, given by its index among those of a body; `None` instead of a body is the ground.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceId {
    pub body: Option<usize>,
    pub index: usize,
}

/// A surface of a body and another surface that can come into contact.
#[derive(Clone, Copy, Debug)]
pub struct PlannedContact {
    pub body: usize,
    /// Index of the surface of the body.
    pub surface: usize,
    pub against: SurfaceId,
    pub point_convention: ContactPointConvention,
    pub law: ContactLaw,
    /// Law of rolling resistance; only for mechanisms.
    pub rolling: Option<FrictionLaw>,
    /// Whether samples report the force on the other body, with the opposite normal.
    pub is_reported_on_partner: bool,
    /// Whether the contact is removed, because what the body touches has been removed.
    pub is_removed: bool,
}

/// Choice of the material points of two surfaces at which contact forces act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactPointConvention {
    /// Each force acts at the closest point of its own surface.
    EachSurface,
    /// Both forces act at the closest point of the body's surface.
    BodySurface,
    /// Both forces act at the closest point of the other surface.
    PartnerSurface,
    /// Both forces act in the middle between the closest points.
    Middle,
}

/// All components that the engine builds for a scene.
///
/// Stops, contacts, brakes, motors, servos, powertrains and the friction of cables share one element index, in this order.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    pub bodies: Vec<PlannedBody>,
    pub fixed_surfaces: Vec<PlannedSurface>,
    pub joints: Vec<PlannedJoint>,
    pub gears: Vec<PlannedGear>,
    pub motors: Vec<PlannedMotor>,
    pub servos: Vec<PlannedServo>,
    pub powertrains: Vec<PlannedPowertrain>,
    /// Actuators of a mechanism, in the order of the mechanism.
    pub actuators: Vec<PlannedActuator>,
    pub brakes: Vec<PlannedBrake>,
    pub rotors: Vec<PlannedRotor>,
    pub drives: Vec<PlannedDrive>,
    pub springs: Vec<PlannedSpring>,
    pub stops: Vec<PlannedStop>,
    pub contacts: Vec<PlannedContact>,
    /// Tendons of a mechanism, in the order of the mechanism.
    pub tendons: Vec<PlannedTendon>,
    /// Friction of cables, cable by cable from the first to the last circle.
    pub cable_frictions: Vec<PlannedCableFriction>,
    /// Circles of cables that samples report, by tendon and circle.
    pub reported_circles: Vec<[usize; 2]>,
    /// Bodies that samples report.
    pub reported_bodies: Vec<usize>,
    /// Contact channel in samples of each stop of a joint. After these, `stops` contains the springs of tendons, which have
    /// no channel.
    pub stop_channels: Vec<usize>,
    /// For each contact, its contact channel in samples.
    pub contact_channels: Vec<usize>,
    pub gravity_m_s2: [f64; 2],
    /// Whether joints, springs, tendons, or bodies that do not rotate exert forces on the ground.
    pub ground_carries: bool,
}

impl Plan {
    /// Returns the torque or force of an actuator without a powertrain at time `t` and at these poses and velocities.
    pub fn effort(&self, actuator: PlannedActuator, t: f64, (poses, velocities): (&[BodyPose], &[Twist])) -> f64 {
        match actuator {
            PlannedActuator::Motor(index) => {
                let motor = &self.motors[index];
                motor.torque(t, motor.shaft.row(poses).rate(velocities))
            }
            PlannedActuator::Servo(index) => self.servos[index].force(t, poses, velocities),
            PlannedActuator::Powertrain(_) => 0.0,
        }
    }

    /// Returns the coordinate along which an actuator acts.
    pub fn shaft(&self, actuator: PlannedActuator) -> &Coordinate {
        match actuator {
            PlannedActuator::Motor(index) => &self.motors[index].shaft,
            PlannedActuator::Servo(index) => &self.servos[index].coordinate,
            PlannedActuator::Powertrain(index) => &self.powertrains[index].shaft,
        }
    }

    /// Replaces the torque or force of an actuator, or the target of a servo, as a function of time.
    pub fn set_input(&mut self, actuator: usize, input: Profile) {
        match self.actuators[actuator] {
            PlannedActuator::Motor(index) => self.motors[index].actuation = input,
            PlannedActuator::Servo(index) => self.servos[index].target = input,
            PlannedActuator::Powertrain(index) => self.powertrains[index].input = input,
        }
    }

    /// Removes contacts between surfaces, by their channels in samples.
    pub(crate) fn remove_contacts(&mut self, channels: &[usize]) {
        for (contact, channel) in self.contacts.iter_mut().zip(&self.contact_channels) {
            contact.is_removed |= channels.contains(channel);
        }
    }

    /// Returns the next time after `t` at which a motor torque, a brake or the motion of the palm has a discontinuity.
    pub fn next_discontinuity(&self, t: f64) -> f64 {
        let motors = self.motors.iter().map(|motor| motor.actuation.next_discontinuity(t));
        let servos = self.servos.iter().map(|servo| servo.target.next_discontinuity(t));
        let powertrains = self.powertrains.iter().map(|powertrain| powertrain.input.next_discontinuity(t));
        let brakes = self.brakes.iter().map(|brake| brake.kind.next_discontinuity(t));
        let drives = self.drives.iter().map(|drive| drive.motion.next_discontinuity(t));
        motors.chain(servos).chain(powertrains).chain(brakes).chain(drives).fold(f64::INFINITY, f64::min)
    }

    /// Gravity in the axes of a moving palm at the start.
    pub(crate) fn gravity_at_start(&self) -> [f64; 2] {
        self.palm().map_or(self.gravity_m_s2, |(_, motion)| motion.in_initial_axes(self.gravity_m_s2))
    }

    /// Returns the body index and motion of a moving palm.
    pub fn palm(&self) -> Option<(usize, &PalmMotion)> {
        self.drives.iter().find_map(|drive| match &drive.motion {
            PrescribedMotion::Palm(motion) => Some((drive.body, motion)),
            PrescribedMotion::ConstantAcceleration { .. } => None,
        })
    }

    /// Returns the contact channel of a stop or contact by its element index; `None` for other elements.
    pub fn contact_channel(&self, index: usize) -> Option<usize> {
        match index.checked_sub(self.stops.len()) {
            Some(contact) => self.contact_channels.get(contact).copied(),
            None => self.stop_channels.get(index).copied(),
        }
    }

    /// Whether samples report the force of an element on the other body of a contact.
    pub(crate) fn is_reported_on_partner(&self, index: usize) -> bool {
        let contact = index.checked_sub(self.stops.len()).and_then(|contact| self.contacts.get(contact));
        contact.is_some_and(|contact| contact.is_reported_on_partner)
    }

    /// Returns the element index of a contact channel; `None` if the contact does not exist.
    pub(crate) fn element_index(&self, channel: usize) -> Option<usize> {
        let position = |channels: &[usize]| channels.iter().position(|other| *other == channel);
        position(&self.stop_channels)
            .or_else(|| position(&self.contact_channels).map(|contact| self.stops.len() + contact))
    }

    /// Element index of the first brake.
    pub(crate) fn first_brake(&self) -> usize {
        self.stops.len() + self.contacts.len()
    }

    /// Element index of the first motor.
    pub(crate) fn first_motor(&self) -> usize {
        self.first_brake() + self.brakes.len()
    }

    /// Element index of the first servo.
    pub(crate) fn first_servo(&self) -> usize {
        self.first_motor() + self.motors.len()
    }

    /// Element index of the first powertrain.
    pub(crate) fn first_powertrain(&self) -> usize {
        self.first_servo() + self.servos.len()
    }

    /// Element index of the first friction of a cable.
    pub(crate) fn first_cable_friction(&self) -> usize {
        self.first_powertrain() + self.powertrains.len()
    }

    /// Number of elements.
    pub(crate) fn element_count(&self) -> usize {
        self.first_cable_friction() + self.cable_frictions.len()
    }

    pub(crate) fn surface(&self, id: SurfaceId) -> &PlannedSurface {
        let surfaces = id.body.map_or(&self.fixed_surfaces, |body| &self.bodies[body].surfaces);
        &surfaces[id.index]
    }

    /// Returns a point of a body frame, or of the world.
    pub(crate) fn body_point(&self, body: Option<usize>, point_m: [f64; 2]) -> BodyPoint {
        BodyPoint { body, arm_m: sub(point_m, body.map_or([0.0; 2], |body| self.bodies[body].body.com_m)) }
    }
}

impl PlannedMotor {
    /// Returns the stall torque at time `t`, N·m.
    pub(crate) fn stall_torque(&self, t: f64) -> f64 {
        self.actuation.at(t).0.clamp(-self.limit, self.limit)
    }

    /// Returns the torque on the shaft at time `t`, N·m: τ − |τ| ω/ω₀, where ω is the shaft rate.
    pub fn torque(&self, t: f64, shaft_rate: f64) -> f64 {
        let stall_torque = self.stall_torque(t);
        self.no_load_speed_rad_s.map_or(stall_torque, |speed| stall_torque - stall_torque.abs() * shaft_rate / speed)
    }
}
