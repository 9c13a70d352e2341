//! What a scene needs of the engine, as plain lists: bodies, pins, gears, torques, drives, stops and contacts.
//!
//! Nothing here knows of rapier, and nothing in the engine beyond the files that make a plan knows of fingers or discs: more
//! bodies, pins or contacts are more entries.

use crate::gripper::Body;
use crate::law::{ContactLaw, NormalLaw};
use crate::scene::{Actuation, Brake, PalmMotion, SpringKind, next_corner, torque};
use crate::shape;

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
    Disc(shape::Shape),
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
    /// Its x axis: exact, where an angle of π would not be.
    pub direction: [f64; 2],
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

/// A torque over time, against the ground.
#[derive(Clone, Debug)]
pub struct PlannedMotor {
    /// Bodies it turns, with the part of its torque that each gets: its shaft turns by the sum of these parts of their angles.
    pub on: Vec<(usize, f64)>,
    pub actuation: Actuation,
    /// Rate of the shaft at which nothing is left of the torque.
    pub no_load_speed_rad_s: Option<f64>,
}

/// Wheels that keep two sums at zero: of their angles from the start, each times its pair of ratios.
#[derive(Clone, Debug)]
pub struct PlannedGear {
    pub wheels: Vec<(usize, [f64; 2])>,
}

/// A body that moves as told, whatever holds it.
#[derive(Clone, Debug)]
pub struct PlannedDrive {
    pub body: usize,
    pub course: Course,
}

/// How a driven body moves from where it starts.
#[derive(Clone, Debug)]
pub enum Course {
    /// x(t) = origin + velocity t + ½ acceleration t², angle = spin t.
    Even { acceleration_m_s2: [f64; 2] },
    /// That of a palm, whose frame counts: others stand on it.
    Palm(PalmMotion),
}

/// A brake on the shaft that turns by the sum of the parts of two bodies' angles.
#[derive(Clone, Copy, Debug)]
pub struct PlannedHold {
    pub on: (usize, f64),
    pub against: Option<(usize, f64)>,
    pub brake: Brake,
}

/// Inertia of a body that counts its rate against the palm, whose own turning does not move it.
#[derive(Clone, Copy, Debug)]
pub struct PlannedRotor {
    pub body: usize,
    pub inertia_kg_m2: f64,
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
    pub meet: Meet,
    pub law: ContactLaw,
}

/// The material points of two surfaces at which they exchange forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meet {
    /// Each at its own nearest point.
    Each,
    /// Both where the body's surface is.
    Body,
    /// Both where the other surface is.
    Other,
}

/// Everything the engine builds for a scene, and nothing it does not need.
///
/// Stops, contacts, holds and motors are known by one index, in this order.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    pub bodies: Vec<PlannedBody>,
    pub fixed: Vec<PlannedFixed>,
    pub pins: Vec<PlannedPin>,
    pub gears: Vec<PlannedGear>,
    pub motors: Vec<PlannedMotor>,
    pub holds: Vec<PlannedHold>,
    pub rotors: Vec<PlannedRotor>,
    pub drives: Vec<PlannedDrive>,
    pub springs: Vec<PlannedSpring>,
    pub stops: Vec<PlannedStop>,
    pub contacts: Vec<PlannedContact>,
    /// Which contact of a sample each stop is, and each contact.
    pub stop_places: Vec<usize>,
    pub contact_places: Vec<usize>,
    pub gravity_m_s2: [f64; 2],
}

impl Plan {
    /// Torque of all motors on a body at time `t`, in N·m, at these rates of all bodies.
    pub fn motor_torque(&self, body: usize, t: f64, rate: impl Fn(usize) -> f64) -> f64 {
        let on = |motor: &PlannedMotor| motor.on.iter().find(|(on, _)| *on == body).map_or(0.0, |(_, part)| *part);
        let driving = self.motors.iter().filter(|motor| on(motor) != 0.0);
        driving.map(|motor| on(motor) * motor.torque(t, &rate)).sum()
    }

    /// The next time after `t` at which the torque of a motor, or something of a brake or of the palm's motion, jumps.
    pub fn next_corner(&self, t: f64) -> f64 {
        let motors = self.motors.iter().map(|motor| next_corner(&motor.actuation, t));
        let holds = self.holds.iter().map(|hold| hold.brake.next_corner(t));
        let palm = self.palm().map(|(_, motion)| motion.next_corner(t));
        motors.chain(holds).chain(palm).fold(f64::INFINITY, f64::min)
    }

    /// The body that is a moving palm, and how it moves.
    pub fn palm(&self) -> Option<(usize, &PalmMotion)> {
        self.drives.iter().find_map(|drive| match &drive.course {
            Course::Palm(motion) => Some((drive.body, motion)),
            Course::Even { .. } => None,
        })
    }

    /// Which contact of a sample a stop or contact is; `None` of a hold.
    pub fn place(&self, index: usize) -> Option<usize> {
        self.stop_places.iter().chain(&self.contact_places).nth(index).copied()
    }

    /// The index of a sample's contact among stops and contacts; `None` where there is nothing to touch.
    pub fn index(&self, place: usize) -> Option<usize> {
        self.stop_places.iter().chain(&self.contact_places).position(|of| *of == place)
    }

    /// Index of the first hold among stops, contacts and holds.
    pub fn first_hold(&self) -> usize {
        self.stops.len() + self.contacts.len()
    }

    /// Index of the first motor behind them.
    pub fn first_motor(&self) -> usize {
        self.first_hold() + self.holds.len()
    }
}

impl PlannedMotor {
    /// Torque at standstill at time `t`, in N·m, and what a rate of the shaft of 1 rad/s takes from it, in N·m·s/rad.
    pub fn characteristic(&self, t: f64) -> (f64, f64) {
        let full = torque(&self.actuation, t).0;
        (full, self.no_load_speed_rad_s.map_or(0.0, |speed| full.abs() / speed))
    }

    /// Torque of the shaft at time `t`, in N·m: τ − |τ| ω/ω₀ at the rate ω that its bodies give it.
    pub fn torque(&self, t: f64, rate: impl Fn(usize) -> f64) -> f64 {
        let full = torque(&self.actuation, t).0;
        self.no_load_speed_rad_s.map_or(full, |speed| full - full.abs() * self.shaft(rate) / speed)
    }

    /// Angle or rate of the shaft, from those of the bodies.
    pub fn shaft(&self, of: impl Fn(usize) -> f64) -> f64 {
        self.on.iter().map(|(body, part)| part * of(*body)).sum()
    }
}
