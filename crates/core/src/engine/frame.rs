//! Frame of a moving palm: motion of bodies relative to the palm, and inertial forces due to the palm's motion.

use super::contact_space::ContactSpace;
use super::linkage::{BodyPose, Inertia, Linkage, Twist};
use super::plan::{ContactPartner, Plan, PlannedRotor};
use super::substeps::ContactSolver;
use crate::numeric::elementary::{cos, sin};
use crate::numeric::plane::{perp, rotate};
use crate::scene::Pose;

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
    pub fn angular_motion(&self) -> [f64; 3] {
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
    pub fn transport_velocity(&self, [x, y]: [f64; 2]) -> Twist {
        self.pose.map_or([0.0; 3], |Pose { position, rate, .. }| {
            let [u, v] = perp([x - position[0], y - position[1]]);
            [rate[0] + rate[2] * u, rate[1] + rate[2] * v, rate[2]]
        })
    }

    /// Returns the velocity and rate of a body relative to the palm frame, from its centre of mass and velocity in the
    /// world.
    pub fn twist(&self, centre: [f64; 2], velocity: &Twist) -> Twist {
        if self.pose.is_none() {
            return *velocity;
        }
        let transport = self.transport_velocity(centre);
        let [x, y] = self.direction([velocity[0] - transport[0], velocity[1] - transport[1]]);
        [x, y, velocity[2] - transport[2]]
    }

    /// Returns the accelerations of a body relative to the palm frame.
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

/// Returns the power of the palm motion on all bodies in its frame, W: of the rotating gravity vector and of inertial
/// forces.
pub fn power(plan: &Plan, linkage: &Linkage, velocities: &[Twist], t: f64) -> f64 {
    let frame = PalmFrame::at(plan, t);
    let Some(Pose { acceleration: [ax, ay, angular_acceleration], rate: [_, _, omega], .. }) = frame.pose else {
        return 0.0;
    };
    let [gx, gy] = plan.gravity_m_s2;
    let [fx, fy] = frame.direction([gx - ax, gy - ay]);
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

/// Returns the work, J, that contacts with surfaces fixed in the world extract through the transport velocity: minus
/// their work in the palm frame due to its motion; `t` is the middle of the step.
pub fn table_work(plan: &Plan, space: &ContactSpace, solver: &ContactSolver, linkage: &Linkage, t: f64) -> f64 {
    if plan.palm().is_none() {
        return 0.0;
    }
    let frame = PalmFrame::at(plan, t);
    let mut work = 0.0;
    for contact in &space.active_contacts {
        let Some(index) = contact.candidate.index.checked_sub(plan.stops.len()) else { continue };
        let Some(planned) = plan.contacts.get(index) else { continue };
        if let ContactPartner::Fixed(_) = planned.against {
            let transport = frame.transport_velocity(linkage.poses[planned.body].com);
            for row in std::iter::once(contact.normal).chain(contact.tangent) {
                work += (solver.early_impulse[row] + solver.late_impulse[row])
                    * space.rows[row].rate_of(planned.body, &transport);
            }
        }
    }
    work
}
