//! The frame of a palm that moves: bodies of the world as they are seen from there, and what its motion does to them.

use super::linkage::{Inertia, Linkage, Place, Twist};
use super::plan::{Against, Plan, PlannedRotor};
use super::space::Space;
use super::substeps::Contact;
use crate::numeric::elementary::{cos, sin};
use crate::numeric::plane::{perp, rotate};
use crate::scene::Pose;

/// The palm's pose at one instant; that of the world where no palm moves.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pose: Option<Pose>,
    direction: [f64; 2],
}

impl Frame {
    pub fn at(plan: &Plan, t: f64) -> Self {
        let pose = plan.palm().map(|(_, motion)| motion.pose(t));
        let angle = pose.map_or(0.0, |pose| pose.place[2]);
        Self { pose, direction: [cos(angle), sin(angle)] }
    }

    /// The palm's angle and two derivatives.
    pub fn turning(&self) -> [f64; 3] {
        self.pose.map_or([0.0; 3], |pose| [pose.place[2], pose.rate[2], pose.acceleration[2]])
    }

    /// A direction of the world.
    pub fn along(&self, direction: [f64; 2]) -> [f64; 2] {
        let [cos, sin] = self.direction;
        if self.pose.is_some() { rotate(direction, [cos, -sin]) } else { direction }
    }

    /// A point of the world.
    pub fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        self.pose.map_or([x, y], |pose| self.along([x - pose.place[0], y - pose.place[1]]))
    }

    /// Velocity in the world of a point that stands still in the frame, and its rate of turning.
    pub fn carried(&self, [x, y]: [f64; 2]) -> Twist {
        self.pose.map_or([0.0; 3], |Pose { place, rate, .. }| {
            let [u, v] = perp([x - place[0], y - place[1]]);
            [rate[0] + rate[2] * u, rate[1] + rate[2] * v, rate[2]]
        })
    }

    /// Velocity and rate of a body whose centre of mass is there.
    pub fn twist(&self, centre: [f64; 2], velocity: &Twist) -> Twist {
        if self.pose.is_none() {
            return *velocity;
        }
        let carried = self.carried(centre);
        let [x, y] = self.along([velocity[0] - carried[0], velocity[1] - carried[1]]);
        [x, y, velocity[2] - carried[2]]
    }

    /// Its accelerations as they are seen there.
    pub fn acceleration(&self, centre: [f64; 2], velocity: &Twist, acceleration: &Twist) -> Twist {
        let Some(Pose { acceleration: [ax, ay, turning], rate: [_, _, omega], .. }) = self.pose else {
            return *acceleration;
        };
        let ([x, y], [vx, vy, _]) = (self.point(centre), self.twist(centre, velocity));
        let [bx, by] = self.along([acceleration[0] - ax, acceleration[1] - ay]);
        [
            bx + turning * y + omega * (omega * x + 2.0 * vy),
            by - turning * x + omega * (omega * y - 2.0 * vx),
            acceleration[2] - turning,
        ]
    }
}

/// Power that the palm's motion gives to all that moves in its frame, W: of gravity as it turns, and of inertial forces.
pub fn power(plan: &Plan, linkage: &Linkage, velocities: &[Twist], t: f64) -> f64 {
    let frame = Frame::at(plan, t);
    let Some(Pose { acceleration: [ax, ay, turning], rate: [_, _, omega], .. }) = frame.pose else { return 0.0 };
    let [gx, gy] = plan.gravity_m_s2;
    let [fx, fy] = frame.along([gx - ax, gy - ay]);
    let of = |((inertia, place), v): ((&Inertia, &Place), &Twist)| {
        let ([x, y], [vx, vy, rate]) = (frame.point(place.com), frame.twist(place.com, v));
        // The Coriolis force does no work.
        let feels = [fx - gx + turning * y + omega * omega * x, fy - gy - turning * x + omega * omega * y];
        inertia.mass * (feels[0] * vx + feels[1] * vy) - inertia.inertia * turning * rate
    };
    let bodies: f64 = linkage.inertias.iter().zip(&linkage.places).zip(velocities).map(of).sum();
    // Rotors count their rates against the palm.
    let rotor = |rotor: &PlannedRotor| rotor.inertia_kg_m2 * turning * (velocities[rotor.body][2] - omega);
    bodies + plan.rotors.iter().map(rotor).sum::<f64>()
}

/// What contacts with surfaces that rest in the world take from what is carried along them, J: minus the work that they do in the frame
/// by coming along; `t` is the middle of the step.
pub fn table_work(plan: &Plan, space: &Space, contact: &Contact, linkage: &Linkage, t: f64) -> f64 {
    if plan.palm().is_none() {
        return 0.0;
    }
    let frame = Frame::at(plan, t);
    let mut work = 0.0;
    for site in &space.sites {
        let Some(index) = site.touch.index.checked_sub(plan.stops.len()) else { continue };
        let Some(planned) = plan.contacts.get(index) else { continue };
        if let Against::Fixed(_) = planned.against {
            let carried = frame.carried(linkage.places[planned.body].com);
            for row in std::iter::once(site.normal).chain(site.tangent) {
                work += (contact.early[row] + contact.late[row]) * space.rows[row].rate_of(planned.body, &carried);
            }
        }
    }
    work
}
