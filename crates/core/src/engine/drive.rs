//! Bodies with prescribed motion: rapier's kinematic bodies.
//!
//! They have no mass in the linkage, so impulses do not move them; their velocities and accelerations are set here.

use rapier2d_f64::prelude::*;

use super::contact_space::ContactSpace;
use super::dense::refill;
use super::linkage::{BodyPose, Twist};
use super::plan::{Plan, PlannedDrive, PrescribedMotion};
use super::substeps::ContactSolver;
use crate::numeric::elementary::tan;

/// Position and angle, velocity and acceleration of the origin of a driven body.
struct PrescribedState {
    position: [f64; 3],
    velocity: Twist,
    acceleration: Twist,
}

/// Returns the prescribed state of a driven body at time `t`.
fn prescribed_state(plan: &Plan, drive: &PlannedDrive, t: f64) -> PrescribedState {
    let start = &plan.bodies[drive.body];
    match &drive.motion {
        PrescribedMotion::ConstantAcceleration { acceleration_m_s2: [ax, ay] } => {
            let ([x, y], [vx, vy], rate) = (start.origin_m, start.velocity_m_s, start.rate_rad_s);
            let displacement = |v: f64, a: f64| t * (v + 0.5 * t * a);
            PrescribedState {
                position: [x + displacement(vx, *ax), y + displacement(vy, *ay), start.angle_rad + rate * t],
                velocity: [vx + ax * t, vy + ay * t, rate],
                acceleration: [*ax, *ay, 0.0],
            }
        }
        PrescribedMotion::Palm(motion) => {
            let pose = motion.pose(t);
            PrescribedState { position: pose.position, velocity: pose.rate, acceleration: pose.acceleration }
        }
    }
}

/// Sets the velocities of driven bodies at time `t`.
pub fn set_velocities(plan: &Plan, t: f64, velocities: &mut [Twist]) {
    for drive in &plan.drives {
        velocities[drive.body] = prescribed_state(plan, drive, t).velocity;
    }
}

/// Returns the accelerations of driven bodies at time `t`, with the body indices.
pub fn accelerations(plan: &Plan, t: f64, out: &mut Vec<(usize, Twist)>) {
    refill(out, plan.drives.iter().map(|drive| (drive.body, prescribed_state(plan, drive, t).acceleration)));
}

/// Returns the constant accelerations that, from these velocities, lead to the prescribed positions after `dt`.
pub fn mean_accelerations(
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
            PrescribedMotion::ConstantAcceleration { .. } => prescribed_state(plan, drive, t).acceleration,
            PrescribedMotion::Palm(_) => {
                let (target, pose, velocity) =
                    (prescribed_state(plan, drive, t + dt).position, &poses[body], &velocities[body]);
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
pub fn set_rapier_velocities(
    plan: &Plan,
    poses: &[BodyPose],
    handles: &[RigidBodyHandle],
    bodies: &mut RigidBodySet,
    t: f64,
    dt: f64,
) {
    for drive in &plan.drives {
        let (pose, target) = (&poses[drive.body], prescribed_state(plan, drive, t + dt).position);
        let [vx, vy]: [f64; 2] = std::array::from_fn(|axis| (target[axis] - pose.com[axis]) / dt);
        let rotation = target[2] - pose.angle;
        let rigid = &mut bodies[handles[drive.body]];
        rigid.set_linvel(Vector::new(vx, vy), false);
        // rapier rotates by atan(ω dt).
        rigid.set_angvel(tan(rotation.clamp(-MAX_ROTATION, MAX_ROTATION)) / dt, false);
    }
}

/// Returns the work of contact on driven bodies over the step that starts with `velocities`, J; the drives have to
/// supply it. A palm does no work in its own frame.
pub fn contact_work(plan: &Plan, space: &ContactSpace, solver: &ContactSolver, velocities: &[Twist], dt: f64) -> f64 {
    let mut work = 0.0;
    for drive in &plan.drives {
        let (body, PrescribedMotion::ConstantAcceleration { acceleration_m_s2: [ax, ay] }) =
            (drive.body, &drive.motion)
        else {
            continue;
        };
        for (row, (early_impulse, late_impulse)) in
            space.rows.iter().zip(solver.early_impulse.iter().zip(&solver.late_impulse))
        {
            // ∫ F ds and ∫ s F ds, from the early and late impulses.
            let (impulse, moment) = (early_impulse + late_impulse, late_impulse * dt);
            work += impulse * row.rate_of(body, &velocities[body]) + moment * row.rate_of(body, &[*ax, *ay, 0.0]);
        }
    }
    work
}

/// Largest rotation per step that rapier's atan can represent, rad.
const MAX_ROTATION: f64 = 1.5;
