//! Smooth forces on the bodies: gravity, motor and spring.

use super::frame::Frame;
use super::linkage::{Inertia, Linkage, Place, Twist};
use super::plan::{Plan, PlannedMotor, PlannedSpring};
use crate::scene::SpringKind;

/// Forces and torques about the centres of mass at time `t`, at the places the linkage has. Motors that slow down with their rate
/// are rows of the contact space.
pub fn smooth(plan: &Plan, linkage: &Linkage, t: f64, out: &mut [Twist]) {
    let [gx, gy] = plan.gravity_m_s2;
    for (force, inertia) in out.iter_mut().zip(&linkage.inertias) {
        *force = [inertia.mass * gx, inertia.mass * gy, 0.0];
    }
    // Motors stand on the ground, which takes the reaction.
    for motor in plan.motors.iter().filter(|motor| motor.no_load_speed_rad_s.is_none()) {
        add_motor(motor, motor.characteristic(t).0, out);
    }
    if let Some((_, motion)) = plan.palm().filter(|_| !plan.rotors.is_empty()) {
        let turning = motion.pose(t).acceleration[2];
        plan.rotors.iter().for_each(|rotor| out[rotor.body][2] += rotor.inertia_kg_m2 * turning);
    }
    for spring in &plan.springs {
        let torque = -spring.closing_sign * pull(spring, extension(spring, linkage));
        out[spring.on][2] += torque;
        out[spring.against][2] -= torque;
    }
}

/// Torques of the motors that slow down with their rate, at time `t` and these velocities.
pub fn add_slowed_motors(plan: &Plan, velocities: &[Twist], t: f64, out: &mut [Twist]) {
    for motor in plan.motors.iter().filter(|motor| motor.no_load_speed_rad_s.is_some()) {
        add_motor(motor, motor.torque(t, |body| velocities[body][2]), out);
    }
}

fn add_motor(motor: &PlannedMotor, torque: f64, out: &mut [Twist]) {
    motor.on.iter().for_each(|(body, part)| out[*body][2] += part * torque);
}

/// Δq_s, positive in closing, in rad.
fn extension(spring: &PlannedSpring, linkage: &Linkage) -> f64 {
    let angle = linkage.places[spring.on].angle - linkage.places[spring.against].angle;
    spring.closing_sign * (angle - spring.straight_rad)
}

fn pull(spring: &PlannedSpring, extension: f64) -> f64 {
    match spring.kind {
        SpringKind::Constant { torque_n_m } => torque_n_m,
        SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
            stiffness_n_m_per_rad * (preload_rad + extension)
        }
    }
}

/// Energies of gravity and spring, in J, in the frame of a palm that moves; the spring's is zero in the straight configuration.
pub fn potential(plan: &Plan, linkage: &Linkage, frame: &Frame) -> (f64, f64) {
    let [gx, gy] = plan.gravity_m_s2;
    let of = |(inertia, place): (&Inertia, &Place)| {
        let [x, y] = frame.point(place.com);
        -inertia.mass * (gx * x + gy * y)
    };
    let gravity = linkage.inertias.iter().zip(&linkage.places).map(of).sum();
    let stored = |spring: &PlannedSpring| {
        let extension = extension(spring, linkage);
        match spring.kind {
            SpringKind::Constant { torque_n_m } => torque_n_m * extension,
            SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
                stiffness_n_m_per_rad * extension * (preload_rad + 0.5 * extension)
            }
        }
    };
    (gravity, plan.springs.iter().map(stored).sum())
}

/// Kinetic energy of all bodies, in J, in the frame of a palm that moves.
pub fn kinetic(linkage: &Linkage, velocities: &[Twist], frame: &Frame) -> f64 {
    let of = |((inertia, place), v): ((&Inertia, &Place), &Twist)| {
        let [vx, vy, rate] = frame.twist(place.com, v);
        0.5 * (inertia.mass * (vx * vx + vy * vy) + inertia.inertia * rate * rate)
    };
    linkage.inertias.iter().zip(&linkage.places).zip(velocities).map(of).sum()
}
