//! What a scene needs of the engine, as plain lists: bodies, pins, torques, drives, stops and contacts.
//!
//! Nothing here knows of rapier, and nothing in the engine beyond the files that make a plan knows of fingers or discs: more
//! bodies, pins or contacts are more entries.

use crate::gripper::Body;
use crate::law::{ContactLaw, NormalLaw};
use crate::scene::{Actuation, SpringKind, torque};

/// A moving body: its mass properties, and where it starts. A body without mass is moved by a drive; one without inertia
/// does not turn by itself.
#[derive(Clone, Debug)]
pub struct PlannedBody {
    pub body: Body,
    /// Origin of the body's frame (the joint before it) and its orientation at the start.
    pub origin_m: [f64; 2],
    pub angle_rad: f64,
    /// Velocity of the origin, where no pin says it.
    pub velocity_m_s: [f64; 2],
    pub rate_rad_s: f64,
    pub shape: Option<Shape>,
}

/// A surface, in its body's frame or, of what is fixed, in the world.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    Capsule(Capsule),
    /// About the origin of its frame.
    Disc {
        radius_m: f64,
    },
    /// Everything below the origin of its frame.
    HalfPlane,
}

/// A capsule in its body's frame: from the origin along a direction.
#[derive(Clone, Copy, Debug)]
pub struct Capsule {
    pub length_m: f64,
    pub angle_rad: f64,
    pub radius_m: f64,
}

/// A surface that does not move: it is no body.
#[derive(Clone, Copy, Debug)]
pub struct PlannedFixed {
    pub shape: Shape,
    pub origin_m: [f64; 2],
}

/// A revolute joint; `None` is the ground. Anchors are in each body's frame.
#[derive(Clone, Copy, Debug)]
pub struct PlannedPin {
    pub first: Option<usize>,
    pub second: usize,
    pub anchor_first_m: [f64; 2],
    pub anchor_second_m: [f64; 2],
    /// Whether this is the joint that closes a loop of the others.
    pub closes_loop: bool,
}

/// A torque on a body over time, against the ground.
#[derive(Clone, Debug)]
pub struct PlannedMotor {
    pub on: usize,
    pub actuation: Actuation,
}

/// A body that no pin holds and that moves as told: x(t) = origin + velocity t + ½ acceleration t², angle = spin t from where
/// it starts.
#[derive(Clone, Copy, Debug)]
pub struct PlannedDrive {
    pub body: usize,
    pub acceleration_m_s2: [f64; 2],
}

/// A torque on `on`, and its reaction on `against`, that depends on the angle from `against` to `on`.
#[derive(Clone, Copy, Debug)]
pub struct PlannedSpring {
    pub on: usize,
    pub against: usize,
    pub kind: SpringKind,
    /// +1 where the angle grows as the finger closes: the torque pulls against that.
    pub closing_sign: f64,
    /// The angle in the straight configuration.
    pub straight_rad: f64,
}

/// A one-sided stop: the angle from `against` to `on` stays above `least_rad`.
#[derive(Clone, Copy, Debug)]
pub struct PlannedStop {
    pub on: usize,
    pub against: usize,
    pub least_rad: f64,
    pub law: NormalLaw,
}

/// What the surface of a body may touch.
#[derive(Clone, Copy, Debug)]
pub enum Against {
    /// The surface of another body, by its index.
    Body(usize),
    /// A fixed surface, by its index.
    Fixed(usize),
}

/// The surface of a body that may touch another one.
#[derive(Clone, Copy, Debug)]
pub struct PlannedContact {
    pub body: usize,
    pub against: Against,
    pub law: ContactLaw,
}

/// Everything the engine builds for a scene, and nothing it does not need.
///
/// Stops and contacts are known by one index: first the stops, then the contacts.
#[derive(Clone, Debug)]
pub struct Plan {
    pub bodies: Vec<PlannedBody>,
    pub fixed: Vec<PlannedFixed>,
    pub pins: Vec<PlannedPin>,
    pub motor: Option<PlannedMotor>,
    pub drives: Vec<PlannedDrive>,
    pub spring: Option<PlannedSpring>,
    pub stops: Vec<PlannedStop>,
    pub contacts: Vec<PlannedContact>,
    pub gravity_m_s2: [f64; 2],
}

impl Plan {
    /// Torque of the motor at time `t`, in N·m; 0 where there is none.
    pub fn motor_torque(&self, t: f64) -> f64 {
        self.motor.as_ref().map_or(0.0, |motor| torque(&motor.actuation, t).0)
    }
}
