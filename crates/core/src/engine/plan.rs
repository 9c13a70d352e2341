//! Components of a scene as plain lists: bodies, joints, gears, torques, drives, stops and contacts.
//!
//! The plan is independent of rapier. Only the modules that build a plan depend on fingers, discs and mechanisms; the
//! others accept any number of bodies, joints and contacts.

use super::coordinate::{BodyPoint, BodyPose, Coordinate, Measure, Twist};
use crate::gripper::{Body, Lengths, Posture, Spring, close_loop, straight_posture};
use crate::law::{ContactLaw, NormalForce, NormalLaw};
use crate::mechanism::{JointKind, PrescribedMotion};
use crate::numeric::elementary::{cos, sin, sin_cos};
use crate::numeric::plane::{add, opening_angle, rotate, sub};
use crate::scene::{
    Brake, ContactId, Differential, Disc, DiscMotion, DrivenFinger, Motor, PalmMotion, Placement, Profile, Side,
    SpringKind, System,
};
use crate::shape;
use std::f64::consts::{FRAC_PI_2, PI};

/// A moving body with its initial state. Without mass, a drive moves it; without inertia, it does not rotate.
#[derive(Clone, Debug)]
pub struct PlannedBody {
    pub body: Body,
    /// Origin of the body frame (the preceding joint) and its orientation at the start.
    pub origin_m: [f64; 2],
    pub angle_rad: f64,
    /// Velocity of the origin, unless a joint determines it.
    pub velocity_m_s: [f64; 2],
    pub rate_rad_s: f64,
    /// Arm at which step sizes take an angular acceleration into account; 0 if only that of the centre of mass counts.
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
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    Capsule(Capsule),
    /// A convex shape around the origin of its frame.
    Disc(shape::Shape),
    /// The half-plane below the origin of its frame.
    HalfPlane,
}

/// A capsule from the origin along a direction.
#[derive(Clone, Copy, Debug)]
pub struct Capsule {
    pub length_m: f64,
    pub angle_rad: f64,
    pub radius_m: f64,
}

/// A surface in the frame of its body, or in the world frame.
#[derive(Clone, Copy, Debug)]
pub struct PlannedSurface {
    pub shape: Shape,
    pub origin_m: [f64; 2],
    /// Its x axis as a vector, which is exact where an angle of π is not.
    pub direction: [f64; 2],
}

impl PlannedSurface {
    /// A surface in the frame of its body.
    fn at_origin(shape: Shape) -> Self {
        Self { shape, origin_m: [0.0; 2], direction: [1.0, 0.0] }
    }
}

/// A joint between two bodies; `None` is the ground. Anchors are in the body frames.
#[derive(Clone, Copy, Debug)]
pub struct PlannedJoint {
    pub kind: JointKind,
    pub bodies: [Option<usize>; 2],
    pub anchors_m: [[f64; 2]; 2],
    /// Relative angle of the bodies at the zero of the joint's angle; of a prismatic joint, at any time.
    pub offset_rad: f64,
    /// Whether this joint closes a loop of the others, or the rates of its bodies are given in the plan.
    pub closes_loop: bool,
}

/// A motor: a torque or force over time along its shaft.
#[derive(Clone, Debug)]
pub struct PlannedMotor {
    pub shaft: Coordinate,
    pub actuation: Profile,
    /// Largest magnitude of the torque.
    pub limit: f64,
    /// Shaft rate at which the torque is zero.
    pub no_load_speed_rad_s: Option<f64>,
}

/// A force along a coordinate that is linear in its value and rate: a servo, or a damper.
#[derive(Clone, Debug)]
pub struct PlannedServo {
    pub coordinate: Coordinate,
    pub target: Profile,
    pub law: ServoLaw,
    /// Whether the work of the force is that of a motor; otherwise it is dissipated.
    pub is_motor: bool,
}

/// An actuator by its index among the motors or the servos.
#[derive(Clone, Copy, Debug)]
pub enum PlannedActuator {
    Motor(usize),
    Servo(usize),
}

/// u = kp δ + kd δ̇ with the error δ of the coordinate, |u| ≤ limit; the force is u − |u| q̇/ω₀ at the rate q̇.
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

/// A gear: two constraints. Each keeps the sum of ratios times coordinates, measured from the start, at zero. A
/// constraint without ratios does not exist.
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

/// A brake on a shaft.
#[derive(Clone, Copy, Debug)]
pub struct PlannedBrake {
    pub shaft: Coordinate,
    pub brake: Brake,
    /// Index of its actuator in the mechanism.
    pub actuator: usize,
}

/// Inertia of a rotor on a body, driven by the rate of the body relative to the palm, not by the palm's own rotation.
#[derive(Clone, Copy, Debug)]
pub struct PlannedRotor {
    pub body: usize,
    pub inertia_kg_m2: f64,
}

/// A spring: a torque or force against its extension.
#[derive(Clone, Copy, Debug)]
pub struct PlannedSpring {
    /// For a finger, the angle from the straight configuration, positive in closing.
    pub extension: Coordinate,
    pub kind: SpringKind,
}

/// A one-sided stop: keeps its gap, an angle or a length, above zero.
#[derive(Clone, Copy, Debug)]
pub struct PlannedStop {
    pub gap: Coordinate,
    pub law: NormalLaw,
}

/// A surface by its index, of a body or, for `None`, of the fixed ones.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceId {
    pub body: Option<usize>,
    pub index: usize,
}

impl SurfaceId {
    /// First surface of a body.
    fn of_body(body: usize) -> Self {
        Self { body: Some(body), index: 0 }
    }
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
    /// Both in the middle between the closest points.
    Middle,
}

/// All components that the engine builds for a scene.
///
/// Stops, contacts, brakes, motors and servos share one element index, in this order.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    pub bodies: Vec<PlannedBody>,
    pub fixed_surfaces: Vec<PlannedSurface>,
    pub joints: Vec<PlannedJoint>,
    pub gears: Vec<PlannedGear>,
    pub motors: Vec<PlannedMotor>,
    pub servos: Vec<PlannedServo>,
    /// Actuators of a mechanism, in its order.
    pub actuators: Vec<PlannedActuator>,
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
    pub fn motor_torque(&self, body: usize, t: f64, (poses, velocities): (&[BodyPose], &[Twist])) -> f64 {
        let torque = |motor: &PlannedMotor| {
            let ratio = Some(motor.shaft.angle_ratio(body)).filter(|ratio| *ratio != 0.0)?;
            Some(ratio * motor.torque(t, motor.shaft.row(poses).rate(velocities)))
        };
        self.motors.iter().filter_map(torque).sum()
    }

    /// Returns the torque or force of an actuator at time `t`, at these poses and velocities.
    pub fn effort(&self, actuator: PlannedActuator, t: f64, (poses, velocities): (&[BodyPose], &[Twist])) -> f64 {
        match actuator {
            PlannedActuator::Motor(index) => {
                let motor = &self.motors[index];
                motor.torque(t, motor.shaft.row(poses).rate(velocities))
            }
            PlannedActuator::Servo(index) => self.servos[index].force(t, poses, velocities),
        }
    }

    /// Returns the next time after `t` at which a motor torque, a brake or the palm motion has a discontinuity.
    pub fn next_discontinuity(&self, t: f64) -> f64 {
        let motors = self.motors.iter().map(|motor| motor.actuation.next_discontinuity(t));
        let servos = self.servos.iter().map(|servo| servo.target.next_discontinuity(t));
        let brakes = self.brakes.iter().map(|brake| brake.brake.next_discontinuity(t));
        let palm = self.palm().map(|(_, motion)| motion.next_discontinuity(t));
        motors.chain(servos).chain(brakes).chain(palm).fold(f64::INFINITY, f64::min)
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

    /// Element index of the first servo.
    pub(crate) fn first_servo(&self) -> usize {
        self.first_motor() + self.motors.len()
    }

    pub(crate) fn surface(&self, id: SurfaceId) -> &PlannedSurface {
        let surfaces = id.body.map_or(&self.fixed_surfaces, |body| &self.bodies[body].surfaces);
        &surfaces[id.index]
    }

    /// Returns a point of a body frame, or of the world.
    pub(crate) fn body_point(&self, body: Option<usize>, point_m: [f64; 2]) -> BodyPoint {
        BodyPoint { body, arm_m: sub(point_m, body.map_or([0.0; 2], |body| self.bodies[body].body.com_m)) }
    }

    /// Returns the coordinate of a joint: an angle or a position.
    pub fn joint_coordinate(&self, joint: &PlannedJoint) -> Coordinate {
        match joint.kind {
            JointKind::Revolute => relative_angle(joint),
            JointKind::Prismatic { axis_rad } => self.joint_position(joint, axis_rad),
        }
    }

    /// Position of the second anchor of a joint relative to the first, along an axis of the first body.
    pub(crate) fn joint_position(&self, joint: &PlannedJoint, axis_rad: f64) -> Coordinate {
        let (sin, cos) = sin_cos(axis_rad);
        let points = [0, 1].map(|k: usize| self.body_point(joint.bodies[k], joint.anchors_m[k]));
        Coordinate { measure: Measure::Slide { points, axis: [cos, sin] }, offset: 0.0 }
    }
}

/// Angle of the second body of a joint relative to the first, less the offset of the joint.
pub(crate) fn relative_angle(joint: &PlannedJoint) -> Coordinate {
    let [first, second] = [joint.bodies[0].map(|body| (body, -1.0)), joint.bodies[1].map(|body| (body, 1.0))];
    let on = second.or(first).unwrap_or_default();
    Coordinate { measure: Measure::Angle { on, against: second.and(first) }, offset: joint.offset_rad }
}

impl PlannedMotor {
    fn stall_torque(&self, t: f64) -> f64 {
        self.actuation.at(t).0.clamp(-self.limit, self.limit)
    }

    /// Returns the stall torque at time `t`, N·m, and the torque lost per shaft rate, N·m·s/rad.
    pub(crate) fn characteristic(&self, t: f64) -> (f64, f64) {
        let stall_torque = self.stall_torque(t);
        (stall_torque, self.no_load_speed_rad_s.map_or(0.0, |speed| stall_torque.abs() / speed))
    }

    /// Returns the shaft torque at time `t`, N·m: τ − |τ| ω/ω₀ at the shaft rate ω.
    pub fn torque(&self, t: f64, shaft_rate: f64) -> f64 {
        let stall_torque = self.stall_torque(t);
        self.no_load_speed_rad_s.map_or(stall_torque, |speed| stall_torque - stall_torque.abs() * shaft_rate / speed)
    }
}

/// Index of the driven link l11 in its finger.
pub(crate) const L11: usize = 0;
/// Index of the coupler l12 in its finger.
pub(crate) const L12: usize = 1;
/// Index of the proximal phalanx l21 in its finger.
pub const L21: usize = 2;
/// Index of the distal phalanx l22 in its finger.
pub const L22: usize = 3;

/// Number of links of a finger.
pub(crate) const LINKS: usize = 4;

/// Body index of the first link of a finger; the others follow in order.
pub(crate) fn first_link(side: Side) -> usize {
    LINKS * side as usize
}

/// Builds the plan of a system.
///
/// Bodies are the links of the fingers, the moving discs in their order, a moving palm, and the wheels of a
/// differential.
///
/// # Errors
/// Returns the side of a finger whose initial angles do not close its loop.
pub fn build_plan(system: &System) -> Result<Plan, Side> {
    let mut plan = Plan { gravity_m_s2: system.gravity_m_s2, ..Plan::default() };
    let surfaces = disc_surfaces(&mut plan, system);
    let first_moving = LINKS * system.fingers.len();
    let moving = system.discs.iter().filter(|disc| disc.motion.moves());
    let palm = system.palm_motion.as_ref().map(|motion| (first_moving + moving.clone().count(), motion));
    // For a finger on fixed surfaces, and between discs, forces act at each surface's own closest point, as in the
    // thesis. Where fingers can push an object away, both models use the point on the surface that is not the disc's.
    let point_convention = if system.fingers.len() == 1 && moving.clone().count() == 0 {
        ContactPointConvention::EachSurface
    } else {
        ContactPointConvention::BodySurface
    };
    let contact_ids = system.contact_ids();
    for (side, finger) in system.fingers_by_side() {
        let mirror = side.mirror();
        let on = palm.map(|(body, _)| body);
        let mount = Mount { on, ground_m: [mirror * 0.5 * system.palm_width_m, 0.0], mirror };
        add_finger(&mut plan, finger, ContactTargets { discs: &surfaces, point_convention }, mount).ok_or(side)?;
        add_finger_channels(&mut plan, side, &contact_ids, (surfaces.len(), finger.limit.is_some()));
        add_motor(&mut plan, side, finger, on);
    }
    moving.for_each(|disc| add_disc(&mut plan, disc));
    if let Some((body, motion)) = palm {
        add_palm(&mut plan, body, motion, system.palm.is_some());
    }
    add_pairs(&mut plan, system, (&contact_ids, &surfaces), palm.map(|(body, _)| body));
    if let Some(differential) = &system.differential {
        add_differential(&mut plan, differential);
    }
    Ok(plan)
}

/// Returns the surfaces of all discs; adds those of fixed discs to the plan. The bodies of the others are added later.
fn disc_surfaces(plan: &mut Plan, system: &System) -> Vec<SurfaceId> {
    let mut next = LINKS * system.fingers.len();
    let surface = |disc: &Disc| match disc.motion {
        DiscMotion::Fixed => {
            let (shape, (sin, cos)) = (Shape::Disc(disc.shape), sin_cos(disc.angle_rad));
            plan.fixed_surfaces.push(PlannedSurface { shape, origin_m: disc.centre_m, direction: [cos, sin] });
            SurfaceId { body: None, index: plan.fixed_surfaces.len() - 1 }
        }
        DiscMotion::Driven { .. } | DiscMotion::Free { .. } => {
            next += 1;
            SurfaceId::of_body(next - 1)
        }
    };
    system.discs.iter().map(surface).collect()
}

/// Adds the contact channels of the stop and the contacts of a finger.
fn add_finger_channels(plan: &mut Plan, side: Side, contact_ids: &[ContactId], (discs, stops): (usize, bool)) {
    for (channel, id) in contact_ids.iter().enumerate() {
        match id {
            ContactId::Stop(own_side) if *own_side == side && stops => plan.stop_channels.push(channel),
            ContactId::Phalanx(own_side, _, disc) if *own_side == side && *disc < discs => {
                plan.contact_channels.push(channel)
            }
            _ => {}
        }
    }
}

/// Adds motor, rotor and brake of a finger.
fn add_motor(plan: &mut Plan, side: Side, finger: &DrivenFinger, palm: Option<usize>) {
    let (motor, driven, mirror) = (&finger.motor, first_link(side) + L11, side.mirror());
    // The rotor turns with the link, about a joint that is fixed in the palm.
    plan.bodies[driven].body.inertia_kg_m2 += motor.inertia_kg_m2;
    add_rotor(plan, driven, motor.inertia_kg_m2);
    let against = palm.map(|palm| (palm, -mirror));
    let shaft = Coordinate { measure: Measure::Angle { on: (driven, mirror), against }, offset: 0.0 };
    plan.motors.push(plan_motor(motor, shaft));
    plan.brakes.extend(motor.brake.map(|brake| PlannedBrake { shaft, brake, actuator: 0 }));
}

fn add_disc(plan: &mut Plan, disc: &Disc) {
    let (mass_kg, inertia_kg_m2, velocity_m_s, rate_rad_s) = match disc.motion {
        DiscMotion::Fixed => return,
        DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s } => {
            plan.drives.push(PlannedDrive {
                body: plan.bodies.len(),
                motion: PrescribedMotion::ConstantAcceleration { acceleration_m_s2 },
            });
            (0.0, 0.0, velocity_m_s, spin_rad_s)
        }
        DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s } => {
            (mass_kg, inertia_kg_m2.unwrap_or(0.0), velocity_m_s, spin_rad_s)
        }
    };
    plan.bodies.push(PlannedBody {
        body: Body { mass_kg, com_m: [0.0; 2], inertia_kg_m2 },
        origin_m: disc.centre_m,
        angle_rad: disc.angle_rad,
        velocity_m_s,
        rate_rad_s,
        gyration_m: 0.0,
        surfaces: vec![PlannedSurface::at_origin(Shape::Disc(disc.shape))],
    });
}

fn add_palm(plan: &mut Plan, body: usize, motion: &PalmMotion, is_solid: bool) {
    plan.drives.push(PlannedDrive { body, motion: PrescribedMotion::Palm(motion.clone()) });
    let surfaces = is_solid.then(|| PlannedSurface::at_origin(Shape::HalfPlane)).into_iter().collect();
    plan.bodies.push(PlannedBody { surfaces, ..PlannedBody::at_origin(0.0) });
}

/// Adds the contacts of discs with one another, with palm or ground, and with a table.
fn add_pairs(
    plan: &mut Plan,
    system: &System,
    (contact_ids, surfaces): (&[ContactId], &[SurfaceId]),
    palm: Option<usize>,
) {
    if !system.discs.iter().any(|disc| disc.motion.moves()) {
        return;
    }
    let mut half_plane = |level_m: f64, side: f64| {
        plan.fixed_surfaces.push(PlannedSurface {
            shape: Shape::HalfPlane,
            origin_m: [0.0, level_m],
            direction: [side, 0.0],
        });
        SurfaceId { body: None, index: plan.fixed_surfaces.len() - 1 }
    };
    let palm_plane = system.palm.and_then(|plane| Some((plane.contact?, plane.level_m)));
    let palm_plane =
        palm_plane.map(|(law, level_m)| (law, palm.map_or_else(|| half_plane(level_m, 1.0), SurfaceId::of_body)));
    let table_plane = system.table.and_then(|plane| Some((plane.contact?, half_plane(plane.level_m, -1.0))));
    let on_plane = if system.fingers.is_empty() {
        ContactPointConvention::EachSurface
    } else {
        ContactPointConvention::PartnerSurface
    };
    for (channel, id) in contact_ids.iter().enumerate() {
        let (disc, point_convention, other) = match *id {
            ContactId::Discs(disc, other) => {
                (disc, ContactPointConvention::EachSurface, system.between_discs.zip(surfaces.get(other).copied()))
            }
            ContactId::Palm(disc) => (disc, on_plane, palm_plane),
            ContactId::Table(disc) => (disc, on_plane, table_plane),
            ContactId::Phalanx(..) | ContactId::Stop(_) => continue,
        };
        // The first disc of a pair is a moving one.
        if let (Some(&SurfaceId { body: Some(body), index }), Some((law, against))) = (surfaces.get(disc), other) {
            plan.contacts.push(PlannedContact { body, surface: index, against, point_convention, law });
            plan.contact_channels.push(channel);
        }
    }
}

/// Surfaces that the phalanges of a finger can touch: all discs.
#[derive(Clone, Copy)]
struct ContactTargets<'a> {
    discs: &'a [SurfaceId],
    point_convention: ContactPointConvention,
}

/// Mounting of a finger: its base joint, and −1 for a finger mirrored about the y axis.
#[derive(Clone, Copy)]
struct Mount {
    /// Body that carries the finger; `None` is the ground.
    on: Option<usize>,
    ground_m: [f64; 2],
    mirror: f64,
}

/// Adds links, pins, spring, stop and contacts of a finger, but no motor; `None` if its angles do not close the loop.
fn add_finger(plan: &mut Plan, driven: &DrivenFinger, targets: ContactTargets<'_>, mount: Mount) -> Option<()> {
    let DrivenFinger { linkage: finger, initial: start, .. } = driven;
    let (lengths, Mount { mirror, ground_m, .. }) = (&finger.lengths, mount);
    let base = plan.bodies.len();
    let posture = close_loop(lengths, finger.assembly, start.q11_rad, start.q21_rad).ok()?;
    let angles = body_angles(&posture, lengths.phi22_rad);
    let link_end =
        |length: f64, angle: f64| [ground_m[0] + mirror * (length * cos(angle)), ground_m[1] + length * sin(angle)];
    let (a12, a22) = (link_end(lengths.l11_m, angles[L11]), link_end(lengths.l21_m, angles[L21]));
    let rates = body_rates(lengths, &angles, [start.qd11_rad_s, start.qd21_rad_s]);
    let radius_m = lengths.half_width_m;
    let capsules = [
        None,
        None,
        Some(Shape::Capsule(Capsule { length_m: lengths.l21_m, angle_rad: 0.0, radius_m })),
        Some(Shape::Capsule(Capsule { length_m: lengths.t22_m, angle_rad: mirror * lengths.phi22_rad, radius_m })),
    ];
    let masses = [finger.bodies.l11, finger.bodies.l12, finger.bodies.l21, finger.bodies.l22];
    let origins = [ground_m, a12, ground_m, a22];
    plan.bodies.extend((0..LINKS).map(|i| PlannedBody {
        body: Body { com_m: [masses[i].com_m[0], mirror * masses[i].com_m[1]], ..masses[i] },
        origin_m: origins[i],
        angle_rad: if mirror > 0.0 { angles[i] } else { PI - angles[i] },
        velocity_m_s: [0.0; 2],
        rate_rad_s: mirror * rates[i],
        gyration_m: 0.0,
        surfaces:
            capsules[i].filter(|_| !targets.discs.is_empty()).into_iter().map(PlannedSurface::at_origin).collect(),
    }));
    let pin = |first: Option<usize>, second: usize, length: f64| PlannedJoint {
        kind: JointKind::Revolute,
        bodies: [first.map_or(mount.on, |body| Some(base + body)), Some(base + second)],
        anchors_m: [if first.is_some() { [length, 0.0] } else { ground_m }, [0.0; 2]],
        offset_rad: 0.0,
        closes_loop: false,
    };
    let loop_pin = pin(Some(L12), L22, lengths.l12_m);
    plan.joints.extend([
        pin(None, L11, 0.0),
        pin(Some(L11), L12, lengths.l11_m),
        pin(None, L21, 0.0),
        pin(Some(L21), L22, lengths.l21_m),
        PlannedJoint { anchors_m: [loop_pin.anchors_m[0], [lengths.l22_m, 0.0]], closes_loop: true, ..loop_pin },
    ]);
    plan.springs.extend(plan_spring(driven.spring, lengths, mirror, base)?);
    // For a mirrored finger the angle from l21 to l22 becomes the angle from l22 to l21.
    let (on, against) = if mirror > 0.0 { (L22, L21) } else { (L21, L22) };
    let gap = Coordinate::angle_between(base + on, base + against, -lengths.phi22_rad);
    let stop = |law| PlannedStop { gap, law };
    plan.stops.extend(driven.limit.map(stop));
    for &against in targets.discs {
        for (body, law) in [(L21, driven.contact.proximal), (L22, driven.contact.distal)] {
            plan.contacts.push(PlannedContact {
                body: base + body,
                surface: 0,
                against,
                point_convention: targets.point_convention,
                law,
            });
        }
    }
    Some(())
}

/// Orientations of the four links. The angle of l22 is measured from the straight line, as q22 is in both models.
fn body_angles(posture: &Posture, phi22: f64) -> [f64; 4] {
    let direction = |angle: f64| [cos(angle), sin(angle)];
    let bend = opening_angle(direction(posture.q21_rad), direction(posture.q21_rad + posture.q22_rad + phi22));
    [posture.q11_rad, posture.q11_rad + posture.q12_rad, posture.q21_rad, posture.q21_rad + bend - phi22]
}

/// Angular rates of the four links from those of the base links; the loop's point A13 has one velocity.
fn body_rates(lengths: &Lengths, angles: &[f64; 4], [w1, w2]: [f64; 2]) -> [f64; 4] {
    // Velocity of the end of a link that rotates at rate 1.
    let end_velocity = |length: f64, angle: f64| [-length * sin(angle), length * cos(angle)];
    let (u1, u2) = (end_velocity(lengths.l11_m, angles[L11]), end_velocity(lengths.l21_m, angles[L21]));
    let (u3, u4) = (end_velocity(lengths.l12_m, angles[L12]), end_velocity(lengths.l22_m, angles[L22]));
    // w3 u3 − w4 u4 = w2 u2 − w1 u1
    let rhs = [w2 * u2[0] - w1 * u1[0], w2 * u2[1] - w1 * u1[1]];
    let determinant = u4[0] * u3[1] - u3[0] * u4[1];
    let w3 = (u4[0] * rhs[1] - rhs[0] * u4[1]) / determinant;
    let w4 = (u3[0] * rhs[1] - rhs[0] * u3[1]) / determinant;
    [w1, w3, w2, w4]
}

/// Returns the spring between the two links of its placement; the outer `None` if the straight posture does not exist.
fn plan_spring(spring: Option<Spring>, lengths: &Lengths, mirror: f64, base: usize) -> Option<Option<PlannedSpring>> {
    let Some(spring) = spring else { return Some(None) };
    let (on, against) = match spring.placement {
        Placement::GroundLinks => (L21, L11),
        Placement::DrivenCoupler => (L12, L11),
        Placement::Phalanges => (L22, L21),
        Placement::CouplerDistal => (L12, L22),
    };
    let angles = body_angles(&straight_posture(lengths, FRAC_PI_2).ok()?, lengths.phi22_rad);
    // Rate of the angle with q11 at constant q21.
    let rates = body_rates(lengths, &angles, [1.0, 0.0]);
    let angle = Coordinate::angle_between(base + on, base + against, mirror * (angles[on] - angles[against]));
    // The angle grows as the finger closes.
    let closes = mirror * (rates[on] - rates[against]).signum() > 0.0;
    Some(Some(PlannedSpring { extension: if closes { angle } else { angle.negated() }, kind: spring.kind }))
}

fn plan_motor(motor: &Motor, shaft: Coordinate) -> PlannedMotor {
    PlannedMotor {
        shaft,
        actuation: motor.actuation.clone(),
        limit: f64::INFINITY,
        no_load_speed_rad_s: motor.no_load_speed_rad_s,
    }
}

fn add_rotor(plan: &mut Plan, body: usize, inertia_kg_m2: f64) {
    if inertia_kg_m2 > 0.0 {
        plan.rotors.push(PlannedRotor { body, inertia_kg_m2 });
    }
}

/// Adds a differential: each finger gets half of the input torque. Components with inertia are wheels geared to both
/// driven links: the input turns by the mean of their closing angles, the seesaw by half of their difference.
fn add_differential(plan: &mut Plan, differential: &Differential) {
    let Differential { motor, seesaw_inertia_kg_m2 } = differential;
    let [right, left] = Side::BOTH.map(|side| first_link(side) + L11);
    let measure = Measure::Angle { on: (right, 0.5), against: Some((left, -0.5)) };
    let shaft = Coordinate { measure, offset: 0.0 };
    plan.motors.push(plan_motor(motor, shaft));
    plan.brakes.extend(motor.brake.map(|brake| PlannedBrake { shaft, brake, actuator: 0 }));
    let inertias = [motor.inertia_kg_m2, *seesaw_inertia_kg_m2];
    if inertias == [0.0; 2] {
        return;
    }
    let first = plan.bodies.len();
    let palm = plan.palm().map(|(body, _)| body);
    (0..2).for_each(|index| add_rotor(plan, first + index, inertias[index]));
    // A wheel without inertia has no effect; a decoupled dummy wheel replaces it.
    let is_geared = inertias.map(|inertia| if inertia > 0.0 { 1.0 } else { 0.0 });
    plan.bodies.extend(inertias.map(|inertia| PlannedBody::at_origin(if inertia > 0.0 { inertia } else { 1.0 })));
    let rates = [right, left].map(|body| plan.bodies[body].rate_rad_s);
    plan.bodies[first].rate_rad_s = is_geared[0] * 0.5 * (rates[0] - rates[1]);
    plan.bodies[first + 1].rate_rad_s = is_geared[1] * 0.5 * (rates[0] + rates[1]);
    let mut wheels = vec![
        (first, [1.0, 0.0]),
        (first + 1, [0.0, 1.0]),
        (right, [-0.5 * is_geared[0], -0.5 * is_geared[1]]),
        (left, [0.5 * is_geared[0], -0.5 * is_geared[1]]),
    ];
    // The rotation of the palm cancels in the mean of both closing angles, but not for wheels that turn relative to it.
    wheels.extend(palm.map(|palm| (palm, [-is_geared[0], 0.0])));
    let terms = wheels.into_iter().map(|(body, ratios)| (Coordinate::angle_of(body), ratios)).collect();
    plan.gears.push(PlannedGear { terms });
}

/// Torque of the brakes, each given by `torque`, on the driven link of a finger, N·m, positive in closing.
pub(crate) fn driven_link_brake_torque(plan: &Plan, side: Side, torque: impl Fn(usize) -> f64) -> f64 {
    let ratio = |brake: &PlannedBrake| side.mirror() * brake.shaft.angle_ratio(first_link(side) + L11);
    plan.brakes.iter().enumerate().map(|(index, brake)| ratio(brake) * torque(index)).sum()
}
