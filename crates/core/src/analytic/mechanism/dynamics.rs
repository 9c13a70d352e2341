//! Accelerations of a mechanism, and their derivatives.
//!
//! M a = Q − bias, with M = Σ Jᵀ M_b J over bodies and armatures, block by block for each group. The derivatives follow
//! from the residual r = M a + bias − Q at constant a, evaluated in numbers with derivatives by the coordinates of a
//! group: ∂a/∂q = −M⁻¹ ∂r/∂q. Rates enter the inertial terms quadratically, so that their derivative by the rates is
//! twice the derivative of the rates by the coordinates.

use super::actuator::{BrakeEffort, Effort, brake_effort, effort};
use super::contacts::{Contact, Surfaces};
use super::factor::Factor;
use super::free::FreeBody;
use super::group::{Element, PlacedGroup, Row};
use super::inertial_field::{AccelerationField, InertialField, inertial_field};
use super::model::{MechanismMode, MechanismModel, Span};
use super::motion::{BodyMotion, JointMotion, LANES, Lanes, Motions, pair};
use super::nearest::{Feature, Frame, POSES, PointOnFace};
use super::pairs;
use super::palm_frame::{Inertia, power};
use crate::analytic::contact::{
    ContactForces, ContactKinematics, ContactLaws, WithDerivatives, contact_forces, contact_forces_with_derivatives,
    normal_force_on_branch,
};
use crate::integrator::{Dynamic, DynamicMatrix, Linearised, Rates, System};
use crate::law::{FrictionRange, friction_coefficient, friction_force};
use crate::mechanism::{Limit, Limited};
use crate::numeric::{Dual, Real, array_from};

/// Derivatives of the loads on all coordinates, in place of those of accelerations, and of the rates of all quadratures.
pub(super) struct Sums<'a> {
    pub load_q: &'a mut DynamicMatrix<f64>,
    pub load_v: &'a mut DynamicMatrix<f64>,
    pub load_t: &'a mut [f64],
    pub g_q: &'a mut DynamicMatrix<f64>,
    pub g_v: &'a mut DynamicMatrix<f64>,
    pub g_t: &'a mut [f64],
}

/// The coordinates of a group by which numbers have derivatives.
#[derive(Clone, Copy)]
pub(super) struct Chunk {
    /// Index of the first coordinate of the group among all coordinates.
    pub group: usize,
    /// Index of the first coordinate of the chunk, among those of the group.
    pub start: usize,
    /// Number of coordinates of the chunk.
    pub count: usize,
}

impl Chunk {
    /// Divides the coordinates of a group into chunks, which are returned with their indices.
    pub fn of_group(first: usize, size: usize) -> impl Iterator<Item = (usize, Self)> {
        let chunk = move |start: usize| Self { group: first, start, count: LANES.min(size - start) };
        (0..size).step_by(LANES).map(chunk).enumerate()
    }

    /// Returns a number for each lane; `number` receives the lane and the index of its coordinate in the group.
    #[inline(always)]
    pub fn each(&self, number: impl Fn(usize, usize) -> f64) -> [f64; LANES] {
        array_from(|lane| if lane < self.count { number(lane, self.start + lane) } else { 0.0 })
    }
}

impl<'a> Sums<'a> {
    /// Returns sums that are stored in place of the derivatives of the accelerations.
    pub fn of(linearised: &'a mut Linearised<Dynamic>) -> (&'a mut Rates<Dynamic>, Self) {
        let Linearised { rates, a_q, a_v, a_t, g_q, g_v, g_t } = linearised;
        (rates, Self { load_q: a_q, load_v: a_v, load_t: a_t, g_q, g_v, g_t })
    }

    /// Adds the derivatives of the load of a force along a row of a group. The row depends on the coordinates
    /// `support`; `by_v` are the derivatives of the force with respect to the rates.
    #[inline(always)]
    pub fn add_block(
        &mut self,
        chunk: Chunk,
        (support, row): (&[usize], impl Fn(usize) -> Lanes),
        force: Lanes,
        by_v: [f64; LANES],
    ) {
        let Chunk { group, start, count } = chunk;
        for &i in support {
            let entry = row(i);
            let load_q = &mut self.load_q[group + i][group + start..][..count];
            for (lane, load) in load_q.iter_mut().enumerate() {
                *load += entry.grad[lane] * force.value + entry.value * force.grad[lane];
            }
            let load_v = &mut self.load_v[group + i][group + start..][..count];
            for (lane, load) in load_v.iter_mut().enumerate() {
                *load += entry.value * by_v[lane];
            }
        }
    }

    /// Like [`Sums::add_block`], for a force and a moment on a body; `columns` are the motion of the body per unit of
    /// the rate of each coordinate.
    #[inline(always)]
    pub fn add_body_block(
        &mut self,
        chunk: Chunk,
        (support, columns): (&[usize], &[[Lanes; 3]]),
        loads: [(Lanes, [f64; LANES]); 3],
    ) {
        let Chunk { group, start, count } = chunk;
        for &i in support {
            let (mut by_q, mut by_v) = ([0.0; LANES], [0.0; LANES]);
            for (entry, (load, load_by_v)) in columns[i].iter().zip(&loads) {
                for lane in 0..LANES {
                    by_q[lane] += entry.grad[lane] * load.value + entry.value * load.grad[lane];
                    by_v[lane] += entry.value * load_by_v[lane];
                }
            }
            let load_q = &mut self.load_q[group + i][group + start..][..count];
            load_q.iter_mut().zip(by_q).for_each(|(load, part)| *load += part);
            let load_v = &mut self.load_v[group + i][group + start..][..count];
            load_v.iter_mut().zip(by_v).for_each(|(load, part)| *load += part);
        }
    }

    /// Adds the derivatives of the power of a force on a group; `by_v` are the derivatives of the power with respect to
    /// the rates.
    #[inline(always)]
    pub fn add_power(&mut self, work: usize, Chunk { group, start, count }: Chunk, power: Lanes, by_v: [f64; LANES]) {
        let add = |row: &mut [f64], numbers: [f64; LANES]| {
            row[group + start..][..count].iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
        };
        add(&mut self.g_q[work], power.grad);
        add(&mut self.g_v[work], by_v);
    }
}

/// Loads on all coordinates, and rates of all quadratures.
type Loads<'a> = (&'a mut [f64], &'a mut [f64]);

impl MechanismModel {
    /// Index of the quadrature for the work of contacts, limits, dampers and brakes; that of actuators and prescribed
    /// motions follows.
    pub(super) fn contact_work(&self) -> usize {
        self.contacts.len()
    }

    pub(super) fn drive_work(&self) -> usize {
        self.contacts.len() + 1
    }

    /// Rate of the relative pose of two bodies.
    #[inline(always)]
    pub(super) fn pair_rates(motions: &Motions<f64>, bodies: [Option<usize>; 2]) -> [f64; POSES] {
        let [a, b] = pair(|side| &motions.body(bodies[side]).rate);
        [a[0] - b[0], a[1] - b[1], a[2], b[2]]
    }

    #[inline(always)]
    pub(super) fn frames(motions: &Motions<f64>, bodies: [Option<usize>; 2]) -> [Frame<f64>; 2] {
        pair(|side| Frame::new(motions.body(bodies[side])))
    }

    /// Frames of two bodies with their relative pose as variables.
    #[inline(always)]
    pub(super) fn variable_frames(frames: &[Frame<f64>; 2], bodies: [Option<usize>; 2]) -> [Frame<Dual<POSES>>; 2] {
        pair(|side| Frame::variable(&frames[side], side, bodies[side].is_none()))
    }

    /// Evaluates the lower triangle of the mass matrix of a group, by rows, and the loads of inertia, gravity and constant
    /// forces.
    pub(super) fn evaluate_inertia(&self, group: &PlacedGroup, motions: &Motions<f64>, (mass, load): Loads<'_>) {
        let (size, gravity) = (group.size(), self.mechanism.gravity_m_s2);
        let (mass, load) = (&mut mass[..size * size], &mut load[..size]);
        mass.copy_from_slice(&group.constant.mass);
        load.copy_from_slice(&group.constant.load);
        for &(index, inertia) in &group.inertias {
            let support = &motions.body_supports[index];
            let columns = &motions.columns[support.first..][..size];
            let [x, y, turn] = motions.bodies[index].bias;
            let of_body = [inertia.mass * (gravity[0] - x), inertia.mass * (gravity[1] - y), -inertia.moment * turn];
            let along = |[x, y, turn]: [f64; 3]| of_body[0] * x + of_body[1] * y + of_body[2] * turn;
            let product = |[x, y, turn]: [f64; 3], other: [f64; 3]| {
                inertia.mass * (x * other[0] + y * other[1]) + inertia.moment * (turn * other[2])
            };
            match support.coordinates[..] {
                // Most bodies depend on one or two coordinates.
                [i] => {
                    let column = columns[i];
                    mass[i * size + i] += product(column, column);
                    load[i] += along(column);
                }
                [i, j] => {
                    let (first, second) = (columns[i], columns[j]);
                    mass[i * size + i] += product(first, first);
                    mass[j * size + i] += product(first, second);
                    mass[j * size + j] += product(second, second);
                    load[i] += along(first);
                    load[j] += along(second);
                }
                ref coordinates => {
                    for (place, &i) in coordinates.iter().enumerate() {
                        let row = &mut mass[i * size..][..size];
                        coordinates[..=place].iter().for_each(|&j| row[j] += product(columns[i], columns[j]));
                        load[i] += along(columns[i]);
                    }
                }
            }
        }
        for element in group.varying.iter().map(|index| &group.elements[*index]).filter(|of| of.inertia != 0.0) {
            for (place, &i) in element.row.support.iter().enumerate() {
                let by_i = element.inertia * motions.row_entry(&element.on, i);
                for &j in &element.row.support[..=place] {
                    mass[i * size + j] += by_i * motions.row_entry(&element.on, j);
                }
            }
        }
    }

    /// Inertial accelerations at time `t`, in the frame of a moving palm.
    pub(super) fn inertial_field(&self, t: f64) -> Option<InertialField> {
        let (_, motion) = self.world.as_ref()?;
        Some(inertial_field(motion, self.world_gravity_m_s2, t))
    }

    /// Adds the loads of inertia in the frame of a moving palm on a free body. Their power is work of the palm.
    fn add_free_inertia(
        &self,
        free: &FreeBody,
        field: &AccelerationField,
        motions: &Motions<f64>,
        (load, g): Loads<'_>,
    ) {
        let BodyMotion { origin, rate, .. } = motions.bodies[free.body];
        let of_body = Inertia::of(&self.mechanism.bodies[free.body]).load(field, origin, [rate[0], rate[1]]);
        g[self.drive_work()] += power(of_body, rate);
        load[free.first..free.first + free.axes].iter_mut().zip(of_body).for_each(|(load, part)| *load += part);
    }

    /// Adds a load along the coordinate of a joint.
    #[inline(always)]
    pub(super) fn add_joint_load(&self, motions: &Motions<f64>, joint: usize, effort: f64, load: &mut [f64]) {
        let first = self.span_of_joint(joint).first;
        for &i in &motions.joint_supports[joint].coordinates {
            load[first + i] += motions.joint_entry(joint, i) * effort;
        }
    }

    /// Adds a load along the coordinate of a limit.
    #[inline(always)]
    pub(super) fn add_limit_load(&self, motions: &Motions<f64>, limit: &Limit, effort: f64, load: &mut [f64]) {
        match limit.of {
            Limited::Joint(joint) => self.add_joint_load(motions, joint, effort, load),
            Limited::Sum(sum) => {
                let terms = &self.mechanism.sum_limits[sum].on.terms;
                terms.iter().for_each(|(joint, factor)| self.add_joint_load(motions, *joint, factor * effort, load));
            }
        }
    }

    /// The coordinate of a limit and its rate.
    #[inline(always)]
    pub(super) fn limited(&self, motions: &Motions<f64>, limit: &Limit) -> [f64; 2] {
        match limit.of {
            Limited::Joint(joint) => [self.joint_coordinate(motions, joint), motions.joints[joint].rate],
            Limited::Sum(sum) => {
                let motion = motions.combination(&self.mechanism.sum_limits[sum].on);
                [motion.coordinate, motion.rate]
            }
        }
    }

    /// Motion of the coordinate of a limit, with derivatives.
    #[inline(always)]
    fn limit_motion(&self, motions: &Motions<Lanes>, limit: &Limit) -> JointMotion<Lanes> {
        match limit.of {
            Limited::Joint(joint) => motions.joints[joint],
            Limited::Sum(sum) => motions.combination(&self.mechanism.sum_limits[sum].on),
        }
    }

    /// Derivative of the coordinate of a limit by a coordinate of its group.
    #[inline(always)]
    fn limit_entry(&self, motions: &Motions<Lanes>, limit: &Limit, k: usize) -> Lanes {
        match limit.of {
            Limited::Joint(joint) => motions.joint_entry(joint, k),
            Limited::Sum(sum) => motions.row_entry(&self.mechanism.sum_limits[sum].on, k),
        }
    }

    /// The group of a limit, and the coordinates of the group on which its coordinate may depend.
    fn limit_support<'a>(&'a self, motions: &'a Motions<f64>, limit: &Limit) -> (Span, &'a [usize]) {
        match limit.of {
            Limited::Joint(joint) => (self.span_of_joint(joint), &motions.joint_supports[joint].coordinates),
            Limited::Sum(sum) => {
                let (joint, _) = self.mechanism.sum_limits[sum].on.terms[0];
                (self.span_of_joint(joint), &self.sum_supports[sum])
            }
        }
    }

    /// Adds all loads on the coordinates and the powers of all forces.
    fn add_loads(
        &self,
        t: f64,
        v: &[f64],
        mode: &MechanismMode,
        (motions, factors): (&Motions<f64>, &[Factor]),
        (load, g): Loads<'_>,
    ) {
        let contact_work = self.contact_work();
        let field = self.inertial_field(t).map(|field| field.field);
        for free in &self.free_bodies {
            load[free.first..free.first + 2].copy_from_slice(&free.weight);
            field.iter().for_each(|field| self.add_free_inertia(free, field, motions, (&mut *load, &mut *g)));
        }
        for (group, factor) in self.groups.iter().zip(factors) {
            load[group.first..][..group.size()].copy_from_slice(factor.load());
            field.iter().for_each(|field| self.add_group_inertia(group, field, motions, (&mut *load, &mut *g)));
            self.add_group_loads(t, (group, v), mode, motions, (&mut *load, &mut *g));
        }
        for (index, bodies, points_m) in self.linear_springs() {
            let state = pairs::spring(points_m, &Self::frames(motions, bodies));
            let rates = Self::pair_rates(motions, bodies);
            let (forces, power) = pairs::spring_loads(&self.mechanism.springs[index], &state, &rates);
            self.add_pair_loads(motions, bodies, &forces, load);
            g[contact_work] += power;
        }
        for (index, actuator) in self.mechanism.actuators.iter().enumerate().filter(|each| each.1.brake.is_some()) {
            let rate = motions.combination(&actuator.on).rate;
            let Some(brake) = self.brake_effort(t, v, index, rate) else { continue };
            brake.bristle.into_iter().for_each(|bristle| load[bristle] += brake.gain * brake.effort.value);
        }
        for &(index, kind) in &self.friction_states {
            load[index] += kind.relaxation(v[index]);
        }
        for (index, contact) in self.contacts.iter().enumerate() {
            let Some(laws) = contact.laws(mode, index) else { continue };
            match &contact.surfaces {
                Surfaces::Point(pair) => {
                    let frames = Self::frames(motions, pair.bodies);
                    let kinematics = pairs::contact(pair, &frames, pair.nearest_on(&frames, mode.features[index]));
                    let rates = Self::pair_rates(motions, pair.bodies);
                    let state = contact.state.map(|state| v[state]);
                    let mut forces = contact_forces(&kinematics, &rates, state, laws);
                    contact.add_rolling(&rates, &mut forces);
                    self.add_pair_loads(motions, pair.bodies, &forces.load, load);
                    g[index] += forces.normal;
                    g[contact_work] += forces.power;
                    contact.state.into_iter().for_each(|state| load[state] += forces.state_rate);
                }
                Surfaces::Limit(limit) => {
                    let [coordinate, rate] = self.limited(motions, limit);
                    let (depth, rate) = (limit.side * (coordinate - limit.value), limit.side * rate);
                    let force = normal_force_on_branch(&limit.law, laws.state, depth, rate).force;
                    self.add_limit_load(motions, limit, -limit.side * force, load);
                    g[index] += force;
                    g[contact_work] -= force * rate;
                }
                Surfaces::Friction(joint) => {
                    let rate = motions.joints[*joint].rate;
                    let state = contact.state.map(|state| v[state]);
                    let [effort, state_rate] = contact.joint_friction(rate, state, laws.range);
                    self.add_joint_load(motions, *joint, effort, load);
                    g[contact_work] += effort * rate;
                    contact.state.into_iter().for_each(|state| load[state] += state_rate);
                }
                Surfaces::Tendon(_) | Surfaces::Cable(..) => {}
            }
        }
    }

    /// Adds the loads of inertia on a group in the frame of a moving palm. Their power is work of the palm.
    fn add_group_inertia(
        &self,
        group: &PlacedGroup,
        field: &AccelerationField,
        motions: &Motions<f64>,
        (load, g): Loads<'_>,
    ) {
        let load = &mut load[group.first..][..group.size()];
        for &(index, inertia) in &group.inertias {
            let BodyMotion { origin, rate, .. } = motions.bodies[index];
            let of_body = inertia.load(field, origin, [rate[0], rate[1]]);
            g[self.drive_work()] += power(of_body, rate);
            motions.add_body_load(index, of_body, load);
        }
    }

    /// Adds the other loads of elements, and those of actuators and brakes on a group, and their powers.
    fn add_group_loads(
        &self,
        t: f64,
        (group, v): (&PlacedGroup, &[f64]),
        mode: &MechanismMode,
        motions: &Motions<f64>,
        (load, g): Loads<'_>,
    ) {
        let load = &mut load[group.first..][..group.size()];
        for element in group.varying.iter().map(|index| &group.elements[*index]) {
            let motion = motions.combination(&element.on);
            g[self.contact_work()] -= element.damping * motion.rate * motion.rate;
            let effort = element.effort(motion.coordinate, motion.rate) - element.inertia * motion.bias;
            element.row.add_load(motions, &element.on, effort, load);
        }
        for (index, row) in &group.actuators {
            let actuator = &self.mechanism.actuators[*index];
            let motion = motions.combination(&actuator.on);
            let range = self.range_at(t, mode, *index, motion.coordinate, motion.rate);
            let mut effort = match actuator.powertrain.is_direct() {
                true => effort(actuator, range, t, motion.coordinate, motion.rate).value,
                false => 0.0,
            };
            g[self.drive_work()] += effort * motion.rate;
            if let Some(brake) = self.brake_effort(t, v, *index, motion.rate) {
                g[self.contact_work()] += brake.effort.value * motion.rate;
                effort += brake.effort.value;
            }
            row.add_load(motions, &actuator.on, effort, load);
        }
    }

    /// Effort of the brake of an actuator, if it has one.
    pub(super) fn brake_effort(&self, t: f64, v: &[f64], actuator: usize, rate: f64) -> Option<BrakeEffort> {
        let state = self.brake_bristles[actuator].map(|index| (index, v[index]));
        brake_effort(&self.mechanism.actuators[actuator], t, rate, state)
    }

    /// Adds loads on the relative pose of two bodies, or a row over it, to those on all coordinates.
    #[inline(always)]
    pub(super) fn add_pair_loads(
        &self,
        motions: &Motions<f64>,
        bodies: [Option<usize>; 2],
        loads: &[f64; POSES],
        load: &mut [f64],
    ) {
        for (side, body) in bodies.into_iter().enumerate() {
            let Some(body) = body else { continue };
            let (Span { first, size, is_free }, of_body) = (self.spans[body], of_side(loads, side));
            let load = &mut load[first..first + size];
            if is_free {
                load.iter_mut().zip(of_body).for_each(|(load, part)| *load += part);
                continue;
            }
            motions.add_body_load(body, of_body, load);
        }
    }

    /// Solves the mass matrices of all bodies for one vector of loads, in place. Returns the power that the prescribed
    /// motions require: time is their coordinate, and its rate is 1.
    pub(super) fn solve(&self, factors: &[Factor], x: &mut [f64]) -> f64 {
        for free in &self.free_bodies {
            x[free.first..free.first + free.axes]
                .iter_mut()
                .zip(free.mobility)
                .for_each(|(x, mobility)| *x *= mobility);
        }
        let mut power = 0.0;
        for (index, (group, factor)) in self.groups.iter().zip(factors).enumerate() {
            let x = &mut x[group.first..group.first + group.size()];
            match self.prescribed == Some(index) {
                true => power = factor.solve_prescribed(x),
                false => factor.solve(x),
            }
        }
        power
    }

    /// [`MechanismModel::solve`] for the first `count` columns of a matrix, in place; adds the powers to `powers`.
    fn solve_columns(&self, factors: &[Factor], matrix: &mut DynamicMatrix<f64>, powers: &mut [f64], count: usize) {
        for free in &self.free_bodies {
            for (axis, mobility) in free.mobility.into_iter().enumerate().take(free.axes) {
                matrix[free.first + axis][..count].iter_mut().for_each(|entry| *entry *= mobility);
            }
        }
        for (group, factor) in self.groups.iter().zip(factors) {
            factor.solve_columns((matrix, group.first), count, powers);
        }
    }

    /// Adds the derivatives of the loads on a group that depend on the group alone.
    fn add_group_derivatives(
        &self,
        t: f64,
        (group, v, a): (&PlacedGroup, &[f64], &[f64]),
        (mode, field): (&MechanismMode, Option<&InertialField>),
        (chunk, motions): (Chunk, &Motions<Lanes>),
        sums: &mut Sums<'_>,
    ) {
        let a = &a[group.first..][..group.size()];
        let lanes = chunk.start..chunk.start + LANES;
        for &(index, inertia) in &group.inertias {
            let (motion, support) = (&motions.bodies[index], &motions.body_supports[index]);
            if !support.meets(&lanes) {
                continue;
            }
            let columns = &motions.columns[support.first..][..group.size()];
            let support = &support.coordinates[..];
            let of_field =
                field.map(|field| sums.add_group_inertia((chunk, inertia, self.drive_work()), field, (motions, index)));
            let [x, y] = self.mechanism.gravity_m_s2;
            let by_axis = [(inertia.mass, x), (inertia.mass, y), (inertia.moment, 0.0)];
            let load = |axis: usize| {
                let (inertia, gravity) = by_axis[axis];
                let total = support.iter().fold(motion.bias[axis], |sum, k| sum + columns[*k][axis] * a[*k]) - gravity;
                let (mut load, mut by_v) = (total * -inertia, motion.rate[axis].grad.map(|grad| -2.0 * inertia * grad));
                if let Some(of_field) = &of_field {
                    load += of_field[axis].0;
                    by_v.iter_mut().zip(of_field[axis].1).for_each(|(sum, part)| *sum += part);
                }
                (load, by_v)
            };
            sums.add_body_block(chunk, (support, columns), [load(0), load(1), load(2)]);
        }
        for element in group.varying.iter().map(|index| &group.elements[*index]) {
            let Element { stiffness, damping, inertia, ref on, row: Row { ref support, .. }, .. } = *element;
            let motion = motions.combination(on);
            let effort = element.effort(motion.coordinate.value, motion.rate.value);
            let acceleration = support.iter().fold(motion.bias, |sum, k| sum + motions.row_entry(on, *k) * a[*k]);
            let force = motion.coordinate.chain2(motion.rate, effort, -stiffness, -damping) - acceleration * inertia;
            let values = chunk.each(|_, j| motions.row_entry(on, j).value);
            let by_v = chunk.each(|lane, _| -damping * values[lane] - 2.0 * inertia * motion.rate.grad[lane]);
            sums.add_block(chunk, (support, |i| motions.row_entry(on, i)), force, by_v);
            let power = -(motion.rate * motion.rate * damping);
            let power_by_rate = -2.0 * damping * motion.rate.value;
            sums.add_power(self.contact_work(), chunk, power, values.map(|value| power_by_rate * value));
        }
        for (index, Row { support, .. }) in &group.actuators {
            let actuator = &self.mechanism.actuators[*index];
            let (on, motion) = (&actuator.on, motions.combination(&actuator.on));
            let values = chunk.each(|_, j| motions.row_entry(on, j).value);
            let rate = motion.rate.value;
            let range = self.range_at(t, mode, *index, motion.coordinate.value, rate);
            let effort = match actuator.powertrain.is_direct() {
                true => effort(actuator, range, t, motion.coordinate.value, rate),
                false => Effort::default(),
            };
            let brake = self.brake_effort(t, v, *index, rate);
            let brake_effort = brake.map_or(Effort::default(), |brake| brake.effort);
            for (work, effort) in [(self.drive_work(), effort), (self.contact_work(), brake_effort)] {
                let force = motion.coordinate.chain2(motion.rate, effort.value, effort.by_coordinate, effort.by_rate);
                let by_v = values.map(|value| effort.by_rate * value);
                sums.add_block(chunk, (support, |i| motions.row_entry(on, i)), force, by_v);
                let power_by_rate = effort.by_rate * rate + effort.value;
                sums.add_power(work, chunk, force * motion.rate, values.map(|value| power_by_rate * value));
                for (load, value) in sums.load_t[group.first + chunk.start..].iter_mut().zip(values).take(chunk.count) {
                    *load += value * effort.by_time;
                }
                if chunk.start == 0 {
                    sums.g_t[work] += effort.by_time * rate;
                }
            }
            if let Some(BrakeEffort { effort, bristle: Some(bristle), by_bristle, gain }) = brake {
                for (lane, value) in values.into_iter().enumerate().take(chunk.count) {
                    let i = group.first + chunk.start + lane;
                    sums.load_v[i][bristle] += value * by_bristle;
                    sums.load_q[bristle][i] += gain * effort.by_rate * motion.rate.grad[lane];
                    sums.load_v[bristle][i] += gain * effort.by_rate * value;
                }
                if chunk.start == 0 {
                    sums.load_v[bristle][bristle] += gain * by_bristle;
                    sums.load_t[bristle] += gain * effort.by_time;
                    sums.g_v[self.contact_work()][bristle] += by_bristle * rate;
                }
            }
        }
    }

    /// Adds the derivatives of forces between two bodies: loads on their relative pose, and numbers added to quadratures or
    /// to the rates of internal states of friction.
    pub(super) fn add_pair_derivatives(
        &self,
        (plain, motions): (&Motions<f64>, &[Motions<Lanes>]),
        bodies: [Option<usize>; 2],
        loads: &[WithDerivatives<POSES, POSES>; POSES],
        quadratures: &[(usize, WithDerivatives<POSES, POSES>)],
        state: Option<(usize, WithDerivatives<POSES, POSES>)>,
        sums: &mut Sums<'_>,
    ) {
        // Adds the derivatives of a number to rows over all coordinates and their rates.
        let add = |number: &WithDerivatives<POSES, POSES>, by_q: &mut [f64], by_v: &mut [f64]| {
            for (side, body) in bodies.into_iter().enumerate() {
                let Some(body) = body else { continue };
                let Span { first, size, is_free } = self.spans[body];
                let (by_pose, by_rate) = (of_side(&number.by_q, side), of_side(&number.by_v, side));
                let (by_q, by_v) = (&mut by_q[first..first + size], &mut by_v[first..first + size]);
                if is_free {
                    by_q.iter_mut().zip(by_pose).for_each(|(entry, part)| *entry += part);
                    by_v.iter_mut().zip(by_rate).for_each(|(entry, part)| *entry += part);
                    continue;
                }
                for &j in &plain.body_supports[body].coordinates {
                    let (column, rate) = (plain.column(body, j), &motions[j / LANES].bodies[body].rate);
                    for axis in 0..3 {
                        by_q[j] += by_pose[axis] * column[axis] + by_rate[axis] * rate[axis].grad[j % LANES];
                        by_v[j] += by_rate[axis] * column[axis];
                    }
                }
            }
            if let Some((index, _)) = state {
                by_v[index] += number.by_state;
            }
        };
        for (side, body) in bodies.into_iter().enumerate() {
            let Some(body) = body else { continue };
            let Span { first, size, is_free } = self.spans[body];
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let of_body = [(&loads[0], sign), (&loads[1], sign), (&loads[2 + side], 1.0)];
            // The load on a coordinate is a sum of those on the pose.
            let add_part =
                |sum: &mut WithDerivatives<POSES, POSES>, load: &WithDerivatives<POSES, POSES>, factor: f64| {
                    for k in 0..POSES {
                        sum.by_q[k] += factor * load.by_q[k];
                        sum.by_v[k] += factor * load.by_v[k];
                    }
                    sum.by_state += factor * load.by_state;
                };
            if is_free {
                for (i, (load, sign)) in of_body.into_iter().enumerate().take(size) {
                    let mut on_coordinate = WithDerivatives::default();
                    add_part(&mut on_coordinate, load, sign);
                    add(&on_coordinate, &mut sums.load_q[first + i], &mut sums.load_v[first + i]);
                }
                continue;
            }
            let support = &plain.body_supports[body].coordinates;
            for &i in support {
                let (mut on_coordinate, column) = (WithDerivatives::default(), plain.column(body, i));
                for (axis, (load, sign)) in of_body.into_iter().enumerate() {
                    add_part(&mut on_coordinate, load, sign * column[axis]);
                    let value = sign * load.value;
                    for &j in support {
                        let entry = motions[j / LANES].column(body, i)[axis].grad[j % LANES];
                        sums.load_q[first + i][first + j] += entry * value;
                    }
                }
                add(&on_coordinate, &mut sums.load_q[first + i], &mut sums.load_v[first + i]);
            }
        }
        for (index, number) in quadratures {
            add(number, &mut sums.g_q[*index], &mut sums.g_v[*index]);
        }
        if let Some((index, number)) = state {
            add(&number, &mut sums.load_q[index], &mut sums.load_v[index]);
        }
    }

    /// Adds the derivatives of contacts, limits and linear springs.
    fn add_all_pair_derivatives(
        &self,
        v: &[f64],
        mode: &MechanismMode,
        (plain, motions): (&Motions<f64>, &[Motions<Lanes>]),
        sums: &mut Sums<'_>,
    ) {
        let contact_work = self.contact_work();
        for (index, bodies, points_m) in self.linear_springs() {
            let frames = Self::variable_frames(&Self::frames(plain, bodies), bodies);
            let (spring, state) = (&self.mechanism.springs[index], pairs::spring(points_m, &frames));
            let rates = Self::pair_rates(plain, bodies);
            let (loads, power) = pairs::spring_loads_with_derivatives(spring, &state, &rates);
            self.add_pair_derivatives((plain, motions), bodies, &loads, &[(contact_work, power)], None, sums);
        }
        for (index, contact) in self.contacts.iter().enumerate() {
            let Some(laws) = contact.laws(mode, index) else { continue };
            match &contact.surfaces {
                Surfaces::Point(pair) => {
                    let frames = Self::frames(plain, pair.bodies);
                    let feature = mode.features[index].unwrap_or_else(|| pair.nearest(&frames).0);
                    let frames = Self::variable_frames(&frames, pair.bodies);
                    let kinematics = pairs::contact(pair, &frames, pair.on_feature(&frames, feature));
                    let state = contact.state.map(|state| v[state]);
                    let rates = Self::pair_rates(plain, pair.bodies);
                    let mut forces = contact_forces_with_derivatives(&kinematics, &rates, state, laws);
                    contact.add_rolling_with_derivatives(&rates, &mut forces);
                    let quadratures = [(index, forces.normal), (contact_work, forces.power)];
                    let state = contact.state.map(|state| (state, forces.state_rate));
                    self.add_pair_derivatives((plain, motions), pair.bodies, &forces.load, &quadratures, state, sums);
                }
                Surfaces::Limit(limit) => {
                    let ([coordinate, _], side) = (self.limited(plain, limit), limit.side);
                    let (span, support) = self.limit_support(plain, limit);
                    for (at, chunk) in Chunk::of_group(span.first, span.size) {
                        let (motions, row) = (&motions[at], |i| self.limit_entry(&motions[at], limit, i));
                        let motion = self.limit_motion(motions, limit);
                        let depth = (motion.coordinate.chain(coordinate, 1.0) - limit.value) * side;
                        let rate = motion.rate * side;
                        let law = normal_force_on_branch(&limit.law, laws.state, depth.value, rate.value);
                        let force = depth.chain2(rate, law.force, law.d_delta, law.d_rate);
                        let (load, power) = (force * -side, -(force * rate));
                        let values = chunk.each(|_, j| row(j).value);
                        sums.add_block(chunk, (support, row), load, values.map(|value| -law.d_rate * value));
                        sums.add_power(index, chunk, force, values.map(|value| law.d_rate * side * value));
                        let power_by_rate = -side * (law.d_rate * rate.value + force.value);
                        sums.add_power(contact_work, chunk, power, values.map(|value| power_by_rate * value));
                    }
                }
                Surfaces::Friction(joint) => {
                    let Span { first, size, .. } = self.span_of_joint(*joint);
                    let rate = plain.joints[*joint].rate;
                    let state = contact.state.map(|state| Dual::<2>::variable(v[state], 1));
                    let [effort, state_rate] = contact.joint_friction(Dual::variable(rate, 0), state, laws.range);
                    let Dual { value, grad: [by_rate, by_state] } = effort;
                    let support = &plain.joint_supports[*joint].coordinates[..];
                    for (at, chunk) in Chunk::of_group(first, size) {
                        let row = |i| motions[at].joint_entry(*joint, i);
                        let rate_q = motions[at].joints[*joint].rate;
                        let values = chunk.each(|_, j| row(j).value);
                        let by_v = values.map(|value| by_rate * value);
                        sums.add_block(chunk, (support, row), rate_q.chain(value, by_rate), by_v);
                        for (lane, row) in values.into_iter().enumerate().take(chunk.count) {
                            let (i, rate_q) = (first + chunk.start + lane, rate_q.grad[lane]);
                            sums.g_q[contact_work][i] += (by_rate * rate + value) * rate_q;
                            sums.g_v[contact_work][i] += (by_rate * rate + value) * row;
                            if let Some(state) = contact.state {
                                sums.load_v[i][state] += row * by_state;
                                sums.load_q[state][i] += state_rate.grad[0] * rate_q;
                                sums.load_v[state][i] += state_rate.grad[0] * row;
                            }
                        }
                    }
                    if let Some(state) = contact.state {
                        sums.load_v[state][state] += state_rate.grad[1];
                        sums.g_v[contact_work][state] += by_state * rate;
                    }
                }
                Surfaces::Tendon(_) | Surfaces::Cable(..) => {}
            }
        }
        for &(index, kind) in &self.friction_states {
            sums.load_v[index][index] += kind.relaxation(Dual::<1>::variable(v[index], 0)).grad[0];
        }
    }

    /// Kinematics of a point contact in a state, with the rate of the relative pose of its bodies.
    pub(super) fn point_kinematics(
        &self,
        motions: &Motions<f64>,
        pair: &PointOnFace,
        feature: Option<Feature>,
    ) -> (ContactKinematics<f64, POSES>, [f64; POSES]) {
        let frames = Self::frames(motions, pair.bodies);
        let nearest = pair.nearest_on(&frames, feature);
        (pairs::contact(pair, &frames, nearest), Self::pair_rates(motions, pair.bodies))
    }
}

/// The part of a load on, or of a derivative by, the relative pose of two bodies that belongs to the pose of one of them.
#[inline(always)]
fn of_side(of_pair: &[f64; POSES], side: usize) -> [f64; 3] {
    match side {
        0 => [of_pair[0], of_pair[1], of_pair[2]],
        _ => [-of_pair[0], -of_pair[1], of_pair[3]],
    }
}

impl Contact {
    /// Moment of rolling resistance on the first body at a normal force.
    pub(super) fn rolling_moment(&self, rates: &[f64; POSES], normal: f64) -> f64 {
        self.rolling.as_ref().map_or(0.0, |law| friction_force(law, rates[2] - rates[3], normal))
    }

    fn add_rolling(&self, rates: &[f64; POSES], forces: &mut ContactForces<f64, POSES>) {
        if self.rolling.is_some() {
            let moment = self.rolling_moment(rates, forces.normal);
            forces.load[2] += moment;
            forces.load[3] -= moment;
            forces.power += moment * (rates[2] - rates[3]);
        }
    }

    fn add_rolling_with_derivatives(
        &self,
        rates: &[f64; POSES],
        forces: &mut ContactForces<WithDerivatives<POSES, POSES>, POSES>,
    ) {
        let Some(law) = &self.rolling else { return };
        let (spin, normal) = (rates[2] - rates[3], forces.normal);
        let (arm, slope) = friction_coefficient(law, spin);
        let by_spin = -slope * normal.value;
        let turn = [0.0, 0.0, 1.0, -1.0];
        let moment = WithDerivatives::<POSES, POSES> {
            value: -arm * normal.value,
            by_q: array_from(|k| -arm * normal.by_q[k]),
            by_v: array_from(|k| -arm * normal.by_v[k] + by_spin * turn[k]),
            by_state: 0.0,
        };
        let add = |sum: &mut WithDerivatives<POSES, POSES>, factor: f64, by_turn: f64| {
            sum.value += factor * moment.value;
            for (k, turn) in turn.into_iter().enumerate() {
                sum.by_q[k] += factor * moment.by_q[k];
                sum.by_v[k] += factor * moment.by_v[k] + by_turn * turn;
            }
        };
        add(&mut forces.load[2], 1.0, 0.0);
        add(&mut forces.load[3], -1.0, 0.0);
        add(&mut forces.power, spin, moment.value);
    }

    /// Friction of a joint or cable under a normal force of 1, and its contribution to the rate of the internal state.
    pub(super) fn joint_friction<T: Real>(&self, rate: T, state: Option<T>, range: FrictionRange) -> [T; 2] {
        let Some(law) = &self.friction else { return [T::zero(); 2] };
        let effort = law.force(rate, state, T::constant(1.0), range);
        [effort, law.state_rate(effort)]
    }

    /// Returns the laws if the contact has a force in this mode.
    fn laws(&self, mode: &MechanismMode, index: usize) -> Option<ContactLaws<'_>> {
        ContactLaws::in_mode(&mode.contacts, index, (&self.normal, self.friction.as_ref()))
    }
}

impl System for MechanismModel {
    type Layout = Dynamic;
    type Mode = MechanismMode;

    fn layout(&self) -> Dynamic {
        self.sizes()
    }

    fn second_order_count(&self) -> usize {
        self.second_order()
    }

    fn coordinate_count(&self) -> usize {
        self.coordinates_in_use()
    }

    fn rates(&self, t: f64, q: &Vec<f64>, v: &Vec<f64>, mode: &MechanismMode, rates: &mut Rates<Dynamic>) {
        self.count_turns_as(mode);
        let Rates { a, g } = rates;
        a.fill(0.0);
        g.fill(0.0);
        self.with_factors((q, v), |motions, factors| {
            self.add_loads(t, v, mode, (motions, factors), (a, g));
            self.add_tendon_loads(t, v, mode, motions, (a, g));
            self.add_drive_loads(t, v, mode, motions, (a, g));
            g[self.drive_work()] += self.solve(factors, a);
        });
        self.clock().into_iter().for_each(|clock| a[clock] = 1.0);
    }

    fn linearise(
        &self,
        t: f64,
        q: &Vec<f64>,
        v: &Vec<f64>,
        mode: &MechanismMode,
        linearised: &mut Linearised<Dynamic>,
    ) {
        linearised.clear();
        self.rates(t, q, v, mode, &mut linearised.rates);
        let (rates, mut sums) = Sums::of(linearised);
        self.with_derivatives((q, v), |plain, motions| {
            let field = self.inertial_field(t);
            for group in &self.groups {
                for (at, chunk) in Chunk::of_group(group.first, group.size()) {
                    let (of_group, in_mode) = ((group, &v[..], &rates.a[..]), (mode, field.as_ref()));
                    self.add_group_derivatives(t, of_group, in_mode, (chunk, &motions[at]), &mut sums);
                }
            }
            for (free, field) in self.free_bodies.iter().flat_map(|free| field.iter().map(move |field| (free, field))) {
                let inertia = Inertia::of(&self.mechanism.bodies[free.body]);
                sums.add_free_inertia((free.first, inertia, self.drive_work()), field, &plain.bodies[free.body]);
            }
            self.add_all_pair_derivatives(v, mode, (plain, motions), &mut sums);
            self.add_tendon_derivatives(t, v, mode, (plain, motions), &mut sums);
            self.add_drive_derivatives(t, v, mode, (plain, motions), &mut sums);
        });
        let (count, drive_work) = (self.coordinates_in_use(), self.drive_work());
        self.with_factors((q, v), |_, factors| {
            self.solve_columns(factors, sums.load_q, &mut sums.g_q[drive_work], count);
            self.solve_columns(factors, sums.load_v, &mut sums.g_v[drive_work], count);
            sums.g_t[drive_work] += self.solve(factors, sums.load_t);
        });
    }
}
