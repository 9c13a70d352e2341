//! Derivatives of the inertial loads in the frame of a moving palm.

use super::dynamics::Sums;
use super::motion::{BodyMotion, PointMotion};
use super::palm_frame::{Inertia, power};
use crate::analytic::inertial_field::InertialField;
use crate::fivebar::dynamics::AccelerationField;
use crate::numeric::plane::Vector;
use crate::numeric::{Dual, Real};

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
