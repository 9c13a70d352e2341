//! Bodies that move as told, whatever they meet: rapier's kinematic bodies.
//!
//! They have no mass in the linkage, so that no impulse moves them; their velocities and accelerations are set here instead.

use rapier2d_f64::prelude::*;

use super::linkage::{Place, Twist};
use super::plan::{Course, Plan, PlannedDrive};
use super::space::Space;
use super::substeps::Contact;
use crate::numeric::elementary::tan;

/// Where a driven body's origin is at a time, with its angle; velocity; acceleration.
struct Told {
    place: [f64; 3],
    velocity: Twist,
    acceleration: Twist,
}

fn told(plan: &Plan, drive: &PlannedDrive, t: f64) -> Told {
    let start = &plan.bodies[drive.body];
    match &drive.course {
        Course::Even { acceleration_m_s2: [ax, ay] } => {
            let ([x, y], [vx, vy], rate) = (start.origin_m, start.velocity_m_s, start.rate_rad_s);
            let moved = |v: f64, a: f64| t * (v + 0.5 * t * a);
            Told {
                place: [x + moved(vx, *ax), y + moved(vy, *ay), start.angle_rad + rate * t],
                velocity: [vx + ax * t, vy + ay * t, rate],
                acceleration: [*ax, *ay, 0.0],
            }
        }
        Course::Palm(motion) => {
            let pose = motion.pose(t);
            Told { place: pose.place, velocity: pose.rate, acceleration: pose.acceleration }
        }
    }
}

/// Velocities at time `t`.
pub fn set_velocities(plan: &Plan, t: f64, velocities: &mut [Twist]) {
    for drive in &plan.drives {
        velocities[drive.body] = told(plan, drive, t).velocity;
    }
}

/// Accelerations at time `t`, body by body.
pub fn accelerations(plan: &Plan, t: f64, out: &mut Vec<(usize, Twist)>) {
    out.clear();
    out.extend(plan.drives.iter().map(|drive| (drive.body, told(plan, drive, t).acceleration)));
}

/// Even accelerations from these velocities that lead in `dt` to where bodies shall be then.
pub fn mean_accelerations(
    plan: &Plan,
    places: &[Place],
    velocities: &[Twist],
    t: f64,
    dt: f64,
    out: &mut Vec<(usize, Twist)>,
) {
    out.clear();
    out.extend(plan.drives.iter().map(|drive| {
        let body = drive.body;
        let acceleration = match drive.course {
            Course::Even { .. } => told(plan, drive, t).acceleration,
            Course::Palm(_) => {
                let (then, place, now) = (told(plan, drive, t + dt).place, &places[body], &velocities[body]);
                let moved = [then[0] - place.com[0], then[1] - place.com[1], then[2] - place.angle];
                std::array::from_fn(|axis| 2.0 * (moved[axis] / dt - now[axis]) / dt)
            }
        };
        (body, acceleration)
    }));
}

/// Gives rapier the velocities that lead from where the bodies are at `t` to where they shall be at t + dt. Aiming at the
/// place, not at the mean velocity, keeps rounding from adding up.
pub fn steer(plan: &Plan, places: &[Place], handles: &[RigidBodyHandle], bodies: &mut RigidBodySet, t: f64, dt: f64) {
    for drive in &plan.drives {
        let (place, then) = (&places[drive.body], told(plan, drive, t + dt).place);
        let [vx, vy]: [f64; 2] = std::array::from_fn(|axis| (then[axis] - place.com[axis]) / dt);
        let turn = then[2] - place.angle;
        let rigid = &mut bodies[handles[drive.body]];
        rigid.set_linvel(Vector::new(vx, vy), false);
        // rapier turns by atan(ω dt).
        rigid.set_angvel(tan(turn.clamp(-LARGEST_TURN, LARGEST_TURN)) / dt, false);
    }
}

/// Work of contact on driven bodies over the step that starts with `velocities`, in J: what they move away from under a force
/// their drive has to make up for. A palm does none in its own frame.
pub fn contact_work(plan: &Plan, space: &Space, contact: &Contact, velocities: &[Twist], dt: f64) -> f64 {
    let mut work = 0.0;
    for drive in &plan.drives {
        let (body, Course::Even { acceleration_m_s2: [ax, ay] }) = (drive.body, &drive.course) else { continue };
        for (row, (early, late)) in space.rows.iter().zip(contact.early.iter().zip(&contact.late)) {
            // ∫ F ds and ∫ s F ds: early and late are their parts.
            let (impulse, moment) = (early + late, late * dt);
            work += impulse * row.rate_of(body, &velocities[body]) + moment * row.rate_of(body, &[*ax, *ay, 0.0]);
        }
    }
    work
}

/// More than this rapier cannot turn in a step by its atan.
const LARGEST_TURN: f64 = 1.5;
