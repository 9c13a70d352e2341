//! Derivatives of the inertial loads in the frame of a moving palm.

use super::dynamics::{Chunk, Sums};
use super::motion::{BodyMotion, Lanes, Motions};
use super::palm_frame::{Inertia, power};
use crate::analytic::inertial_field::InertialField;
use crate::fivebar::dynamics::AccelerationField;
use crate::numeric::plane::Vector;
use crate::numeric::{Dual, Real};

impl Sums<'_> {
    /// Adds the derivatives of the inertial load on a free body, whose first coordinates are x, y and θ, and of its power.
    pub fn add_free_inertia(
        &mut self,
        (first, inertia, work): (usize, Inertia, usize),
        field: &InertialField,
        motion: &BodyMotion<f64>,
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

    /// Adds the derivatives of the inertial load on a body of a group by these coordinates, and of its power.
    pub fn add_group_inertia(
        &mut self,
        (chunk, inertia, work): (Chunk, Inertia, usize),
        field: &InertialField,
        (motions, body): (&Motions<Lanes>, usize),
    ) {
        let (center, spin) = (&motions.centers[body], motions.bodies[body].rate[2]);
        let load = inertia.load(&field.field, center.position, center.rate);
        let values = |vector: Vector<Lanes>| vector.map(|part| part.value);
        let load_rate = inertia.load(&field.rate, values(center.position), values(center.rate));
        let support = &motions.body_supports[body].coordinates[..];
        let entry = |axis: usize, k: usize| match axis {
            2 => motions.column(body, k)[2],
            _ => motions.center_column(body, k)[axis],
        };
        let rows = [0, 1, 2].map(|axis| chunk.each(|_, j| entry(axis, j).value));
        // Derivatives by the velocity: of x by ẏ, and of y by ẋ.
        let across = 2.0 * inertia.mass * field.field.coriolis;
        let by_velocity = [(across, 1), (-across, 0), (0.0, 2)];
        for (axis, (load, (factor, by))) in load.into_iter().zip(by_velocity).enumerate() {
            self.add_block(chunk, (support, |i| entry(axis, i)), load, rows[by].map(|value| factor * value));
        }
        for (row, load_rate) in rows.iter().zip(load_rate) {
            let loads = self.load_t[chunk.group + chunk.start..].iter_mut().zip(row).take(chunk.count);
            loads.for_each(|(load, value)| *load += value * load_rate);
        }
        let without_velocity = inertia.load(&field.field, center.position, [Dual::zero(); 2]);
        let by_v = chunk.each(|lane, _| (0..3).map(|k| without_velocity[k].value * rows[k][lane]).sum());
        self.add_power(work, chunk, power(without_velocity, center.rate, spin), by_v);
        if chunk.start == 0 {
            self.g_t[work] += power(load_rate, values(center.rate), spin.value);
        }
    }
}
