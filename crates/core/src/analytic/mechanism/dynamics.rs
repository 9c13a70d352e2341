//! Accelerations of a mechanism, and their derivatives.
//!
//! M a = Q − bias, with M = Σ Jᵀ M_b J over bodies and armatures, block by block for each group. The derivatives follow
//! from the residual r = M a + bias − Q at constant a, evaluated in numbers with derivatives by the coordinates of a
//! group: ∂a/∂q = −M⁻¹ ∂r/∂q. Rates enter the inertial terms quadratically, so that their derivative by the rates is
//! twice the derivative of the rates by the coordinates.

use super::actuator::{Effort, effort};
use super::factor::Factor;
use super::group::PlacedGroup;
use super::model::{Contact, MechanismMode, MechanismModel, Surfaces, joint_of};
use super::motion::{JointMotion, Motions, pair};
use super::nearest::{Feature, Frame, POSES, PointOnFace};
use super::pairs;
use crate::analytic::model::normal_force_on_branch;
use crate::analytic::multibody::components::ContactLaws;
use crate::analytic::multibody::contact_kinematics::{
    ContactForces, ContactKinematics, WithDerivatives, contact_forces, contact_forces_with_derivatives,
};
use crate::integrator::{Linearised, Rates, System};
use crate::law::{friction_coefficient, friction_force, friction_with_state};
use crate::mechanism::SpringKind;
use crate::numeric::{Dual, Real, array_from};

/// Passive torque or force on a joint: damping and torsional springs, with derivatives; and its damping.
pub(super) fn passive_effort<const N: usize, const K: usize, const C: usize>(
    model: &MechanismModel<N, K, C>,
    joint: usize,
    coordinate: f64,
    rate: f64,
) -> (Effort, f64) {
    let damping = model.mechanism.joints[joint].damping;
    let mut total = Effort { value: -damping * rate, by_rate: -damping, ..Effort::default() };
    for spring in &model.mechanism.springs {
        if let SpringKind::Torsional { on, preload } = &spring.kind
            && joint_of(on) == joint
        {
            total.value += preload - spring.stiffness * (coordinate - spring.rest) - spring.damping * rate;
            total.by_coordinate -= spring.stiffness;
            total.by_rate -= spring.damping;
        }
    }
    (total, -total.by_rate)
}

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

impl<const N: usize, const K: usize, const C: usize> MechanismModel<N, K, C> {
    /// Index of the quadrature for the work of contacts, limits and dampers; that of actuators follows.
    pub(super) const CONTACT_WORK: usize = C;
    pub(super) const DRIVE_WORK: usize = C + 1;

    /// Rates of the poses of two bodies.
    #[inline(always)]
    pub(super) fn pair_rates(motions: &Motions<f64, K>, bodies: [Option<usize>; 2]) -> [f64; POSES] {
        let [a, b] = pair(|side| motions.body(bodies[side]).rate);
        [a[0], a[1], a[2], b[0], b[1], b[2]]
    }

    pub(super) fn frames(motions: &Motions<f64, K>, bodies: [Option<usize>; 2]) -> [Frame<f64>; 2] {
        pair(|side| Frame::new(motions.body(bodies[side])))
    }

    /// Spreads a row over the poses of two bodies to a row over all coordinates.
    pub(super) fn spread(&self, motions: &Motions<f64, K>, bodies: [Option<usize>; 2], row: &[f64; POSES]) -> [f64; N] {
        let mut spread = [0.0; N];
        for (side, body) in bodies.into_iter().enumerate() {
            let Some(body) = body else { continue };
            let (group, jacobian) = (&self.groups[self.group_of[body]], &motions.body(Some(body)).jacobian);
            for i in 0..group.size() {
                for axis in 0..3 {
                    spread[group.first + i] += row[3 * side + axis] * jacobian[axis][i];
                }
            }
        }
        spread
    }

    /// Mass matrix of a group.
    pub(super) fn mass(&self, group: &PlacedGroup, motions: &Motions<f64, K>) -> [[f64; K]; K] {
        let mut mass = [[0.0; K]; K];
        let size = group.size();
        for &index in &group.group.bodies {
            let (body, motion) = (&self.mechanism.bodies[index], motions.body(Some(index)));
            let [x, y] = motion.point(body.com_m).jacobian;
            let turn = &motion.jacobian[2];
            for i in 0..size {
                for j in 0..=i {
                    mass[i][j] += body.mass_kg * (x[i] * x[j] + y[i] * y[j]) + body.inertia_kg_m2 * turn[i] * turn[j];
                }
            }
        }
        for (joint, motion) in self.joints_of(group, motions) {
            let armature = self.mechanism.joints[joint].armature;
            if armature != 0.0 {
                (0..size).for_each(|i| (0..=i).for_each(|j| mass[i][j] += armature * motion.row[i] * motion.row[j]));
            }
        }
        mass
    }

    /// Joints of a group.
    fn joints_of<'a, T>(
        &'a self,
        group: &'a PlacedGroup,
        motions: &'a Motions<T, K>,
    ) -> impl Iterator<Item = (usize, &'a JointMotion<T, K>)> {
        let is_member = move |index: &usize| std::ptr::eq(self.group_of_joint(*index), group);
        (0..self.mechanism.joints.len()).filter(is_member).map(|index| (index, &motions.joints[index]))
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
        let gravity = self.mechanism.gravity_m_s2;
        for group in &self.groups {
            for &index in &group.group.bodies {
                let (body, motion) = (&self.mechanism.bodies[index], motions.body(Some(index)));
                let center = motion.point(body.com_m);
                let force = [0, 1].map(|axis| body.mass_kg * (gravity[axis] - center.bias[axis]));
                let torque = -body.inertia_kg_m2 * motion.bias[2];
                for i in 0..group.size() {
                    load[group.first + i] += center.jacobian[0][i] * force[0]
                        + center.jacobian[1][i] * force[1]
                        + motion.jacobian[2][i] * torque;
                }
            }
        }
        for (joint, motion) in motions.joints.iter().enumerate() {
            let group = self.group_of_joint(joint);
            let (passive, damping) = passive_effort(self, joint, motion.coordinate, motion.rate);
            g[Self::CONTACT_WORK] -= damping * motion.rate * motion.rate;
            let effort = passive.value - self.mechanism.joints[joint].armature * motion.bias;
            (0..group.size()).for_each(|i| load[group.first + i] += motion.row[i] * effort);
        }
        for (index, actuator) in self.mechanism.actuators.iter().enumerate() {
            let (group, motion) =
                (self.group_of_joint(joint_of(&actuator.on)), &motions.joints[joint_of(&actuator.on)]);
            let effort = effort(actuator, mode.ranges.0[index], t, motion.coordinate, motion.rate);
            g[Self::DRIVE_WORK] += effort.value * motion.rate;
            (0..group.size()).for_each(|i| load[group.first + i] += motion.row[i] * effort.value);
        }
        for (index, bodies, points_m) in self.linear_springs() {
            let state = pairs::spring(points_m, &Self::frames(motions, bodies));
            let rates = Self::pair_rates(motions, bodies);
            let (forces, power) = pairs::spring_loads(&self.mechanism.springs[index], &state, &rates);
            self.spread(motions, bodies, &forces).iter().zip(load.iter_mut()).for_each(|(force, load)| *load += force);
            g[Self::CONTACT_WORK] += power;
        }
        for &(index, bristle) in &self.bristles {
            load[index] -= bristle.rate() * v[index];
        }
        for (index, contact) in self.contacts.iter().enumerate() {
            let Some(laws) = contact.laws(mode, index) else { continue };
            match &contact.surfaces {
                Surfaces::Point(pair) => {
                    let frames = Self::frames(motions, pair.bodies);
                    let kinematics = pairs::contact(pair, &frames, mode.features[index]);
                    let rates = Self::pair_rates(motions, pair.bodies);
                    let state = contact.bristle.map(|bristle| v[bristle]);
                    let mut forces = contact_forces(&kinematics, &rates, state, laws);
                    contact.add_rolling(&rates, &mut forces);
                    let spread = self.spread(motions, pair.bodies, &forces.load);
                    spread.iter().zip(load.iter_mut()).for_each(|(force, load)| *load += force);
                    g[index] += forces.normal;
                    g[Self::CONTACT_WORK] += forces.power;
                    if let Some(bristle) = contact.bristle {
                        load[bristle] += forces.bristle_rate;
                    }
                }
                Surfaces::Limit(limit) => {
                    let (group, motion) = (self.group_of_joint(limit.joint), &motions.joints[limit.joint]);
                    let (depth, rate) = (limit.side * (motion.coordinate - limit.value), limit.side * motion.rate);
                    let force = normal_force_on_branch(&limit.law, laws.state, depth, rate).force;
                    let effort = -limit.side * force;
                    (0..group.size()).for_each(|i| load[group.first + i] += motion.row[i] * effort);
                    g[index] += force;
                    g[Self::CONTACT_WORK] -= force * rate;
                }
                Surfaces::Friction(joint) => {
                    let (group, motion) = (self.group_of_joint(*joint), &motions.joints[*joint]);
                    let state = contact.bristle.map(|bristle| v[bristle]);
                    let effort = contact.friction_effort(motion.rate, state);
                    (0..group.size()).for_each(|i| load[group.first + i] += motion.row[i] * effort);
                    g[Self::CONTACT_WORK] += effort * motion.rate;
                    contact.bristle.into_iter().for_each(|bristle| load[bristle] -= effort * contact.stretch_gain());
                }
                Surfaces::Tendon(_) => {}
            }
        }
    }

    /// Solves the mass matrices of all groups for one vector of loads, in place.
    pub(super) fn solve(&self, factors: &[Factor<K>], x: &mut [f64; N]) {
        for (group, factor) in self.groups.iter().zip(factors) {
            factor.solve(&mut x[group.first..group.first + group.size()]);
        }
    }

    /// Adds the derivatives of the loads on a group that depend on the group alone.
    fn add_group_derivatives<const Z: usize>(
        &self,
        t: f64,
        (group, a): (&PlacedGroup, &[f64; N]),
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
            let (body, motion) = (&self.mechanism.bodies[index], motions.body(Some(index)));
            let center = motion.point(body.com_m);
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
        for (joint, motion) in self.joints_of(group, motions) {
            let (passive, damping) = passive_effort(self, joint, motion.coordinate.value, motion.rate.value);
            let armature = self.mechanism.joints[joint].armature;
            let force = motion.coordinate.chain2(motion.rate, passive.value, passive.by_coordinate, passive.by_rate)
                - acceleration(&motion.row, motion.bias) * armature;
            sums.add_block((first, size), &motion.row, force, |j| {
                passive.by_rate * motion.row[j].value - 2.0 * armature * motion.rate.grad[j]
            });
            for j in 0..size {
                let factor = -2.0 * damping * motion.rate.value;
                sums.g_q[Self::CONTACT_WORK][first + j] += factor * motion.rate.grad[j];
                sums.g_v[Self::CONTACT_WORK][first + j] += factor * motion.row[j].value;
            }
        }
        for (index, actuator) in self.mechanism.actuators.iter().enumerate() {
            if !std::ptr::eq(self.group_of_joint(joint_of(&actuator.on)), group) {
                continue;
            }
            let motion = &motions.joints[joint_of(&actuator.on)];
            let effort = effort(actuator, mode.ranges.0[index], t, motion.coordinate.value, motion.rate.value);
            let force = motion.coordinate.chain2(motion.rate, effort.value, effort.by_coordinate, effort.by_rate);
            let row = &motion.row;
            sums.add_block((first, size), row, force, |j| effort.by_rate * row[j].value);
            let (power, by_rate) = (force * motion.rate, effort.by_rate * motion.rate.value + effort.value);
            for (i, entry) in row.iter().enumerate().take(size) {
                sums.load_t[first + i] += entry.value * effort.by_time;
                sums.g_q[Self::DRIVE_WORK][first + i] += power.grad[i];
                sums.g_v[Self::DRIVE_WORK][first + i] += by_rate * entry.value;
            }
            sums.g_t[Self::DRIVE_WORK] += effort.by_time * motion.rate.value;
        }
    }

    /// Adds the derivatives of forces between two bodies: loads on their poses, and numbers added to quadratures or to
    /// the rates of bristle states.
    pub(super) fn add_pair_derivatives<const Z: usize>(
        &self,
        motions: &Motions<Dual<K>, K>,
        bodies: [Option<usize>; 2],
        loads: &[WithDerivatives<POSES, POSES>; POSES],
        quadratures: &[(usize, WithDerivatives<POSES, POSES>)],
        bristle: Option<(usize, WithDerivatives<POSES, POSES>)>,
        sums: &mut Sums<N, Z>,
    ) {
        // Derivatives of a number by all coordinates and their rates, from those by poses and rates of poses.
        let chain = |number: &WithDerivatives<POSES, POSES>| {
            let (mut by_q, mut by_v) = ([0.0; N], [0.0; N]);
            for (side, body) in bodies.into_iter().enumerate() {
                let Some(body) = body else { continue };
                let (group, motion) = (&self.groups[self.group_of[body]], motions.body(Some(body)));
                for axis in 0..3 {
                    let (d_pose, d_rate) = (number.by_q[3 * side + axis], number.by_v[3 * side + axis]);
                    let (jacobian, rate) = (&motion.jacobian[axis], &motion.rate[axis]);
                    for j in 0..group.size() {
                        by_q[group.first + j] += d_pose * jacobian[j].value + d_rate * rate.grad[j];
                        by_v[group.first + j] += d_rate * jacobian[j].value;
                    }
                }
            }
            if let Some((index, _)) = bristle {
                by_v[index] += number.by_bristle;
            }
            (by_q, by_v)
        };
        for (side, body) in bodies.into_iter().enumerate() {
            let Some(body) = body else { continue };
            let (group, motion) = (&self.groups[self.group_of[body]], motions.body(Some(body)));
            for axis in 0..3 {
                let load = &loads[3 * side + axis];
                let (by_q, by_v) = chain(load);
                for i in 0..group.size() {
                    let number = motion.jacobian[axis][i];
                    let row = group.first + i;
                    for j in 0..N {
                        sums.load_q[row][j] += number.value * by_q[j];
                        sums.load_v[row][j] += number.value * by_v[j];
                    }
                    for j in 0..group.size() {
                        sums.load_q[row][group.first + j] += number.grad[j] * load.value;
                    }
                }
            }
        }
        for (index, number) in quadratures {
            let (by_q, by_v) = chain(number);
            for j in 0..N {
                sums.g_q[*index][j] += by_q[j];
                sums.g_v[*index][j] += by_v[j];
            }
        }
        if let Some((index, number)) = bristle {
            let (by_q, by_v) = chain(&number);
            for j in 0..N {
                sums.load_q[index][j] += by_q[j];
                sums.load_v[index][j] += by_v[j];
            }
        }
    }

    /// Adds the derivatives of contacts, limits and linear springs.
    fn add_all_pair_derivatives<const Z: usize>(
        &self,
        v: &[f64; N],
        mode: &MechanismMode<C>,
        motions: &Motions<Dual<K>, K>,
        sums: &mut Sums<N, Z>,
    ) {
        let frames = |bodies: [Option<usize>; 2]| {
            pair(|side| Frame::variable(motions.body(bodies[side]), side, bodies[side].is_none()))
        };
        let rates = |bodies: [Option<usize>; 2]| {
            let [a, b] = pair(|side| &motions.body(bodies[side]).rate);
            [a[0].value, a[1].value, a[2].value, b[0].value, b[1].value, b[2].value]
        };
        for (index, bodies, points_m) in self.linear_springs() {
            let (spring, state) = (&self.mechanism.springs[index], pairs::spring(points_m, &frames(bodies)));
            let (loads, power) = pairs::spring_loads_with_derivatives(spring, &state, &rates(bodies));
            self.add_pair_derivatives(motions, bodies, &loads, &[(Self::CONTACT_WORK, power)], None, sums);
        }
        for (index, contact) in self.contacts.iter().enumerate() {
            let Some(laws) = contact.laws(mode, index) else { continue };
            match &contact.surfaces {
                Surfaces::Point(pair) => {
                    let kinematics = pairs::contact(pair, &frames(pair.bodies), mode.features[index]);
                    let state = contact.bristle.map(|bristle| v[bristle]);
                    let rates = rates(pair.bodies);
                    let mut forces = contact_forces_with_derivatives(&kinematics, &rates, state, laws);
                    contact.add_rolling_with_derivatives(&rates, &mut forces);
                    let quadratures = [(index, forces.normal), (Self::CONTACT_WORK, forces.power)];
                    let bristle = contact.bristle.map(|bristle| (bristle, forces.bristle_rate));
                    self.add_pair_derivatives(motions, pair.bodies, &forces.load, &quadratures, bristle, sums);
                }
                Surfaces::Limit(limit) => {
                    let (group, motion) = (self.group_of_joint(limit.joint), &motions.joints[limit.joint]);
                    let (side, first) = (limit.side, group.first);
                    let depth = (motion.coordinate - limit.value) * side;
                    let rate = motion.rate * side;
                    let law = normal_force_on_branch(&limit.law, laws.state, depth.value, rate.value);
                    let force = depth.chain2(rate, law.force, law.d_delta, law.d_rate);
                    let (load, power) = (force * -side, -(force * rate));
                    sums.add_block((first, group.size()), &motion.row, load, |j| -law.d_rate * motion.row[j].value);
                    for i in 0..group.size() {
                        let row = motion.row[i];
                        let force_by_v = law.d_rate * side * row.value;
                        sums.g_q[index][first + i] += force.grad[i];
                        sums.g_v[index][first + i] += force_by_v;
                        sums.g_q[Self::CONTACT_WORK][first + i] += power.grad[i];
                        sums.g_v[Self::CONTACT_WORK][first + i] -=
                            force_by_v * rate.value + force.value * side * row.value;
                    }
                }
                Surfaces::Friction(joint) => {
                    let (group, motion) = (self.group_of_joint(*joint), &motions.joints[*joint]);
                    let (first, rate) = (group.first, motion.rate.value);
                    let state = contact.bristle.map(|bristle| Dual::<2>::variable(v[bristle], 1));
                    let Dual { value, grad: [by_rate, by_state] } =
                        contact.friction_effort(Dual::<2>::variable(rate, 0), state);
                    let effort = motion.rate.chain(value, by_rate);
                    sums.add_block((first, group.size()), &motion.row, effort, |j| by_rate * motion.row[j].value);
                    let gain = contact.stretch_gain();
                    for i in 0..group.size() {
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

    /// Kinematics of a point contact in a state, with the rates of the poses of its bodies.
    pub(super) fn point_kinematics(
        &self,
        motions: &Motions<f64, K>,
        pair: &PointOnFace,
        feature: Option<Feature>,
    ) -> (ContactKinematics<f64, POSES>, [f64; POSES]) {
        (pairs::contact(pair, &Self::frames(motions, pair.bodies), feature), Self::pair_rates(motions, pair.bodies))
    }
}

impl Contact {
    /// Moment of rolling resistance on the first body at a normal force.
    pub(super) fn rolling_moment(&self, rates: &[f64; POSES], normal: f64) -> f64 {
        self.rolling.as_ref().map_or(0.0, |law| friction_force(law, rates[2] - rates[5], normal))
    }

    fn add_rolling(&self, rates: &[f64; POSES], forces: &mut ContactForces<f64, POSES>) {
        let moment = self.rolling_moment(rates, forces.normal);
        forces.load[2] += moment;
        forces.load[5] -= moment;
        forces.power += moment * (rates[2] - rates[5]);
    }

    fn add_rolling_with_derivatives(
        &self,
        rates: &[f64; POSES],
        forces: &mut ContactForces<WithDerivatives<POSES, POSES>, POSES>,
    ) {
        let Some(law) = &self.rolling else { return };
        let (spin, normal) = (rates[2] - rates[5], forces.normal);
        let (arm, slope) = friction_coefficient(law, spin);
        let by_spin = -slope * normal.value;
        let turn = [0.0, 0.0, 1.0, 0.0, 0.0, -1.0];
        let moment = WithDerivatives::<POSES, POSES> {
            value: -arm * normal.value,
            by_q: array_from(|k| -arm * normal.by_q[k]),
            by_v: array_from(|k| -arm * normal.by_v[k] + by_spin * turn[k]),
            by_bristle: 0.0,
        };
        let add = |sum: &mut WithDerivatives<POSES, POSES>, factor: f64, by_turn: f64| {
            sum.value += factor * moment.value;
            for k in 0..POSES {
                sum.by_q[k] += factor * moment.by_q[k];
                sum.by_v[k] += factor * moment.by_v[k] + by_turn * turn[k];
            }
        };
        add(&mut forces.load[2], 1.0, 0.0);
        add(&mut forces.load[5], -1.0, 0.0);
        add(&mut forces.power, spin, moment.value);
    }

    /// Torque or force of the friction of a joint.
    fn friction_effort<T: Real>(&self, rate: T, state: Option<T>) -> T {
        let one = T::constant(1.0);
        self.friction.as_ref().map_or(T::zero(), |law| friction_with_state(law, rate, state, one))
    }

    /// Gain from the friction to the rate of the bristle state; 0 without a bristle.
    fn stretch_gain(&self) -> f64 {
        self.friction.and_then(|law| law.bristle).map_or(0.0, |bristle| bristle.stretch_gain())
    }

    /// Returns the laws if the contact has a force in this mode.
    fn laws<const C: usize>(&self, mode: &MechanismMode<C>, index: usize) -> Option<ContactLaws<'_>> {
        let state = mode[index];
        state.has_force().then_some(ContactLaws { normal: &self.normal, friction: self.friction.as_ref(), state })
    }
}

impl<const N: usize, const K: usize, const C: usize, const Z: usize> System<N, Z> for MechanismModel<N, K, C> {
    type Mode = MechanismMode<C>;

    fn coordinate_count(&self) -> usize {
        self.coordinates_in_use()
    }

    fn rates(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &MechanismMode<C>) -> Rates<N, Z> {
        let (mut a, mut g) = ([0.0; N], [0.0; Z]);
        self.with_factors((q, v), |motions, factors| {
            self.add_loads(t, v, mode, motions, &mut a, &mut g);
            self.add_tendon_loads(t, v, mode, motions, &mut a, &mut g);
            self.solve(factors, &mut a);
        });
        Rates { a, g }
    }

    fn linearise(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &MechanismMode<C>) -> Linearised<N, Z> {
        let rates = <Self as System<N, Z>>::rates(self, t, q, v, mode);
        let mut sums = Sums::<N, Z>::ZERO;
        self.with_derivatives((q, v), |motions| {
            for group in &self.groups {
                self.add_group_derivatives(t, (group, &rates.a), mode, motions, &mut sums);
            }
            self.add_all_pair_derivatives(v, mode, motions, &mut sums);
            if !self.cables.is_empty() {
                let plain = motions.value();
                self.add_tendon_derivatives(t, v, mode, (&plain, motions), &mut sums);
            }
        });
        let count = self.coordinates_in_use();
        let (mut a_q, mut a_v, mut a_t) = (sums.load_q, sums.load_v, sums.load_t);
        self.with_factors((q, v), |_, factors| {
            for matrix in [&mut a_q, &mut a_v] {
                for j in 0..count {
                    let mut column = array_from(|i| matrix[i][j]);
                    self.solve(factors, &mut column);
                    matrix.iter_mut().zip(column).for_each(|(row, entry)| row[j] = entry);
                }
            }
            self.solve(factors, &mut a_t);
        });
        Linearised { rates, a_q, a_v, a_t, g_q: sums.g_q, g_v: sums.g_v, g_t: sums.g_t }
    }
}
