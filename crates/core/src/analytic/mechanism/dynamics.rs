//! Accelerations of a mechanism, and their derivatives.
//!
//! M a = Q − bias, with M = Σ Jᵀ M_b J over bodies and armatures, block by block for each group. The derivatives follow
//! from the residual r = M a + bias − Q at constant a, evaluated in numbers with derivatives by the coordinates of a
//! group: ∂a/∂q = −M⁻¹ ∂r/∂q. Rates enter the inertial terms quadratically, so that their derivative by the rates is
//! twice the derivative of the rates by the coordinates.

use super::actuator::{BrakeEffort, Effort, brake_effort, effort};
use super::factor::Factor;
use super::group::{Element, PlacedGroup};
use super::model::{Contact, MechanismMode, MechanismModel, Span, Surfaces};
use super::motion::{Motions, pair};
use super::nearest::{Feature, Frame, POSES, PointOnFace};
use super::pairs;
use super::palm_frame::{Inertia, inertial_loads, power};
use crate::analytic::contact::{
    ContactForces, ContactKinematics, ContactLaws, WithDerivatives, contact_forces, contact_forces_with_derivatives,
    normal_force_on_branch,
};
use crate::analytic::inertial_field::{InertialField, inertial_field};
use crate::integrator::{Linearised, Rates, System};
use crate::law::{FrictionRange, friction_coefficient, friction_force, friction_with_state};
use crate::numeric::{Dual, Real, array_from};

/// Largest number of coordinates of a group for which loops have a constant length.
const MAX_UNROLLED_WIDTH: usize = 4;

/// Derivatives of the loads on all coordinates and of the rates of all quadratures.
pub(super) struct Sums<const N: usize, const Z: usize> {
    pub load_q: [[f64; N]; N],
    pub load_v: [[f64; N]; N],
    pub load_t: [f64; N],
    pub g_q: [[f64; N]; Z],
    pub g_v: [[f64; N]; Z],
    pub g_t: [f64; Z],
}

impl<const N: usize, const Z: usize> Sums<N, Z> {
    pub const ZERO: Self = Self {
        load_q: [[0.0; N]; N],
        load_v: [[0.0; N]; N],
        load_t: [0.0; N],
        g_q: [[0.0; N]; Z],
        g_v: [[0.0; N]; Z],
        g_t: [0.0; Z],
    };

    /// Adds the derivatives of the load of a force along a row of a group; `by_v` is that of the force by the rates.
    #[inline(always)]
    pub fn add_block<const K: usize>(
        &mut self,
        (first, size): (usize, usize),
        row: &[Dual<K>; K],
        force: Dual<K>,
        by_v: impl Fn(usize) -> f64,
    ) {
        for (i, entry) in row.iter().enumerate().take(size) {
            for j in 0..size {
                self.load_q[first + i][first + j] += entry.grad[j] * force.value + entry.value * force.grad[j];
                self.load_v[first + i][first + j] += entry.value * by_v(j);
            }
        }
    }
}

impl<const N: usize, const Z: usize> Sums<N, Z> {
    /// Adds the derivatives of the power of a force on a group; `by_v` is that of the power by the rates.
    #[inline(always)]
    pub(super) fn add_power<const K: usize>(
        &mut self,
        work: usize,
        (first, size): (usize, usize),
        power: Dual<K>,
        by_v: impl Fn(usize) -> f64,
    ) {
        for i in 0..size {
            self.g_q[work][first + i] += power.grad[i];
            self.g_v[work][first + i] += by_v(i);
        }
    }
}

impl<const N: usize, const K: usize, const C: usize> MechanismModel<N, K, C> {
    /// Index of the quadrature for the work of contacts, limits, dampers and brakes; that of actuators and prescribed
    /// motions follows.
    pub(super) const CONTACT_WORK: usize = C;
    pub(super) const DRIVE_WORK: usize = C + 1;

    /// Rate of the relative pose of two bodies.
    #[inline(always)]
    pub(super) fn pair_rates(motions: &Motions<f64, K>, bodies: [Option<usize>; 2]) -> [f64; POSES] {
        let [a, b] = pair(|side| &motions.body(bodies[side]).rate);
        [a[0] - b[0], a[1] - b[1], a[2], b[2]]
    }

    #[inline(always)]
    pub(super) fn frames(motions: &Motions<f64, K>, bodies: [Option<usize>; 2]) -> [Frame<f64>; 2] {
        pair(|side| Frame::new(motions.body(bodies[side])))
    }

    /// Frames of two bodies with their relative pose as variables.
    #[inline(always)]
    pub(super) fn variable_frames(frames: &[Frame<f64>; 2], bodies: [Option<usize>; 2]) -> [Frame<Dual<POSES>>; 2] {
        pair(|side| Frame::variable(&frames[side], side, bodies[side].is_none()))
    }

    /// Number of coordinates of a group in loops, which are unrolled if the groups are small.
    fn width(group: &PlacedGroup) -> usize {
        if K <= MAX_UNROLLED_WIDTH { K } else { group.size() }
    }

    /// Lower triangle of the mass matrix of a group.
    pub(super) fn mass(&self, group: &PlacedGroup, motions: &Motions<f64, K>) -> [[f64; K]; K] {
        let mut mass = [[0.0; K]; K];
        let width = Self::width(group);
        for &index in &group.group.bodies {
            let (body, turn) = (&self.mechanism.bodies[index], &motions.bodies[index].jacobian[2]);
            let [x, y] = &motions.centers[index].jacobian;
            for i in 0..width {
                let [by_x, by_y] = [body.mass_kg * x[i], body.mass_kg * y[i]];
                let by_turn = body.inertia_kg_m2 * turn[i];
                (0..=i).for_each(|j| mass[i][j] += by_x * x[j] + by_y * y[j] + by_turn * turn[j]);
            }
        }
        for element in group.elements.iter().filter(|element| element.inertia != 0.0) {
            let row = motions.combination(&element.on).row;
            (0..width).for_each(|i| (0..=i).for_each(|j| mass[i][j] += element.inertia * row[i] * row[j]));
        }
        mass
    }

    /// Inertial accelerations at time `t`, in the frame of a moving palm.
    pub(super) fn inertial_field(&self, t: f64) -> Option<InertialField> {
        let (_, motion) = self.world.as_ref()?;
        Some(inertial_field(motion, self.mechanism.gravity_m_s2, t))
    }

    /// Adds the inertial loads on all bodies in the frame of a moving palm. Their power is work of the palm.
    fn add_inertial_loads<const Z: usize>(
        &self,
        t: f64,
        motions: &Motions<f64, K>,
        load: &mut [f64; N],
        g: &mut [f64; Z],
    ) {
        let Some(InertialField { field, .. }) = self.inertial_field(t) else { return };
        for (index, of_body) in inertial_loads(&self.mechanism, (&field, motions)) {
            let (Span { first, size, is_free }, motion) = (self.spans[index], &motions.bodies[index]);
            let center = &motions.centers[index];
            g[Self::DRIVE_WORK] += power(of_body, center.rate, motion.rate[2]);
            let load = &mut load[first..first + size];
            if is_free {
                load.iter_mut().zip(of_body).for_each(|(load, part)| *load += part);
                continue;
            }
            let [x, y] = &center.jacobian;
            for (i, load) in load.iter_mut().enumerate() {
                *load += of_body[0] * x[i] + of_body[1] * y[i] + of_body[2] * motion.jacobian[2][i];
            }
        }
    }

    /// Adds the derivatives of the inertial loads.
    fn add_inertial_derivatives<const Z: usize>(
        &self,
        t: f64,
        (plain, motions): (&Motions<f64, K>, &Motions<Dual<K>, K>),
        sums: &mut Sums<N, Z>,
    ) {
        let Some(field) = self.inertial_field(t) else { return };
        for (index, Span { first, size, is_free }) in self.spans.iter().copied().enumerate() {
            let inertia = Inertia::of(&self.mechanism.bodies[index]);
            match is_free {
                true => sums.add_free_inertia((first, inertia, Self::DRIVE_WORK), &field, &plain.bodies[index]),
                false => {
                    let motions = (&motions.centers[index], &motions.bodies[index]);
                    sums.add_group_inertia(((first, size), inertia, Self::DRIVE_WORK), &field, motions);
                }
            }
        }
    }

    /// Adds all loads on the coordinates and the powers of all forces.
    fn add_loads<const Z: usize>(
        &self,
        t: f64,
        v: &[f64; N],
        mode: &MechanismMode<C>,
        motions: &Motions<f64, K>,
        load: &mut [f64; N],
        g: &mut [f64; Z],
    ) {
        for free in &self.free_bodies {
            load[free.first..free.first + 2].copy_from_slice(&free.weight);
        }
        for group in &self.groups {
            let of_group = self.group_loads(t, (group, v), mode, motions, g);
            load[group.first..].iter_mut().zip(of_group).take(group.size()).for_each(|(load, part)| *load = part);
        }
        self.add_inertial_loads(t, motions, load, g);
        for (index, bodies, points_m) in self.linear_springs() {
            let state = pairs::spring(points_m, &Self::frames(motions, bodies));
            let rates = Self::pair_rates(motions, bodies);
            let (forces, power) = pairs::spring_loads(&self.mechanism.springs[index], &state, &rates);
            self.add_pair_loads(motions, bodies, &forces, load);
            g[Self::CONTACT_WORK] += power;
        }
        for (index, actuator) in self.mechanism.actuators.iter().enumerate().filter(|each| each.1.brake.is_some()) {
            let rate = motions.combination(&actuator.on).rate;
            let Some(brake) = self.brake_effort(t, v, index, rate) else { continue };
            brake.bristle.into_iter().for_each(|bristle| load[bristle] += brake.gain * brake.effort.value);
        }
        for &(index, bristle) in &self.bristles {
            load[index] -= bristle.rate() * v[index];
        }
        for (index, contact) in self.contacts.iter().enumerate() {
            let Some(laws) = contact.laws(mode, index) else { continue };
            match &contact.surfaces {
                Surfaces::Point(pair) => {
                    let frames = Self::frames(motions, pair.bodies);
                    let kinematics = pairs::contact(pair, &frames, pair.nearest_on(&frames, mode.features[index]));
                    let rates = Self::pair_rates(motions, pair.bodies);
                    let state = contact.bristle.map(|bristle| v[bristle]);
                    let mut forces = contact_forces(&kinematics, &rates, state, laws);
                    contact.add_rolling(&rates, &mut forces);
                    self.add_pair_loads(motions, pair.bodies, &forces.load, load);
                    g[index] += forces.normal;
                    g[Self::CONTACT_WORK] += forces.power;
                    if let Some(bristle) = contact.bristle {
                        load[bristle] += forces.bristle_rate;
                    }
                }
                Surfaces::Limit(limit) => {
                    let (span, motion) = (self.span_of_joint(limit.joint), &motions.joints[limit.joint]);
                    let coordinate = self.joint_coordinate(motions, limit.joint);
                    let (depth, rate) = (limit.side * (coordinate - limit.value), limit.side * motion.rate);
                    let force = normal_force_on_branch(&limit.law, laws.state, depth, rate).force;
                    let effort = -limit.side * force;
                    (0..span.size).for_each(|i| load[span.first + i] += motion.row[i] * effort);
                    g[index] += force;
                    g[Self::CONTACT_WORK] -= force * rate;
                }
                Surfaces::Friction(joint) => {
                    let (span, motion) = (self.span_of_joint(*joint), &motions.joints[*joint]);
                    let state = contact.bristle.map(|bristle| v[bristle]);
                    let effort = contact.friction_effort(motion.rate, state, laws.range);
                    (0..span.size).for_each(|i| load[span.first + i] += motion.row[i] * effort);
                    g[Self::CONTACT_WORK] += effort * motion.rate;
                    contact.bristle.into_iter().for_each(|bristle| load[bristle] -= effort * contact.stretch_gain());
                }
                Surfaces::Tendon(_) => {}
            }
        }
    }

    /// Loads of inertia, gravity, elements, actuators and brakes on a group, and the powers of elements, actuators and
    /// brakes.
    fn group_loads<const Z: usize>(
        &self,
        t: f64,
        (group, v): (&PlacedGroup, &[f64; N]),
        mode: &MechanismMode<C>,
        motions: &Motions<f64, K>,
        g: &mut [f64; Z],
    ) -> [f64; K] {
        let mut load = [0.0; K];
        let (width, gravity) = (Self::width(group), self.mechanism.gravity_m_s2);
        for &index in &group.group.bodies {
            let (body, motion, center) =
                (&self.mechanism.bodies[index], &motions.bodies[index], &motions.centers[index]);
            let [x, y] = pair(|axis| body.mass_kg * (gravity[axis] - center.bias[axis]));
            let (turn, [by_x, by_y]) = (-body.inertia_kg_m2 * motion.bias[2], &center.jacobian);
            for i in 0..width {
                load[i] += by_x[i] * x + by_y[i] * y + motion.jacobian[2][i] * turn;
            }
        }
        for element in &group.elements {
            let motion = motions.combination(&element.on);
            g[Self::CONTACT_WORK] -= element.damping * motion.rate * motion.rate;
            let effort = element.effort(motion.coordinate, motion.rate) - element.inertia * motion.bias;
            (0..width).for_each(|i| load[i] += motion.row[i] * effort);
        }
        for &index in &group.actuators {
            let actuator = &self.mechanism.actuators[index];
            let motion = motions.combination(&actuator.on);
            let range = self.range_at(t, mode, index, motion.coordinate, motion.rate);
            let mut effort = effort(actuator, range, t, motion.coordinate, motion.rate).value;
            g[Self::DRIVE_WORK] += effort * motion.rate;
            if let Some(brake) = self.brake_effort(t, v, index, motion.rate) {
                g[Self::CONTACT_WORK] += brake.effort.value * motion.rate;
                effort += brake.effort.value;
            }
            (0..width).for_each(|i| load[i] += motion.row[i] * effort);
        }
        load
    }

    /// Effort of the brake of an actuator, if it has one.
    pub(super) fn brake_effort(&self, t: f64, v: &[f64; N], actuator: usize, rate: f64) -> Option<BrakeEffort> {
        let state = self.brake_bristles[actuator].map(|index| (index, v[index]));
        brake_effort(&self.mechanism.actuators[actuator], t, rate, state)
    }

    /// Adds loads on the relative pose of two bodies, or a row over it, to those on all coordinates.
    #[inline(always)]
    pub(super) fn add_pair_loads(
        &self,
        motions: &Motions<f64, K>,
        bodies: [Option<usize>; 2],
        loads: &[f64; POSES],
        load: &mut [f64; N],
    ) {
        for (side, body) in bodies.into_iter().enumerate() {
            let Some(body) = body else { continue };
            let (Span { first, size, is_free }, of_body) = (self.spans[body], of_side(loads, side));
            let load = &mut load[first..first + size];
            if is_free {
                load.iter_mut().zip(of_body).for_each(|(load, part)| *load += part);
                continue;
            }
            let [x, y, turn] = &motions.bodies[body].jacobian;
            for (i, load) in load.iter_mut().enumerate() {
                *load += of_body[0] * x[i] + of_body[1] * y[i] + of_body[2] * turn[i];
            }
        }
    }

    /// Solves the mass matrices of all bodies for one vector of loads, in place. Returns the power that the prescribed
    /// motions require: time is their coordinate, and its rate is 1.
    pub(super) fn solve(&self, factors: &[Factor<K>], x: &mut [f64; N]) -> f64 {
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

    /// Adds the derivatives of the loads on a group that depend on the group alone.
    fn add_group_derivatives<const Z: usize>(
        &self,
        t: f64,
        (group, v, a): (&PlacedGroup, &[f64; N], &[f64; N]),
        mode: &MechanismMode<C>,
        motions: &Motions<Dual<K>, K>,
        sums: &mut Sums<N, Z>,
    ) {
        let (size, first) = (group.size(), group.first);
        let accelerations: [f64; K] = array_from(|k| if k < size { a[first + k] } else { 0.0 });
        // Acceleration of a quantity with this row and bias.
        let acceleration =
            |row: &[Dual<K>; K], bias: Dual<K>| (0..size).fold(bias, |sum, k| sum + row[k] * accelerations[k]);
        for &index in &group.group.bodies {
            let (body, motion, center) =
                (&self.mechanism.bodies[index], &motions.bodies[index], &motions.centers[index]);
            for axis in 0..2 {
                let row = &center.jacobian[axis];
                let total = acceleration(row, center.bias[axis]) - self.mechanism.gravity_m_s2[axis];
                let rate = center.rate[axis];
                sums.add_block((first, size), row, total * -body.mass_kg, |j| -2.0 * body.mass_kg * rate.grad[j]);
            }
            let (row, rate) = (&motion.jacobian[2], motion.rate[2]);
            let total = acceleration(row, motion.bias[2]);
            sums.add_block((first, size), row, total * -body.inertia_kg_m2, |j| {
                -2.0 * body.inertia_kg_m2 * rate.grad[j]
            });
        }
        for element in &group.elements {
            let Element { stiffness, damping, inertia, .. } = *element;
            let motion = motions.combination(&element.on);
            let effort = element.effort(motion.coordinate.value, motion.rate.value);
            let force = motion.coordinate.chain2(motion.rate, effort, -stiffness, -damping)
                - acceleration(&motion.row, motion.bias) * inertia;
            sums.add_block((first, size), &motion.row, force, |j| {
                -damping * motion.row[j].value - 2.0 * inertia * motion.rate.grad[j]
            });
            let power = -(motion.rate * motion.rate * damping);
            let power_by_rate = -2.0 * damping * motion.rate.value;
            sums.add_power(Self::CONTACT_WORK, (first, size), power, |j| power_by_rate * motion.row[j].value);
        }
        for &index in &group.actuators {
            let actuator = &self.mechanism.actuators[index];
            let motion = motions.combination(&actuator.on);
            let (row, rate) = (&motion.row, motion.rate.value);
            let range = self.range_at(t, mode, index, motion.coordinate.value, rate);
            let effort = effort(actuator, range, t, motion.coordinate.value, rate);
            let brake = self.brake_effort(t, v, index, rate);
            let brake_effort = brake.map_or(Effort::default(), |brake| brake.effort);
            for (work, effort) in [(Self::DRIVE_WORK, effort), (Self::CONTACT_WORK, brake_effort)] {
                let force = motion.coordinate.chain2(motion.rate, effort.value, effort.by_coordinate, effort.by_rate);
                sums.add_block((first, size), row, force, |j| effort.by_rate * row[j].value);
                let power_by_rate = effort.by_rate * rate + effort.value;
                sums.add_power(work, (first, size), force * motion.rate, |j| power_by_rate * row[j].value);
                (0..size).for_each(|i| sums.load_t[first + i] += row[i].value * effort.by_time);
                sums.g_t[work] += effort.by_time * rate;
            }
            if let Some(BrakeEffort { effort, bristle: Some(bristle), by_bristle, gain }) = brake {
                for (i, entry) in row.iter().enumerate().take(size) {
                    sums.load_v[first + i][bristle] += entry.value * by_bristle;
                    sums.load_q[bristle][first + i] += gain * effort.by_rate * motion.rate.grad[i];
                    sums.load_v[bristle][first + i] += gain * effort.by_rate * entry.value;
                }
                sums.load_v[bristle][bristle] += gain * by_bristle;
                sums.load_t[bristle] += gain * effort.by_time;
                sums.g_v[Self::CONTACT_WORK][bristle] += by_bristle * rate;
            }
        }
    }

    /// Adds the derivatives of forces between two bodies: loads on their relative pose, and numbers added to quadratures or
    /// to the rates of bristle states.
    pub(super) fn add_pair_derivatives<const Z: usize>(
        &self,
        motions: &Motions<Dual<K>, K>,
        bodies: [Option<usize>; 2],
        loads: &[WithDerivatives<POSES, POSES>; POSES],
        quadratures: &[(usize, WithDerivatives<POSES, POSES>)],
        bristle: Option<(usize, WithDerivatives<POSES, POSES>)>,
        sums: &mut Sums<N, Z>,
    ) {
        // Adds the derivatives of a number to rows over all coordinates and their rates.
        let add = |number: &WithDerivatives<POSES, POSES>, by_q: &mut [f64; N], by_v: &mut [f64; N]| {
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
                let motion = &motions.bodies[body];
                for axis in 0..3 {
                    let (d_pose, d_rate) = (by_pose[axis], by_rate[axis]);
                    let (jacobian, rate) = (&motion.jacobian[axis], &motion.rate[axis]);
                    for j in 0..size {
                        by_q[j] += d_pose * jacobian[j].value + d_rate * rate.grad[j];
                        by_v[j] += d_rate * jacobian[j].value;
                    }
                }
            }
            if let Some((index, _)) = bristle {
                by_v[index] += number.by_bristle;
            }
        };
        for (side, body) in bodies.into_iter().enumerate() {
            let Some(body) = body else { continue };
            let Span { first, size, is_free } = self.spans[body];
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let of_body = [(&loads[0], sign), (&loads[1], sign), (&loads[2 + side], 1.0)];
            for i in 0..size {
                // The load on a coordinate is a sum of those on the pose.
                let mut on_coordinate = WithDerivatives::default();
                let mut add_part = |load: &WithDerivatives<POSES, POSES>, factor: f64| {
                    for k in 0..POSES {
                        on_coordinate.by_q[k] += factor * load.by_q[k];
                        on_coordinate.by_v[k] += factor * load.by_v[k];
                    }
                    on_coordinate.by_bristle += factor * load.by_bristle;
                };
                if is_free {
                    add_part(of_body[i].0, of_body[i].1);
                } else {
                    for ((load, sign), row) in of_body.iter().zip(&motions.bodies[body].jacobian) {
                        add_part(load, sign * row[i].value);
                        let value = sign * load.value;
                        (0..size).for_each(|j| sums.load_q[first + i][first + j] += row[i].grad[j] * value);
                    }
                }
                add(&on_coordinate, &mut sums.load_q[first + i], &mut sums.load_v[first + i]);
            }
        }
        for (index, number) in quadratures {
            add(number, &mut sums.g_q[*index], &mut sums.g_v[*index]);
        }
        if let Some((index, number)) = bristle {
            add(&number, &mut sums.load_q[index], &mut sums.load_v[index]);
        }
    }

    /// Adds the derivatives of contacts, limits and linear springs.
    fn add_all_pair_derivatives<const Z: usize>(
        &self,
        v: &[f64; N],
        mode: &MechanismMode<C>,
        (plain, motions): (&Motions<f64, K>, &Motions<Dual<K>, K>),
        sums: &mut Sums<N, Z>,
    ) {
        for (index, bodies, points_m) in self.linear_springs() {
            let frames = Self::variable_frames(&Self::frames(plain, bodies), bodies);
            let (spring, state) = (&self.mechanism.springs[index], pairs::spring(points_m, &frames));
            let rates = Self::pair_rates(plain, bodies);
            let (loads, power) = pairs::spring_loads_with_derivatives(spring, &state, &rates);
            self.add_pair_derivatives(motions, bodies, &loads, &[(Self::CONTACT_WORK, power)], None, sums);
        }
        for (index, contact) in self.contacts.iter().enumerate() {
            let Some(laws) = contact.laws(mode, index) else { continue };
            match &contact.surfaces {
                Surfaces::Point(pair) => {
                    let frames = Self::frames(plain, pair.bodies);
                    let feature = mode.features[index].unwrap_or_else(|| pair.nearest(&frames).0);
                    let frames = Self::variable_frames(&frames, pair.bodies);
                    let kinematics = pairs::contact(pair, &frames, pair.on_feature(&frames, feature));
                    let state = contact.bristle.map(|bristle| v[bristle]);
                    let rates = Self::pair_rates(plain, pair.bodies);
                    let mut forces = contact_forces_with_derivatives(&kinematics, &rates, state, laws);
                    contact.add_rolling_with_derivatives(&rates, &mut forces);
                    let quadratures = [(index, forces.normal), (Self::CONTACT_WORK, forces.power)];
                    let bristle = contact.bristle.map(|bristle| (bristle, forces.bristle_rate));
                    self.add_pair_derivatives(motions, pair.bodies, &forces.load, &quadratures, bristle, sums);
                }
                Surfaces::Limit(limit) => {
                    let (span, motion) = (self.span_of_joint(limit.joint), &motions.joints[limit.joint]);
                    let side = limit.side;
                    let coordinate = self.joint_coordinate(plain, limit.joint);
                    let depth = (motion.coordinate.chain(coordinate, 1.0) - limit.value) * side;
                    let rate = motion.rate * side;
                    let law = normal_force_on_branch(&limit.law, laws.state, depth.value, rate.value);
                    let force = depth.chain2(rate, law.force, law.d_delta, law.d_rate);
                    let (load, power) = (force * -side, -(force * rate));
                    let of_group = (span.first, span.size);
                    sums.add_block(of_group, &motion.row, load, |j| -law.d_rate * motion.row[j].value);
                    sums.add_power(index, of_group, force, |j| law.d_rate * side * motion.row[j].value);
                    let power_by_rate = -side * (law.d_rate * rate.value + force.value);
                    sums.add_power(Self::CONTACT_WORK, of_group, power, |j| power_by_rate * motion.row[j].value);
                }
                Surfaces::Friction(joint) => {
                    let (Span { first, size, .. }, motion) = (self.span_of_joint(*joint), &motions.joints[*joint]);
                    let rate = motion.rate.value;
                    let state = contact.bristle.map(|bristle| Dual::<2>::variable(v[bristle], 1));
                    let Dual { value, grad: [by_rate, by_state] } =
                        contact.friction_effort(Dual::<2>::variable(rate, 0), state, laws.range);
                    let effort = motion.rate.chain(value, by_rate);
                    sums.add_block((first, size), &motion.row, effort, |j| by_rate * motion.row[j].value);
                    let gain = contact.stretch_gain();
                    for i in 0..size {
                        let (row, rate_q) = (motion.row[i].value, motion.rate.grad[i]);
                        sums.g_q[Self::CONTACT_WORK][first + i] += (by_rate * rate + value) * rate_q;
                        sums.g_v[Self::CONTACT_WORK][first + i] += (by_rate * rate + value) * row;
                        if let Some(bristle) = contact.bristle {
                            sums.load_v[first + i][bristle] += row * by_state;
                            sums.load_q[bristle][first + i] -= gain * by_rate * rate_q;
                            sums.load_v[bristle][first + i] -= gain * by_rate * row;
                        }
                    }
                    if let Some(bristle) = contact.bristle {
                        sums.load_v[bristle][bristle] -= gain * by_state;
                        sums.g_v[Self::CONTACT_WORK][bristle] += by_state * rate;
                    }
                }
                Surfaces::Tendon(_) => {}
            }
        }
        for &(index, bristle) in &self.bristles {
            sums.load_v[index][index] -= bristle.rate();
        }
    }

    /// Kinematics of a point contact in a state, with the rate of the relative pose of its bodies.
    pub(super) fn point_kinematics(
        &self,
        motions: &Motions<f64, K>,
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
            by_bristle: 0.0,
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

    /// Torque or force of the friction of a joint.
    fn friction_effort<T: Real>(&self, rate: T, state: Option<T>, range: FrictionRange) -> T {
        let one = T::constant(1.0);
        self.friction.as_ref().map_or(T::zero(), |law| friction_with_state(law, rate, state, one, range))
    }

    /// Gain from the friction to the rate of the bristle state; 0 without a bristle.
    fn stretch_gain(&self) -> f64 {
        self.friction.and_then(|law| law.bristle).map_or(0.0, |bristle| bristle.stretch_gain())
    }

    /// Returns the laws if the contact has a force in this mode.
    fn laws<const C: usize>(&self, mode: &MechanismMode<C>, index: usize) -> Option<ContactLaws<'_>> {
        ContactLaws::in_mode(&mode.contacts, index, (&self.normal, self.friction.as_ref()))
    }
}

impl<const N: usize, const K: usize, const C: usize, const Z: usize> System<N, Z> for MechanismModel<N, K, C> {
    type Mode = MechanismMode<C>;

    fn coordinate_count(&self) -> usize {
        self.coordinates_in_use()
    }

    fn rates(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &MechanismMode<C>) -> Rates<N, Z> {
        self.count_turns_as(mode);
        let (mut a, mut g) = ([0.0; N], [0.0; Z]);
        self.with_factors((q, v), |motions, factors| {
            self.add_loads(t, v, mode, motions, &mut a, &mut g);
            self.add_tendon_loads(t, v, mode, motions, &mut a, &mut g);
            g[Self::DRIVE_WORK] += self.solve(factors, &mut a);
        });
        Rates { a, g }
    }

    fn linearise(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &MechanismMode<C>) -> Linearised<N, Z> {
        let rates = <Self as System<N, Z>>::rates(self, t, q, v, mode);
        let mut sums = Sums::<N, Z>::ZERO;
        self.with_derivatives((q, v), |plain, motions| {
            for group in &self.groups {
                self.add_group_derivatives(t, (group, v, &rates.a), mode, motions, &mut sums);
            }
            self.add_inertial_derivatives(t, (plain, motions), &mut sums);
            self.add_all_pair_derivatives(v, mode, (plain, motions), &mut sums);
            self.add_tendon_derivatives(t, v, mode, (plain, motions), &mut sums);
        });
        let count = self.coordinates_in_use();
        let Sums { load_q: mut a_q, load_v: mut a_v, load_t: mut a_t, mut g_q, mut g_v, mut g_t } = sums;
        self.with_factors((q, v), |_, factors| {
            for (matrix, powers) in [(&mut a_q, &mut g_q), (&mut a_v, &mut g_v)] {
                for j in 0..count {
                    let mut column = array_from(|i| matrix[i][j]);
                    powers[Self::DRIVE_WORK][j] += self.solve(factors, &mut column);
                    matrix.iter_mut().zip(column).for_each(|(row, entry)| row[j] = entry);
                }
            }
            g_t[Self::DRIVE_WORK] += self.solve(factors, &mut a_t);
        });
        Linearised { rates, a_q, a_v, a_t, g_q, g_v, g_t }
    }
}
