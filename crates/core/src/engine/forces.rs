//! Smooth forces on the bodies: gravity, motors and springs.

use super::frame::PalmFrame;
use super::linkage::{BodyPose, Inertia, Linkage, Twist};
use super::plan::{Plan, PlannedMotor, PlannedSpring};
use crate::scene::SpringKind;

/// Computes forces and torques about the centres of mass at time `t`, at the poses of the linkage. Motors with a
/// no-load speed are rows of the contact space instead.
pub fn smooth_forces(plan: &Plan, linkage: &Linkage, t: f64, out: &mut [Twist]) {
    let [gx, gy] = plan.gravity_m_s2;
    for (force, inertia) in out.iter_mut().zip(&linkage.inertias) {
        *force = [inertia.mass * gx, inertia.mass * gy, 0.0];
    }
    // Motors are supported by the ground, which takes the reaction.
    for motor in plan.motors.iter().filter(|motor| motor.no_load_speed_rad_s.is_none()) {
        add_motor(motor, motor.characteristic(t).0, out);
    }
    if let Some((_, motion)) = plan.palm().filter(|_| !plan.rotors.is_empty()) {
        let palm_acceleration = motion.pose(t).acceleration[2];
        plan.rotors.iter().for_each(|rotor| out[rotor.body][2] += rotor.inertia_kg_m2 * palm_acceleration);
    }
    for spring in &plan.springs {
        let torque = -spring.closing_sign * spring_torque(spring, extension(spring, linkage));
        out[spring.on][2] += torque;
        out[spring.against][2] -= torque;
    }
}

/// Adds the torques of motors with a no-load speed, at time `t` and these velocities.
pub fn add_speed_dependent_motors(plan: &Plan, velocities: &[Twist], t: f64, out: &mut [Twist]) {
    for motor in plan.motors.iter().filter(|motor| motor.no_load_speed_rad_s.is_some()) {
        add_motor(motor, motor.torque(t, |body| velocities[body][2]), out);
    }
}

fn add_motor(motor: &PlannedMotor, torque: f64, out: &mut [Twist]) {
    motor.on.iter().for_each(|(body, ratio)| out[*body][2] += ratio * torque);
}

/// Spring extension Δq_s, positive in closing, rad.
fn extension(spring: &PlannedSpring, linkage: &Linkage) -> f64 {
    let angle = linkage.poses[spring.on].angle - linkage.poses[spring.against].angle;
    spring.closing_sign * (angle - spring.straight_rad)
}

/// Spring torque against closing, N·m.
fn spring_torque(spring: &PlannedSpring, extension: f64) -> f64 {
    match spring.kind {
        SpringKind::Constant { torque_n_m } => torque_n_m,
        SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
            stiffness_n_m_per_rad * (preload_rad + extension)
        }
    }
}

/// Returns the energies of gravity and springs, J, in the frame of a moving palm; the spring energy is zero in the
/// straight configuration.
pub fn potential_energies(plan: &Plan, linkage: &Linkage, frame: &PalmFrame) -> (f64, f64) {
    let [gx, gy] = plan.gravity_m_s2;
    let gravity_energy = |(inertia, pose): (&Inertia, &BodyPose)| {
        let [x, y] = frame.point(pose.com);
        -inertia.mass * (gx * x + gy * y)
    };
    let gravity = linkage.inertias.iter().zip(&linkage.poses).map(gravity_energy).sum();
    let spring_energy = |spring: &PlannedSpring| {
        let extension = extension(spring, linkage);
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
