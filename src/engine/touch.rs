//! Where surfaces and stops are to each other: gaps, normals and the rows that give their rates from body velocities.

use parry2d_f64::query;
use rapier2d_f64::prelude::*;

use super::linkage::{Linkage, Place, Twist};
use super::plan::Plan;
use super::world::World;
use crate::gripper::Site;
use crate::law::{FrictionLaw, NormalLaw};
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
    pub site: Site,
    pub law: NormalLaw,
    pub friction: Option<FrictionLaw>,
    /// Distance, negative in penetration.
    pub gap: f64,
    pub normal: [f64; 2],
    pub point: [f64; 2],
    pub normal_row: Row,
    /// Slip of the phalanx over the object; nothing for a stop.
    pub slip_row: Row,
    /// Whether the scene's laws answer here: not where rapier does, nor where the pair is out of reach.
    pub governed: bool,
    /// What to ask again for the gap at other places.
    source: Source,
}

#[derive(Clone, Copy, Debug)]
enum Source {
    Stop(usize),
    Contact(usize),
}

/// Every stop, and every phalanx against the object.
pub fn measure(world: &World, plan: &Plan, linkage: &Linkage, touches: &mut Vec<Touch>) {
    touches.clear();
    for (index, stop) in plan.stops.iter().enumerate() {
        touches.push(Touch {
            site: stop.site,
            law: stop.law,
            friction: None,
            gap: stop_gap(plan, index, &linkage.places),
            normal: [0.0; 2],
            point: [0.0; 2],
            normal_row: Row { on: (stop.on, [0.0, 0.0, 1.0]), against: Some((stop.against, [0.0, 0.0, -1.0])) },
            slip_row: Row { on: (stop.on, [0.0; 3]), against: None },
            governed: true,
            source: Source::Stop(index),
        });
    }
    let Some(object) = world.object else { return };
    for (index, contact) in plan.contacts.iter().enumerate() {
        let in_reach = || world.physics.narrow_phase.contact_pair(world.phalanges[index], object).is_some();
        let place = &linkage.places[contact.body];
        let Some((gap, point, normal)) = surface(world, plan, index, place) else { continue };
        let row = |direction: [f64; 2]| row(contact.body, place, point, direction);
        touches.push(Touch {
            site: contact.site,
            law: contact.law.normal,
            friction: contact.law.friction,
            gap,
            normal,
            point,
            normal_row: row(normal),
            slip_row: row(perp(normal)),
            governed: world.response == Response::Laws && in_reach(),
            source: Source::Contact(index),
        });
    }
}

/// The gap of a touch when the bodies are elsewhere, and the row of its slip there.
pub fn elsewhere(touch: &Touch, world: &World, plan: &Plan, places: &[Place]) -> (f64, Row) {
    match touch.source {
        Source::Stop(index) => (stop_gap(plan, index, places), touch.slip_row),
        Source::Contact(index) => {
            let body = plan.contacts[index].body;
            let found = surface(world, plan, index, &places[body]);
            found.map_or((touch.gap, touch.slip_row), |(gap, point, normal)| {
                (gap, row(body, &places[body], point, perp(normal)))
            })
        }
    }
}

/// The row of a direction at a point of a body.
fn row(body: usize, place: &Place, point: [f64; 2], direction: [f64; 2]) -> Row {
    Row { on: (body, [direction[0], direction[1], cross(sub(point, place.com), direction)]), against: None }
}

fn stop_gap(plan: &Plan, index: usize, places: &[Place]) -> f64 {
    let stop = &plan.stops[index];
    places[stop.on].angle - places[stop.against].angle - stop.least_rad
}

/// Gap, point on the phalanx and normal (object → phalanx) of a phalanx at a place, from parry.
fn surface(world: &World, plan: &Plan, index: usize, place: &Place) -> Option<(f64, [f64; 2], [f64; 2])> {
    let colliders = &world.physics.colliders;
    let (phalanx, object) = (&colliders[world.phalanges[index]], &colliders[world.object?]);
    let com = plan.bodies[plan.contacts[index].body].body.com_m;
    let origin = sub(place.com, rotate(com, place.direction));
    let rotation = Rotation { re: place.direction[0], im: place.direction[1] };
    let pose = Pose::from_parts(Vector::new(origin[0], origin[1]), rotation);
    let contact = query::contact(object.position(), object.shape(), &pose, phalanx.shape(), Real::MAX).ok()??;
    let point = contact.point2;
    Some((contact.dist, [point.x, point.y], [contact.normal1.x, contact.normal1.y]))
}
