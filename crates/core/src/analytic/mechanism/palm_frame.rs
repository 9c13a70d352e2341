//! The frame of a moving palm: the palm is at rest in it, the world moves, and inertial forces act on all bodies.
//!
//! Stiff contacts with the palm rest in this frame. In the frame of the world they chase a moving surface, which takes twice
//! the steps.

use super::dynamics::Sums;
use super::motion::{BodyMotion, Motions, PointMotion};
use crate::analytic::inertial_field::InertialField;
use crate::fivebar::dynamics::AccelerationField;
use crate::mechanism::{Mechanism, SpringKind};
use crate::numeric::plane::{Vector, dot};
use crate::numeric::{Dual, Real};

/// The moving palm, if the equations are written in its frame: no other body has a prescribed motion, and no body keeps its
/// angle in the world.
pub(super) fn palm_of_frame(mechanism: &Mechanism) -> Option<usize> {
    let (palm, _) = mechanism.palm()?;
    let mut others = mechanism.bodies.iter().enumerate().filter(|(body, _)| *body != palm);
    others.all(|(_, body)| body.motion.is_none() && body.rotates()).then_some(palm)
}

/// Exchanges the palm and the ground: what is fixed to one of them is then fixed to the other.
pub(super) fn exchange_ground(mechanism: &mut Mechanism, palm: usize) {
    std::mem::swap(&mut mechanism.ground_outlines, &mut mechanism.bodies[palm].outlines);
    let joints = mechanism.joints.iter_mut().flat_map(|joint| &mut joint.bodies);
    let springs = mechanism.springs.iter_mut().filter_map(|spring| match &mut spring.kind {
        SpringKind::Linear { bodies, .. } => Some(bodies),
        SpringKind::Torsional { .. } => None,
    });
    let elements = mechanism.tendons.iter_mut().flat_map(|tendon| &mut tendon.path).map(|element| &mut element.body);
    let pairs = mechanism.contacts.iter_mut().flat_map(|pair| [&mut pair.points.body, &mut pair.face.body]);
    for body in joints.chain(springs.flatten()).chain(elements).chain(pairs) {
        *body = match *body {
            None => Some(palm),
            Some(body) if body == palm => None,
            other => other,
        };
    }
}

/// Acceleration of a field at a point with this velocity, with the forces that depend on the velocity.
#[inline(always)]
pub(super) fn acceleration_at<T: Real>(field: &AccelerationField, [x, y]: Vector<T>, [vx, vy]: Vector<T>) -> Vector<T> {
    let AccelerationField { uniform, centrifugal, coriolis, euler } = *field;
    [
        x * centrifugal + y * euler + vy * (2.0 * coriolis) + uniform[0],
        y * centrifugal - x * euler - vx * (2.0 * coriolis) + uniform[1],
    ]
}

/// Mass and moment of inertia of a body.
#[derive(Clone, Copy)]
pub(super) struct Inertia {
    pub mass: f64,
    pub moment: f64,
}

impl Inertia {
    /// Force and moment of a field on a body in this motion.
    pub fn load<T: Real>(&self, field: &AccelerationField, position: Vector<T>, rate: Vector<T>) -> [T; 3] {
        let [x, y] = acceleration_at(field, position, rate);
        [x * self.mass, y * self.mass, T::constant(-self.moment * field.euler)]
    }
}

/// Power of a load on a body in this motion.
pub(super) fn power<T: Real>(load: [T; 3], rate: Vector<T>, spin: T) -> T {
    dot([load[0], load[1]], rate) + load[2] * spin
}

impl<const N: usize, const Z: usize> Sums<N, Z> {
    /// Adds the derivatives of the inertial load on a free body, whose first coordinates are x, y and θ, and of its power.
    pub fn add_free_inertia<const K: usize>(
        &mut self,
        (first, inertia, work): (usize, Inertia, usize),
        field: &InertialField,
        motion: &BodyMotion<f64, K>,
    ) {
        let ([x, y], [vx, vy, spin]) = (motion.origin, motion.rate);
        let load = inertia.load(&field.field, [x, y], [vx, vy]);
        let load_rate = inertia.load(&field.rate, [x, y], [vx, vy]);
        let AccelerationField { centrifugal, coriolis, euler, .. } = field.field;
        let [centrifugal, coriolis, euler] = [centrifugal, coriolis, euler].map(|part| inertia.mass * part);
        let by_position = [[centrifugal, euler], [-euler, centrifugal]];
        for (i, row) in by_position.into_iter().enumerate() {
            for (j, entry) in row.into_iter().enumerate() {
                self.load_q[first + i][first + j] += entry;
            }
        }
        self.load_v[first][first + 1] += 2.0 * coriolis;
        self.load_v[first + 1][first] -= 2.0 * coriolis;
        (0..3).for_each(|i| self.load_t[first + i] += load_rate[i]);
        // Forces that depend on the velocity have no power.
        let by_position = [centrifugal * vx - euler * vy, euler * vx + centrifugal * vy];
        (0..2).for_each(|i| self.g_q[work][first + i] += by_position[i]);
        let without_velocity = inertia.load(&field.field, [x, y], [0.0; 2]);
        (0..2).for_each(|i| self.g_v[work][first + i] += without_velocity[i]);
        self.g_v[work][first + 2] += load[2];
        self.g_t[work] += power(load_rate, [vx, vy], spin);
    }

    /// Adds the derivatives of the inertial load on a body of a group with these first coordinates and size, and of its
    /// power.
    pub fn add_group_inertia<const K: usize>(
        &mut self,
        (of_group, inertia, work): ((usize, usize), Inertia, usize),
        field: &InertialField,
        (center, turn): (&PointMotion<Dual<K>, K>, &BodyMotion<Dual<K>, K>),
    ) {
        let (first, size) = of_group;
        let load = inertia.load(&field.field, center.position, center.rate);
        let values = |vector: Vector<Dual<K>>| vector.map(|part| part.value);
        let load_rate = inertia.load(&field.rate, values(center.position), values(center.rate));
        let rows = [&center.jacobian[0], &center.jacobian[1], &turn.jacobian[2]];
        // Derivatives by the velocity: of x by ẏ, and of y by ẋ.
        let across = 2.0 * inertia.mass * field.field.coriolis;
        let by_velocity = [(across, &center.jacobian[1]), (-across, &center.jacobian[0]), (0.0, &turn.jacobian[2])];
        for ((row, load), (factor, by)) in rows.iter().zip(load).zip(by_velocity) {
            self.add_block(of_group, row, load, |j| factor * by[j].value);
        }
        for (row, load_rate) in rows.iter().zip(load_rate) {
            (0..size).for_each(|i| self.load_t[first + i] += row[i].value * load_rate);
        }
        let without_velocity = inertia.load(&field.field, center.position, [Dual::zero(); 2]);
        let spin = turn.rate[2];
        self.add_power(work, of_group, power(without_velocity, center.rate, spin), |j| {
            (0..3).map(|k| without_velocity[k].value * rows[k][j].value).sum()
        });
        self.g_t[work] += power(load_rate, values(center.rate), spin.value);
    }
}

/// The inertial loads on all bodies of a state, as [`Inertia::load`], with their positions.
pub(super) fn inertial_loads<'a, const K: usize>(
    mechanism: &'a Mechanism,
    (field, motions): (&'a AccelerationField, &'a Motions<f64, K>),
) -> impl Iterator<Item = (usize, [f64; 3])> + 'a {
    mechanism.bodies.iter().zip(&motions.centers).enumerate().map(|(index, (body, center))| {
        let inertia = Inertia { mass: body.mass_kg, moment: body.inertia_kg_m2 };
        (index, inertia.load(field, center.position, center.rate))
    })
}
