//! Components of a scene as plain lists: bodies, pins, gears, torques, drives, stops and contacts.
//!
//! The plan is independent of rapier. Only the modules that build a plan depend on fingers and discs; the others accept
//! any number of bodies, pins and contacts.

use crate::gripper::Body;
use crate::law::{ContactLaw, NormalLaw};
use crate::scene::{Actuation, Brake, PalmMotion, SpringKind, next_discontinuity, torque};
use crate::shape;

/// A moving body: mass properties and initial state. A body without mass is moved by a drive; a body without inertia
/// does not rotate.
#[derive(Clone, Debug)]
pub struct PlannedBody {
    pub body: Body,
    /// Origin of the body frame (the preceding joint) and its orientation at the start.
    pub origin_m: [f64; 2],
    pub angle_rad: f64,
    /// Velocity of the origin, unless a pin determines it.
    pub velocity_m_s: [f64; 2],
    pub rate_rad_s: f64,
    pub shape: Option<Shape>,
}

impl PlannedBody {
    /// A body without mass and shape, at rest at the origin.
    pub(crate) fn at_origin(inertia_kg_m2: f64) -> Self {
        Self {
            body: Body { mass_kg: 0.0, com_m: [0.0; 2], inertia_kg_m2 },
            origin_m: [0.0; 2],
            angle_rad: 0.0,
            velocity_m_s: [0.0; 2],
            rate_rad_s: 0.0,
            shape: None,
        }
    }
}

/// A surface, in its body frame or, if fixed, in the world frame.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    Capsule(Capsule),
    /// A convex shape around the origin of its frame.
    Disc(shape::Shape),
    /// The half-plane below the origin of its frame.
    HalfPlane,
}

/// A capsule in its body frame: from the origin along a direction.
#[derive(Clone, Copy, Debug)]
pub struct Capsule {
    pub length_m: f64,
    pub angle_rad: f64,
    pub radius_m: f64,
}

/// A fixed surface, which belongs to no body.
#[derive(Clone, Copy, Debug)]
pub struct PlannedFixedSurface {
    pub shape: Shape,
    pub origin_m: [f64; 2],
    /// Its x axis as a vector, which is exact where an angle of π is not.
    pub direction: [f64; 2],
}

/// A revolute joint; `None` is the ground. Anchors are in the body frames.
#[derive(Clone, Copy, Debug)]
pub struct PlannedPin {
    pub first: Option<usize>,
    pub second: usize,
    pub anchor_first_m: [f64; 2],
    pub anchor_second_m: [f64; 2],
    /// Whether this joint closes a loop of the others.
    pub closes_loop: bool,
}

/// A motor: a torque over time, supported by the ground.
#[derive(Clone, Debug)]
pub struct PlannedMotor {
    /// Driven bodies with their torque ratios; the shaft angle is the sum of the body angles times these ratios.
    pub on: Vec<(usize, f64)>,
    pub actuation: Actuation,
    /// Shaft rate at which the torque is zero.
    pub no_load_speed_rad_s: Option<f64>,
}

/// A gear: two constraints. Each one keeps at zero the sum of the wheel angles, measured from the start, times one
/// ratio per wheel.
#[derive(Clone, Debug)]
pub struct PlannedGear {
    pub wheels: Vec<(usize, [f64; 2])>,
}

/// A body with prescribed motion.
#[derive(Clone, Debug)]
pub struct PlannedDrive {
    pub body: usize,
    pub motion: PrescribedMotion,
}

/// Prescribed motion of a driven body from its initial state.
#[derive(Clone, Debug)]
pub enum PrescribedMotion {
    /// x(t) = origin + velocity t + ½ acceleration t², angle = spin t.
    ConstantAcceleration { acceleration_m_s2: [f64; 2] },
    /// Motion of a palm, whose frame is the base of other components.
    Palm(PalmMotion),
}

/// A brake on a shaft whose angle is the sum of the angles of up to two bodies times their ratios.
#[derive(Clone, Copy, Debug)]
pub struct PlannedBrake {
    /// Body and ratio of one side.
    pub on: (usize, f64),
    /// Body and ratio of the other side.
    pub against: Option<(usize, f64)>,
    pub brake: Brake,
}

/// Inertia of a rotor on a body, driven by the rate of the body relative to the palm; rotation of the palm alone does
/// not turn it.
#[derive(Clone, Copy, Debug)]
pub struct PlannedRotor {
    pub body: usize,
    pub inertia_kg_m2: f64,
}

/// A torque on `on`, with its reaction on `against`, that depends on the angle from `against` to `on`.
#[derive(Clone, Copy, Debug)]
pub struct PlannedSpring {
    pub on: usize,
    pub against: usize,
    pub kind: SpringKind,
    /// +1 if the angle grows as the finger closes; the torque acts against closing.
    pub closing_sign: f64,
    /// The angle in the straight configuration.
    pub straight_rad: f64,
}

/// A one-sided stop: keeps the angle from `against` to `on` above `min_angle_rad`.
#[derive(Clone, Copy, Debug)]
pub struct PlannedStop {
    pub on: usize,
    pub against: usize,
    pub min_angle_rad: f64,
    pub law: NormalLaw,
}

/// The other surface of a contact.
#[derive(Clone, Copy, Debug)]
pub enum ContactPartner {
    /// Surface of another body, by body index.
    Body(usize),
    /// Fixed surface, by its index.
    Fixed(usize),
}

/// A pair of surfaces that can come into contact.
#[derive(Clone, Copy, Debug)]
pub struct PlannedContact {
    pub body: usize,
    pub against: ContactPartner,
    pub point_convention: ContactPointConvention,
    pub law: ContactLaw,
}

/// Choice of the material points of two surfaces at which contact forces act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactPointConvention {
    /// Each surface at its own closest point.
    EachSurface,
    /// Both at the closest point of the body's surface.
    BodySurface,
    /// Both at the closest point of the other surface.
    PartnerSurface,
}

/// All components that the engine builds for a scene.
///
/// Stops, contacts, brakes and motors share one element index, in this order.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    pub bodies: Vec<PlannedBody>,
    pub fixed_surfaces: Vec<PlannedFixedSurface>,
    pub pins: Vec<PlannedPin>,
    pub gears: Vec<PlannedGear>,
    pub motors: Vec<PlannedMotor>,
    pub brakes: Vec<PlannedBrake>,
    pub rotors: Vec<PlannedRotor>,
    pub drives: Vec<PlannedDrive>,
    pub springs: Vec<PlannedSpring>,
    pub stops: Vec<PlannedStop>,
    pub contacts: Vec<PlannedContact>,
    /// Contact channel in samples of each stop.
    pub stop_channels: Vec<usize>,
    /// Contact channel in samples of each contact.
    pub contact_channels: Vec<usize>,
    pub gravity_m_s2: [f64; 2],
}

impl Plan {
    /// Returns the torque of all motors on a body at time `t`, N·m, at the given rates of all bodies.
    pub fn motor_torque(&self, body: usize, t: f64, rate: impl Fn(usize) -> f64) -> f64 {
        let ratio = |motor: &PlannedMotor| motor.on.iter().find(|(on, _)| *on == body).map_or(0.0, |(_, ratio)| *ratio);
        let driving = self.motors.iter().filter(|motor| ratio(motor) != 0.0);
        driving.map(|motor| ratio(motor) * motor.torque(t, &rate)).sum()
    }

    /// Returns the next time after `t` at which a motor torque, a brake or the palm motion has a discontinuity.
    pub fn next_discontinuity(&self, t: f64) -> f64 {
        let motors = self.motors.iter().map(|motor| next_discontinuity(&motor.actuation, t));
        let brakes = self.brakes.iter().map(|brake| brake.brake.next_discontinuity(t));
        let palm = self.palm().map(|(_, motion)| motion.next_discontinuity(t));
        motors.chain(brakes).chain(palm).fold(f64::INFINITY, f64::min)
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
        self.stop_channels.iter().chain(&self.contact_channels).nth(index).copied()
    }

    /// Returns the element index of a contact channel; `None` if the contact does not exist.
    pub(crate) fn element_index(&self, channel: usize) -> Option<usize> {
        self.stop_channels.iter().chain(&self.contact_channels).position(|other| *other == channel)
    }

    /// Element index of the first brake.
    pub(crate) fn first_brake(&self) -> usize {
        self.stops.len() + self.contacts.len()
    }

    /// Element index of the first motor.
    pub(crate) fn first_motor(&self) -> usize {
        self.first_brake() + self.brakes.len()
    }
}

impl PlannedMotor {
    /// Returns the stall torque at time `t`, N·m, and the torque lost per shaft rate, N·m·s/rad.
    pub(crate) fn characteristic(&self, t: f64) -> (f64, f64) {
        let stall_torque = torque(&self.actuation, t).0;
        (stall_torque, self.no_load_speed_rad_s.map_or(0.0, |speed| stall_torque.abs() / speed))
    }

    /// Returns the shaft torque at time `t`, N·m: τ − |τ| ω/ω₀ at the shaft rate ω of its bodies.
    pub fn torque(&self, t: f64, rate: impl Fn(usize) -> f64) -> f64 {
        let stall_torque = torque(&self.actuation, t).0;
        self.no_load_speed_rad_s
            .map_or(stall_torque, |speed| stall_torque - stall_torque.abs() * self.shaft(rate) / speed)
    }

    /// Returns the shaft angle or rate from those of the bodies.
    pub fn shaft(&self, value: impl Fn(usize) -> f64) -> f64 {
        self.on.iter().map(|(body, ratio)| ratio * value(*body)).sum()
    }
}
