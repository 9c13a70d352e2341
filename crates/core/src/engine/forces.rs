//! Loads and prescribed motions: gravity, motors and springs; bodies with prescribed motion, which are rapier's
//! kinematic bodies; and the frame of a moving palm, with the motion of bodies relative to it and its inertial forces.
//!
//! Bodies with prescribed motion have no mass in the linkage, so impulses do not move them; their velocities and
//! accelerations are set here.

use rapier2d_f64::prelude::{Pose as RapierPose, RigidBodyHandle, RigidBodySet, Rotation, Vector};

use super::coordinate::{BodyPose, Twist};
use super::linkage::{Inertia, Linkage};
use super::lists::refill;
use super::plan::{Plan, PlannedBody, PlannedDrive, PlannedRotor, PlannedSpring};
use crate::mechanism::PrescribedMotion;
use crate::numeric::elementary::{atan2, cos, sin, sin_cos, tan};
use crate::numeric::plane::{perp, rotate};
use crate::scene::{Pose, SpringKind};

/// Computes forces and torques about the centres of mass at time `t`, at the poses of the linkage. Motors with a
/// no-load speed and servos are rows of the contact space instead.
pub(crate) fn smooth_forces(plan: &Plan, linkage: &Linkage, t: f64, out: &mut [Twist]) {
    let [gx, gy] = plan.gravity_m_s2;
    for (force, inertia) in out.iter_mut().zip(&linkage.inertias) {
        *force = [inertia.mass * gx, inertia.mass * gy, 0.0];
    }
    for motor in plan.motors.iter().filter(|motor| motor.no_load_speed_rad_s.is_none()) {
        motor.shaft.row(&linkage.poses).add_to(out, motor.stall_torque(t));
    }
    if let Some((_, motion)) = plan.palm().filter(|_| !plan.rotors.is_empty()) {
        let palm_acceleration = motion.pose(t).acceleration[2];
        plan.rotors.iter().for_each(|rotor| out[rotor.body][2] += rotor.inertia_kg_m2 * palm_acceleration);
    }
    for spring in &plan.springs {
        let torque = spring_torque(spring, spring.extension.value(&linkage.poses));
        spring.extension.row(&linkage.poses).add_to(out, -torque);
    }
}

/// Adds the forces of motors with a no-load speed and of servos, at time `t` and these velocities.
pub(crate) fn add_speed_dependent_forces(
    plan: &Plan,
    poses: &[BodyPose],
    velocities: &[Twist],
    t: f64,
    out: &mut [Twist],
) {
    for motor in plan.motors.iter().filter(|motor| motor.no_load_speed_rad_s.is_some()) {
        let shaft = motor.shaft.row(poses);
        shaft.add_to(out, motor.torque(t, shaft.rate(velocities)));
    }
    for servo in &plan.servos {
        servo.coordinate.row(poses).add_to(out, servo.force(t, poses, velocities));
    }
}

/// Spring torque or force against the extension.
fn spring_torque(spring: &PlannedSpring, extension: f64) -> f64 {
    match spring.kind {
        SpringKind::Constant { torque_n_m } => torque_n_m,
        SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
            stiffness_n_m_per_rad * (preload_rad + extension)
        }
    }
}

/// Returns the energies of gravity and of the springs, J, in the palm frame. The energy of the springs is zero in the
/// straight posture.
pub fn potential_energies(plan: &Plan, linkage: &Linkage, frame: &PalmFrame) -> (f64, f64) {
    let [gx, gy] = plan.gravity_at_start();
    let gravity_energy = |(inertia, pose): (&Inertia, &BodyPose)| {
        let [x, y] = frame.point(pose.com);
        -inertia.mass * (gx * x + gy * y)
    };
    let gravity = linkage.inertias.iter().zip(&linkage.poses).map(gravity_energy).sum();
    let spring_energy = |spring: &PlannedSpring| {
        let extension = spring.extension.value(&linkage.poses);
        match spring.kind {
            SpringKind::Constant { torque_n_m } => torque_n_m * extension,
            SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
                stiffness_n_m_per_rad * extension * (preload_rad + 0.5 * extension)
            }
        }
    };
    (gravity, plan.springs.iter().map(spring_energy).sum())
}

/// Returns the kinetic energy of all bodies, J, in the frame of a moving palm.
pub fn kinetic_energy(linkage: &Linkage, velocities: &[Twist], frame: &PalmFrame) -> f64 {
    let body_energy = |((inertia, pose), v): ((&Inertia, &BodyPose), &Twist)| {
        let [vx, vy, rate] = frame.twist(pose.com, v);
        0.5 * (inertia.mass * (vx * vx + vy * vy) + inertia.inertia * rate * rate)
    };
    linkage.inertias.iter().zip(&linkage.poses).zip(velocities).map(body_energy).sum()
}

/// Returns the prescribed pose of a driven body at time `t`.
pub(super) fn prescribed_pose(plan: &Plan, drive: &PlannedDrive, t: f64) -> Pose {
    let PlannedBody { origin_m: [x, y], angle_rad, velocity_m_s: [vx, vy], rate_rad_s, .. } = plan.bodies[drive.body];
    drive.motion.at(([x, y, angle_rad], [vx, vy, rate_rad_s]), t)
}

/// Sets the velocities of driven bodies at time `t`.
pub(crate) fn set_driven_velocities(plan: &Plan, t: f64, velocities: &mut [Twist]) {
    for drive in &plan.drives {
        velocities[drive.body] = prescribed_pose(plan, drive, t).rate;
    }
}

/// Returns the accelerations of driven bodies at time `t`, with the body indices.
pub(crate) fn driven_accelerations(plan: &Plan, t: f64, out: &mut Vec<(usize, Twist)>) {
    refill(out, plan.drives.iter().map(|drive| (drive.body, prescribed_pose(plan, drive, t).acceleration)));
}

/// Returns the constant accelerations that, from these velocities, lead to the prescribed positions after `dt`.
pub(crate) fn mean_driven_accelerations(
    plan: &Plan,
    poses: &[BodyPose],
    velocities: &[Twist],
    t: f64,
    dt: f64,
    out: &mut Vec<(usize, Twist)>,
) {
    let mean = |drive: &PlannedDrive| {
        let body = drive.body;
        let acceleration = match drive.motion {
            PrescribedMotion::ConstantAcceleration { .. } => prescribed_pose(plan, drive, t).acceleration,
            PrescribedMotion::Palm(_) => {
                let (target, pose, velocity) =
                    (prescribed_pose(plan, drive, t + dt).position, &poses[body], &velocities[body]);
                let displacement = [target[0] - pose.com[0], target[1] - pose.com[1], target[2] - pose.angle];
                std::array::from_fn(|axis| 2.0 * (displacement[axis] / dt - velocity[axis]) / dt)
            }
        };
        (body, acceleration)
    };
    refill(out, plan.drives.iter().map(mean));
}

/// Sets rapier's velocities so that the bodies move from their poses at `t` to the prescribed poses at t + dt.
/// Targeting the position rather than the mean velocity avoids accumulation of rounding errors.
pub(crate) fn set_rapier_velocities(
    plan: &Plan,
    poses: &[BodyPose],
    handles: &[RigidBodyHandle],
    bodies: &mut RigidBodySet,
    t: f64,
    dt: f64,
) {
    for drive in &plan.drives {
        let (pose, target) = (&poses[drive.body], prescribed_pose(plan, drive, t + dt).position);
        let [vx, vy]: [f64; 2] = std::array::from_fn(|axis| (target[axis] - pose.com[axis]) / dt);
        let rotation = target[2] - pose.angle;
        let rigid = &mut bodies[handles[drive.body]];
        rigid.set_linvel(Vector::new(vx, vy), false);
        // rapier rotates by atan(ω dt).
        rigid.set_angvel(tan(rotation.clamp(-MAX_ROTATION, MAX_ROTATION)) / dt, false);
    }
}

/// Turns bodies about their centres of mass by the part of ω dt by which rapier's step, atan(ω dt), is too small. This
/// part, (ω dt)³/3 a step, would be the largest error in the closing of a finger.
pub(super) fn complete_rotations(handles: &[RigidBodyHandle], bodies: &mut RigidBodySet, dt: f64) {
    for handle in handles {
        let body = &mut bodies[*handle];
        let turn = body.angvel() * dt;
        let missing = turn - atan2(turn, 1.0);
        if missing == 0.0 {
            continue;
        }
        let (sin, cos) = sin_cos(missing);
        let rotation = Rotation::from_cos_sin_unchecked(cos, sin) * *body.rotation();
        let translation = body.center_of_mass() - rotation * body.local_center_of_mass();
        body.set_position(RapierPose::from_parts(translation, rotation), false);
    }
}

/// Moment on the rotors of a body that keeps their rates relative to the palm.
pub(super) fn rotor_moment(plan: &Plan, body: usize, t: f64) -> f64 {
    let rotors = plan.rotors.iter().filter(|rotor| rotor.body == body);
    let inertia: f64 = rotors.map(|rotor| rotor.inertia_kg_m2).sum();
    plan.palm().map_or(0.0, |(_, motion)| inertia * motion.pose(t).acceleration[2])
}

/// Largest rotation per step that rapier's atan can represent, rad.
const MAX_ROTATION: f64 = 1.5;

/// Pose of the palm at one instant; the world frame if the palm does not move.
#[derive(Clone, Copy, Debug)]
pub struct PalmFrame {
    pose: Option<Pose>,
    axes: [f64; 2],
}

impl PalmFrame {
    /// Returns the palm frame at time `t`.
    pub fn at(plan: &Plan, t: f64) -> Self {
        let pose = plan.palm().map(|(_, motion)| motion.pose(t));
        let angle = pose.map_or(0.0, |pose| pose.position[2]);
        Self { pose, axes: [cos(angle), sin(angle)] }
    }

    /// Returns the palm angle and its two time derivatives.
    pub(crate) fn angular_motion(&self) -> [f64; 3] {
        self.pose.map_or([0.0; 3], |pose| [pose.position[2], pose.rate[2], pose.acceleration[2]])
    }

    /// Transforms a direction from the world to the palm frame.
    pub fn direction(&self, direction: [f64; 2]) -> [f64; 2] {
        let [cos, sin] = self.axes;
        if self.pose.is_some() { rotate(direction, [cos, -sin]) } else { direction }
    }

    /// Transforms a point from the world to the palm frame.
    pub fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        self.pose.map_or([x, y], |pose| self.direction([x - pose.position[0], y - pose.position[1]]))
    }

    /// Returns the transport velocity: world velocity of a point fixed in the palm frame, and the palm's angular rate.
    pub(crate) fn transport_velocity(&self, [x, y]: [f64; 2]) -> Twist {
        self.pose.map_or([0.0; 3], |Pose { position, rate, .. }| {
            let [u, v] = perp([x - position[0], y - position[1]]);
            [rate[0] + rate[2] * u, rate[1] + rate[2] * v, rate[2]]
        })
    }

    /// Returns velocity and rate of a body relative to the palm, from its centre of mass and velocity in the world.
    pub(crate) fn twist(&self, centre: [f64; 2], velocity: &Twist) -> Twist {
        if self.pose.is_none() {
            return *velocity;
        }
        let transport = self.transport_velocity(centre);
        let [x, y] = self.direction([velocity[0] - transport[0], velocity[1] - transport[1]]);
        [x, y, velocity[2] - transport[2]]
    }

    /// Returns the acceleration of a body relative to the palm frame.
    pub fn acceleration(&self, centre: [f64; 2], velocity: &Twist, acceleration: &Twist) -> Twist {
        let Some(Pose { acceleration: [ax, ay, angular_acceleration], rate: [_, _, omega], .. }) = self.pose else {
            return *acceleration;
        };
        let ([x, y], [vx, vy, _]) = (self.point(centre), self.twist(centre, velocity));
        let [bx, by] = self.direction([acceleration[0] - ax, acceleration[1] - ay]);
        [
            bx + angular_acceleration * y + omega * (omega * x + 2.0 * vy),
            by - angular_acceleration * x + omega * (omega * y - 2.0 * vx),
            acceleration[2] - angular_acceleration,
        ]
    }
}

/// Returns the power of the palm motion on all bodies in its frame, W: of rotating gravity and of inertial forces.
pub(crate) fn palm_power(plan: &Plan, linkage: &Linkage, velocities: &[Twist], t: f64) -> f64 {
    let frame = PalmFrame::at(plan, t);
    let Some(Pose { acceleration: [ax, ay, angular_acceleration], rate: [_, _, omega], .. }) = frame.pose else {
        return 0.0;
    };
    let ([world_x, world_y], [gx, gy]) = (plan.gravity_m_s2, plan.gravity_at_start());
    let [fx, fy] = frame.direction([world_x - ax, world_y - ay]);
    let body_power = |((inertia, pose), v): ((&Inertia, &BodyPose), &Twist)| {
        let ([x, y], [vx, vy, rate]) = (frame.point(pose.com), frame.twist(pose.com, v));
        // The Coriolis force does no work.
        let inertial = [
            fx - gx + angular_acceleration * y + omega * omega * x,
            fy - gy - angular_acceleration * x + omega * omega * y,
        ];
        inertia.mass * (inertial[0] * vx + inertial[1] * vy) - inertia.inertia * angular_acceleration * rate
    };
    let bodies: f64 = linkage.inertias.iter().zip(&linkage.poses).zip(velocities).map(body_power).sum();
    // Rotor rates are relative to the palm.
    let rotor_power =
        |rotor: &PlannedRotor| rotor.inertia_kg_m2 * angular_acceleration * (velocities[rotor.body][2] - omega);
    bodies + plan.rotors.iter().map(rotor_power).sum::<f64>()
}
