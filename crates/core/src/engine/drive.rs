//! Bodies that move as told, whatever they meet: rapier's kinematic bodies.
//!
//! They have no mass in the linkage, so that no impulse moves them; their velocities and accelerations are set here instead.

use rapier2d_f64::prelude::*;

use super::linkage::{Place, Twist};
use super::plan::{Plan, PlannedDrive};
use super::space::Space;
use super::substeps::Contact;

/// Velocities at time `t`.
pub fn set_velocities(plan: &Plan, t: f64, velocities: &mut [Twist]) {
    for PlannedDrive { body, acceleration_m_s2: [ax, ay] } in &plan.drives {
        let start = &plan.bodies[*body];
        let [vx, vy] = start.velocity_m_s;
        velocities[*body] = [vx + ax * t, vy + ay * t, start.rate_rad_s];
    }
}

pub fn set_accelerations(plan: &Plan, accelerations: &mut [Twist]) {
    for PlannedDrive { body, acceleration_m_s2: [ax, ay] } in &plan.drives {
        accelerations[*body] = [*ax, *ay, 0.0];
    }
}

/// Gives rapier the velocities that lead from where the bodies are at `t` to where they shall be at t + dt. Aiming at the
/// place, not at the mean velocity, keeps rounding from adding up.
pub fn steer(plan: &Plan, places: &[Place], handles: &[RigidBodyHandle], bodies: &mut RigidBodySet, t: f64, dt: f64) {
    for PlannedDrive { body, acceleration_m_s2 } in &plan.drives {
        let (start, place) = (&plan.bodies[*body], &places[*body]);
        let then = t + dt;
        let [vx, vy]: [f64; 2] = std::array::from_fn(|axis| {
            let moved = then * (start.velocity_m_s[axis] + 0.5 * then * acceleration_m_s2[axis]);
            (start.origin_m[axis] + moved - place.com[axis]) / dt
        });
        let turn = start.angle_rad + start.rate_rad_s * then - place.angle;
        let rigid = &mut bodies[handles[*body]];
        rigid.set_linvel(Vector::new(vx, vy), false);
        // rapier turns by atan(ω dt).
        rigid.set_angvel(turn.clamp(-LARGEST_TURN, LARGEST_TURN).tan() / dt, false);
    }
}

/// Work of contact on driven bodies over the step that starts with `velocities`, in J: what they move away from under a force
/// their drive has to make up for.
pub fn contact_work(plan: &Plan, space: &Space, contact: &Contact, velocities: &[Twist], dt: f64) -> f64 {
    let mut work = 0.0;
    for PlannedDrive { body, acceleration_m_s2: [ax, ay] } in &plan.drives {
        for (row, (early, late)) in space.rows.iter().zip(contact.early.iter().zip(&contact.late)) {
            // ∫ F ds and ∫ s F ds: early and late are their parts.
            let (impulse, moment) = (early + late, late * dt);
            work += impulse * row.rate_of(*body, &velocities[*body]) + moment * row.rate_of(*body, &[*ax, *ay, 0.0]);
        }
    }
    work
}

/// More than this rapier cannot turn in a step by its atan.
const LARGEST_TURN: f64 = 1.5;
