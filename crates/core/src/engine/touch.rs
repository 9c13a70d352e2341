//! Where surfaces and stops are to each other: gaps, normals and the rows that give their rates from body velocities.

use std::f64::consts::TAU;

use parry2d_f64::query;
use rapier2d_f64::prelude::*;

use super::linkage::{Linkage, Place, Twist};
use super::plan::{Against, Meet, Plan, PlannedContact, PlannedHold, PlannedMotor};
use super::surfaces::{self, Surfaces};
use super::world::World;
use crate::law::{Bristle, FrictionLaw, NormalLaw, Stepped, friction_coefficient, stepped};
use crate::numeric::elementary::hypot;
use crate::numeric::plane::{cross, perp, rotate, sub};
use crate::scene::Response;

/// A generalised direction: what a unit impulse along it gives to each body it acts on.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    pub on: (usize, Twist),
    pub against: Option<(usize, Twist)>,
}

impl Row {
    /// Rate along the row.
    pub fn rate(&self, velocities: &[Twist]) -> f64 {
        let along = |(body, row): &(usize, Twist)| {
            let v = &velocities[*body];
            row[0] * v[0] + row[1] * v[1] + row[2] * v[2]
        };
        along(&self.on) + self.against.as_ref().map_or(0.0, along)
    }

    /// The part of the rate that is one body's own.
    pub fn rate_of(&self, body: usize, velocity: &Twist) -> f64 {
        let own = std::iter::once(&self.on).chain(&self.against).filter(|(on, _)| *on == body);
        own.map(|(_, row)| row[0] * velocity[0] + row[1] * velocity[1] + row[2] * velocity[2]).sum()
    }

    /// Adds a multiple of the row to a generalised impulse.
    pub fn add_to(&self, impulse: &mut [Twist], size: f64) {
        for (body, row) in std::iter::once(&self.on).chain(&self.against) {
            for axis in 0..3 {
                impulse[*body][axis] += size * row[axis];
            }
        }
    }
}

/// One place of possible contact at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// Index among the stops and contacts of the plan.
    pub index: usize,
    pub law: NormalLaw,
    pub friction: Option<FrictionLaw>,
    /// Distance, negative in penetration.
    pub gap: f64,
    /// Size of the last digits of the gap: the rounding of the positions it is the difference of.
    pub rounding: f64,
    pub normal: [f64; 2],
    /// How fast the normal turns, in rad/s: by what it turned in the last step.
    pub turning: f64,
    pub point: [f64; 2],
    pub normal_row: Row,
    /// Slip of the body's surface over the other one; nothing for a stop.
    pub slip_row: Row,
    /// Of a motor that slows down with its rate.
    pub drive: Option<Drive>,
    /// Rate and acceleration of the gap that no body makes: of a hold or motor, whose force changes over a step.
    pub course: [f64; 2],
    /// Whether the scene's laws answer here: not where rapier does, nor where the pair is out of reach.
    pub governed: bool,
    /// Whether friction answers slip against its row only.
    pub one_way: bool,
    /// What to ask again for the gap at other places.
    pub source: Source,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    Stop(usize),
    Contact(usize),
    /// A brake: friction alone, under a force that is given.
    Hold(usize),
    /// A motor that slows down with its rate: a torque along its slip row.
    Motor(usize),
}

/// A motor whose torque falls with its rate: `sign` at standstill, in its torque there, and what a rate of 1 takes from it.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    pub sign: f64,
    pub slowing: f64,
}

/// A gap below this part of the transition is rounding: surfaces that a step has brought to touch.
pub const ROUNDING: f64 = 1e-9;
/// Rates below this are rounding, m/s (stop: rad/s): the analytic model reads the start of a run by the same.
pub const RESTING: f64 = 1e-12;

impl Touch {
    /// Friction coefficient at a slip, and its slope; 0 without friction.
    #[inline(always)]
    pub fn coefficient(&self, slip: f64) -> (f64, f64) {
        match &self.friction {
            Some(law) if !self.one_way || slip < 0.0 => friction_coefficient(law, slip),
            _ => (0.0, 0.0),
        }
    }

    /// What an implicit step makes of its friction: the force along the slip row at this rate, and its derivatives by rate and normal force,
    /// as [`Stepped`] has those of what pulls against it; a law without memory leaves that as it is.
    #[inline(always)]
    pub fn friction_after(&self, [slip, memory, normal]: [f64; 3], h: f64) -> Stepped {
        if let Some(Drive { sign, slowing }) = self.drive {
            let part = slowing * slip - sign;
            return Stepped { pull: normal * part, by_slip: normal * slowing, by_normal: part, memory };
        }
        if let Some((law, bristle)) = self.friction.as_ref().and_then(|law| Some((law, law.bristle.as_ref()?))) {
            return stepped(law, bristle, [slip, memory, normal], h, self.one_way);
        }
        let (mu, slope) = self.coefficient(slip);
        Stepped { pull: mu * normal, by_slip: slope * normal, by_normal: mu, memory }
    }

    /// The bristle of its friction.
    pub fn bristle(&self) -> Option<&Bristle> {
        self.friction.as_ref().and_then(|law| law.bristle.as_ref())
    }

    /// Whether there is a force along its slip row.
    pub fn has_tangent(&self) -> bool {
        self.friction.is_some() || self.drive.is_some()
    }

    /// Whether it is one of surfaces or of a stop, which have a gap.
    pub fn has_gap(&self) -> bool {
        !matches!(self.source, Source::Hold(_) | Source::Motor(_))
    }

    /// Whether there is a gap beyond rounding.
    pub fn is_apart(&self) -> bool {
        self.gap > ROUNDING * self.law.transition_m
    }

    /// Whether the gap is one of surfaces, whose normals turn as bodies move; that of a stop is an angle.
    pub fn is_between_surfaces(&self) -> bool {
        matches!(self.source, Source::Contact(_))
    }
}

/// Every stop, every contact, and every hold.
pub fn measure(world: &World, plan: &Plan, linkage: &Linkage, touches: &mut Vec<Touch>) {
    touches.clear();
    for (index, stop) in plan.stops.iter().enumerate() {
        touches.push(Touch {
            index,
            law: stop.law,
            friction: None,
            gap: stop_gap(plan, index, &linkage.places),
            rounding: f64::EPSILON * TAU,
            normal: [0.0; 2],
            turning: 0.0,
            point: [0.0; 2],
            normal_row: Row { on: (stop.on, [0.0, 0.0, 1.0]), against: Some((stop.against, [0.0, 0.0, -1.0])) },
            slip_row: Row { on: (stop.on, [0.0; 3]), against: None },
            drive: None,
            course: [0.0; 2],
            governed: true,
            one_way: false,
            source: Source::Stop(index),
        });
    }
    for (index, contact) in plan.contacts.iter().enumerate() {
        let [own, other] = world.contacts[index];
        let in_reach = || world.physics.narrow_phase.contact_pair(own, other).is_some();
        let Some(found) = surfaces(world, plan, index, &linkage.places) else { continue };
        let Surfaces { gap, normal, .. } = found;
        let point = if contact.meet == Meet::Other { found.other_point } else { found.point };
        let row = |direction: [f64; 2]| row(plan, index, &linkage.places, &found, direction);
        touches.push(Touch {
            index: plan.stops.len() + index,
            law: contact.law.normal,
            friction: contact.law.friction,
            gap,
            rounding: rounding(plan, contact, &linkage.places),
            normal,
            turning: 0.0,
            point,
            normal_row: row(normal),
            slip_row: row(perp(normal)),
            drive: None,
            course: [0.0; 2],
            governed: world.response == Response::Laws && in_reach(),
            one_way: false,
            source: Source::Contact(index),
        });
    }
    touches.extend((0..plan.holds.len()).map(|index| hold(plan, index)));
    let slowed =
        |(index, motor): (usize, &PlannedMotor)| motor.no_load_speed_rad_s.map(|speed| drive(plan, index, speed));
    touches.extend(plan.motors.iter().enumerate().filter_map(slowed));
}

/// A brake as a contact: its friction is all or nothing, under a force that [`grip`] sets.
fn hold(plan: &Plan, index: usize) -> Touch {
    let PlannedHold { on, against, brake } = plan.holds[index];
    let width = brake.v_static_rad_s;
    Touch {
        friction: Some(FrictionLaw {
            mu_static: 1.0,
            mu_dynamic: 1.0,
            v_static_m_s: width,
            v_dynamic_m_s: 2.0 * width,
            bristle: brake.bristle,
        }),
        one_way: brake.one_way,
        ..on_shaft(plan.first_hold() + index, Source::Hold(index), on, against)
    }
}

/// A motor that slows down with its rate; [`grip`] sets its torque.
fn drive(plan: &Plan, index: usize, no_load_speed_rad_s: f64) -> Touch {
    let on = &plan.motors[index].on;
    Touch {
        drive: Some(Drive { sign: 1.0, slowing: no_load_speed_rad_s.recip() }),
        ..on_shaft(plan.first_motor() + index, Source::Motor(index), on[0], on.get(1).copied())
    }
}

/// What acts along a shaft that turns by the sum of parts of two bodies' angles: its depth, which no body changes, makes a force of
/// a stiffness.
fn on_shaft(index: usize, source: Source, on: (usize, f64), against: Option<(usize, f64)>) -> Touch {
    let turning = |(body, part): (usize, f64)| (body, [0.0, 0.0, part]);
    Touch {
        index,
        law: NormalLaw::pressed_with(0.0),
        friction: None,
        gap: -1.0,
        rounding: f64::EPSILON,
        normal: [0.0; 2],
        turning: 0.0,
        point: [0.0; 2],
        normal_row: Row { on: (on.0, [0.0; 3]), against: None },
        slip_row: Row { on: turning(on), against: against.map(turning) },
        drive: None,
        course: [0.0; 2],
        governed: false,
        one_way: false,
        source,
    }
}

/// Lets brakes grip, and motors pull, as they do over the step of `dt` from time `t`: their force follows a parabola through its
/// values at start, middle and end.
pub fn grip(plan: &Plan, t: f64, dt: f64, touches: &mut [Touch]) {
    // Jumps at both ends belong to other steps.
    let times = [1e-9, 0.5, 1.0 - 1e-9].map(|part| t + part * dt);
    for touch in touches {
        let torques = match touch.source {
            Source::Hold(index) => {
                times.map(|t| plan.holds[index].brake.torque_n_m * plan.holds[index].brake.grip(t).0)
            }
            Source::Motor(index) => {
                let torques = times.map(|t| plan.motors[index].characteristic(t).0);
                touch.drive = touch.drive.map(|drive| Drive { sign: torques[1].signum(), ..drive });
                torques.map(f64::abs)
            }
            Source::Stop(_) | Source::Contact(_) => continue,
        };
        let most = torques.into_iter().fold(0.0, f64::max);
        touch.law = NormalLaw::pressed_with(most);
        touch.governed = most > 0.0;
        if touch.governed {
            let [start, middle, end] = torques.map(|torque| torque / most);
            let rate = (4.0 * middle - 3.0 * start - end) / dt;
            (touch.gap, touch.course) = (-start, [-rate, -4.0 * (start - 2.0 * middle + end) / (dt * dt)]);
        }
    }
}

/// Surfaces at rest that overlap by no more than rounding just touch: such a depth is no contact force.
pub fn drop_rounding(touches: &mut [Touch], velocities: &[Twist]) {
    for touch in touches.iter_mut().filter(|touch| touch.is_between_surfaces()) {
        let is_rounding = touch.gap < 0.0 && touch.gap >= -touch.rounding;
        if is_rounding && touch.normal_row.rate(velocities).abs() <= RESTING {
            touch.gap = 0.0;
        }
    }
}

/// Notes how fast normals turn, from those that `before` had so long ago.
pub fn note_turning(touches: &mut [Touch], before: &[[f64; 2]], dt: f64) {
    for (touch, before) in touches.iter_mut().zip(before) {
        let [x, y] = sub(touch.normal, *before);
        touch.turning = hypot(x, y) / dt;
    }
}

/// The gap of a touch when the bodies are elsewhere, and the row of its slip there.
pub fn elsewhere(touch: &Touch, world: &World, plan: &Plan, places: &[Place]) -> (f64, Row) {
    match touch.source {
        Source::Stop(index) => (stop_gap(plan, index, places), touch.slip_row),
        Source::Hold(_) | Source::Motor(_) => (touch.gap, touch.slip_row),
        Source::Contact(index) => {
            let found = surfaces(world, plan, index, places);
            found.map_or((touch.gap, touch.slip_row), |found| {
                (found.gap, row(plan, index, places, &found, perp(found.normal)))
            })
        }
    }
}

/// The row of a direction at a contact: each surface by the point of it where forces meet.
fn row(plan: &Plan, index: usize, places: &[Place], at: &Surfaces, direction: [f64; 2]) -> Row {
    let side = |body: usize, point: [f64; 2], direction: [f64; 2]| {
        let arm = sub(point, places[body].com);
        (body, [direction[0], direction[1], cross(arm, direction)])
    };
    let contact = &plan.contacts[index];
    let (own, other) = match contact.meet {
        Meet::Each => (at.point, at.other_point),
        Meet::Body => (at.point, at.point),
        Meet::Other => (at.other_point, at.other_point),
    };
    Row {
        on: side(contact.body, own, direction),
        against: match contact.against {
            Against::Body(body) => Some(side(body, other, [-direction[0], -direction[1]])),
            Against::Fixed(_) => None,
        },
    }
}

fn stop_gap(plan: &Plan, index: usize, places: &[Place]) -> f64 {
    let stop = &plan.stops[index];
    places[stop.on].angle - places[stop.against].angle - stop.least_rad
}

/// Size of the last digits of a gap between two surfaces.
fn rounding(plan: &Plan, contact: &PlannedContact, places: &[Place]) -> f64 {
    let size = |[x, y]: [f64; 2]| x.abs().max(y.abs());
    let other = match contact.against {
        Against::Body(body) => places[body].com,
        Against::Fixed(index) => plan.fixed[index].origin_m,
    };
    f64::EPSILON * (size(places[contact.body].com) + size(other))
}

/// The surfaces of a contact with all bodies at given places, from parry where it knows them exactly.
fn surfaces(world: &World, plan: &Plan, index: usize, places: &[Place]) -> Option<Surfaces> {
    let contact = &plan.contacts[index];
    if let Some(found) = surfaces::of_shapes(plan, contact, places) {
        return Some(found);
    }
    let [own, other] = world.contacts[index].map(|handle| &world.physics.colliders[handle]);
    let pose = pose(plan, contact.body, places);
    let other_pose = match contact.against {
        Against::Body(body) => self::pose(plan, body, places),
        Against::Fixed(_) => *other.position(),
    };
    let found = query::contact(&other_pose, other.shape(), &pose, own.shape(), Real::MAX).ok()??;
    let (point, other_point, normal) = (found.point2, found.point1, found.normal1);
    Some(Surfaces {
        gap: found.dist,
        point: [point.x, point.y],
        other_point: [other_point.x, other_point.y],
        normal: [normal.x, normal.y],
    })
}

/// Pose of a body's frame when its centre of mass is at a place.
fn pose(plan: &Plan, body: usize, places: &[Place]) -> Pose {
    let place = &places[body];
    let origin = sub(place.com, rotate(plan.bodies[body].body.com_m, place.direction));
    let rotation = Rotation { re: place.direction[0], im: place.direction[1] };
    Pose::from_parts(Vector::new(origin[0], origin[1]), rotation)
}
