//! Derivatives of the inertial loads in the frame of a moving palm.

use super::dynamics::{Chunk, Sums};
use super::inertial_field::{AccelerationField, InertialField};
use super::motion::{BodyMotion, LANES, Lanes, Motions};
use super::palm_frame::{Inertia, power};
use crate::numeric::plane::Vector;
use crate::numeric::{Dual, Real};

impl Sums<'_> {
    /// Adds the derivatives of the inertial load on a free body and of its power. The coordinates of the body are x, y
    /// and θ, the first one at index `first`.
    pub fn add_free_inertia(
        &mut self,
        (first, inertia, work): (usize, Inertia, usize),
        field: &InertialField,
        motion: &BodyMotion<f64>,
    ) {
        let ([x, y], [vx, vy, _]) = (motion.origin, motion.rate);
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
        self.g_t[work] += power(load_rate, motion.rate);
    }

    /// Adds the derivatives of the inertial load on a body of a group: those of its power with respect to the
    /// coordinates of the chunk, and those of the load with respect to time. Returns the load and its derivatives with
    /// respect to the rates of these coordinates.
    pub fn add_group_inertia(
        &mut self,
        (chunk, inertia, work): (Chunk, Inertia, usize),
        field: &InertialField,
        (motions, body): (&Motions<Lanes>, usize),
    ) -> [(Lanes, [f64; LANES]); 3] {
        let BodyMotion { origin, rate, .. } = motions.bodies[body];
        let velocity = [rate[0], rate[1]];
        let load = inertia.load(&field.field, origin, velocity);
        let values = |vector: Vector<Lanes>| vector.map(|part| part.value);
        let load_rate = inertia.load(&field.rate, values(origin), values(velocity));
        let rows = [0, 1, 2].map(|axis| chunk.each(|_, j| motions.column(body, j)[axis].value));
        // Derivatives by the velocity: of x by ẏ, and of y by ẋ.
        let across = 2.0 * inertia.mass * field.field.coriolis;
        for (row, load_rate) in rows.iter().zip(load_rate) {
            let loads = self.load_t[chunk.group + chunk.start..].iter_mut().zip(row).take(chunk.count);
            loads.for_each(|(load, value)| *load += value * load_rate);
        }
        let without_velocity = inertia.load(&field.field, origin, [Dual::zero(); 2]);
        let by_v = chunk.each(|lane, _| (0..3).map(|k| without_velocity[k].value * rows[k][lane]).sum());
        self.add_power(work, chunk, power(without_velocity, rate), by_v);
        if chunk.start == 0 {
            self.g_t[work] += power(load_rate, rate.map(|part| part.value));
        }
        let [x, y, turn] = load;
        let by_rates = |factor: f64, row: [f64; LANES]| row.map(|value| factor * value);
        [(x, by_rates(across, rows[1])), (y, by_rates(-across, rows[0])), (turn, [0.0; LANES])]
    }
}
