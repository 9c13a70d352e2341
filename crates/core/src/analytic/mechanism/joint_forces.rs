//! Forces in joints, by Newton–Euler equations of every body at the accelerations of the model.
//!
//! A revolute joint transmits a force, a prismatic joint a force across its axis and a moment; a coupling adds one
//! unknown. Without redundant constraints, the 3 equations of every body determine all of them.

use super::contacts::Surfaces;
use super::inertial_field::InertialField;
use super::joint::effort_direction;
use super::model::{MechanismMode, MechanismModel, Span};
use super::motion::Motions;
use super::nearest::PointOnFace;
use super::pairs;
use super::palm_frame::inertial_loads;
use crate::analytic::contact::StateRef;
use crate::integrator::{Dynamic, Rates, System};
use crate::mechanism::{ForcePoint, JointCombination, Mechanism};
use crate::numeric::plane::{add, cross, perp, scale, sub};

/// Force and moment of a joint on its second body. The force acts at the joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointForce {
    pub force_n: [f64; 2],
    /// Moment of a prismatic joint, N·m; 0 for a revolute joint.
    pub moment_n_m: f64,
}

/// Forces of all joints in a state, and the memory for the equations from which they follow.
///
/// The equations of each body are those of its forces and of its moment about the centre of mass. There are two
/// unknowns for each joint, then one for each coupling.
#[derive(Clone, Debug, Default)]
pub struct JointForces {
    /// Forces in the last evaluated state.
    pub forces: Vec<JointForce>,
    centers: Vec<[f64; 2]>,
    /// Coefficients of the unknowns and the right-hand side of each equation.
    matrix: Vec<f64>,
    unknowns: usize,
    /// Equations in the order of elimination, and the largest coefficient of each unknown.
    order: Vec<usize>,
    sizes: Vec<f64>,
    solution: Vec<f64>,
    tensions: Vec<f64>,
    /// Accelerations of the coordinates.
    rates: Option<Rates<Dynamic>>,
}

impl JointForces {
    /// Clears all equations.
    fn clear(&mut self, centers: impl Iterator<Item = [f64; 2]>, unknowns: usize) {
        refill(&mut self.centers, centers);
        self.unknowns = unknowns;
        refill(&mut self.matrix, std::iter::repeat_n(0.0, 3 * self.centers.len() * (unknowns + 1)));
    }

    fn row(&mut self, equation: usize) -> &mut [f64] {
        let width = self.unknowns + 1;
        &mut self.matrix[equation * width..(equation + 1) * width]
    }

    /// Adds a force at a point, and a moment, on a body to a column; nothing for the ground.
    fn add(&mut self, column: usize, body: Option<usize>, force: [f64; 2], point: [f64; 2], moment: f64) {
        let Some(body) = body else { return };
        let moment = cross(sub(point, self.centers[body]), force) + moment;
        for (k, part) in [force[0], force[1], moment].into_iter().enumerate() {
            self.row(3 * body + k)[column] += part;
        }
    }

    /// Adds a force at a point, and a moment, on the second of two bodies, with the reaction on the first.
    fn add_pair(&mut self, column: usize, bodies: [Option<usize>; 2], force: [f64; 2], point: [f64; 2], moment: f64) {
        self.add(column, bodies[1], force, point, moment);
        self.add(column, bodies[0], [-force[0], -force[1]], point, -moment);
    }

    /// Solves the consistent equations by elimination with the largest pivot of each column. An unknown without equation is
    /// 0.
    ///
    /// Moments are divided by the longest lever arm, so that they compare with forces. A row is not divided by its own
    /// largest coefficient: that of an axis across a slider is a rounding error, which would become a pivot.
    fn solve(&mut self, joints: usize) {
        let (unknowns, width) = (self.unknowns, self.unknowns + 1);
        let Self { matrix, order, sizes, solution, .. } = self;
        let arm = (0..2 * joints).fold(0.0f64, |longest, k| {
            let largest = |part: usize| {
                matrix.chunks_exact(width).skip(part).step_by(3).fold(0.0f64, |max, row| max.max(row[k].abs()))
            };
            let force = largest(0).max(largest(1));
            if force > 0.0 { longest.max(largest(2) / force) } else { longest }
        });
        if arm > 0.0 {
            let moments = matrix.chunks_exact_mut(width).skip(2).step_by(3);
            moments.flatten().for_each(|entry| *entry /= arm);
        }
        let size = |k: usize| (0..matrix.len() / width).fold(0.0f64, |max, row| max.max(matrix[row * width + k].abs()));
        refill(sizes, (0..unknowns).map(size));
        refill(order, 0..matrix.len() / width);
        refill(solution, std::iter::repeat_n(f64::NAN, unknowns));
        let mut used = 0;
        for k in 0..unknowns {
            let entry = |row: usize| matrix[row * width + k].abs();
            let pivot = (used..order.len()).max_by(|a, b| entry(order[*a]).total_cmp(&entry(order[*b])));
            let Some(pivot) = pivot.filter(|pivot| entry(order[*pivot]) > ROUNDING * sizes[k]) else {
                solution[k] = 0.0;
                continue;
            };
            order.swap(used, pivot);
            let pivot = order[used] * width;
            used += 1;
            for row in order[used..].iter().map(|row| row * width) {
                let factor = matrix[row + k] / matrix[pivot + k];
                if factor != 0.0 {
                    (k..=unknowns).for_each(|j| matrix[row + j] -= factor * matrix[pivot + j]);
                }
            }
        }
        for k in (0..unknowns).rev() {
            if !solution[k].is_nan() {
                continue;
            }
            used -= 1;
            let row = order[used] * width;
            let sum = (k + 1..unknowns).fold(matrix[row + unknowns], |sum, j| sum - matrix[row + j] * solution[j]);
            solution[k] = sum / matrix[row + k];
        }
    }
}

/// A coefficient below this part of the largest one of its unknown is a rounding error of the elimination.
const ROUNDING: f64 = 1e-13;

/// Replaces the content of a list and keeps its memory.
fn refill<T>(list: &mut Vec<T>, content: impl Iterator<Item = T>) {
    list.clear();
    list.extend(content);
}

impl MechanismModel {
    /// Computes the forces of all joints in a state, in the frame of a moving palm; `system` receives the result.
    pub fn joint_forces(&self, t: f64, (q, v): StateRef<'_, Dynamic>, mode: &MechanismMode, system: &mut JointForces) {
        let mut rates = system.rates.take().unwrap_or_else(|| Rates::zero(self.sizes()));
        self.rates(t, q, v, mode, &mut rates);
        let a = &rates.a;
        self.with_columns((q, v), |motions| {
            let unknowns = 2 * self.mechanism.joints.len() + self.mechanism.couplings.len();
            let centers = motions.bodies.iter().take(self.mechanism.bodies.len()).map(|body| body.origin);
            system.clear(centers, unknowns);
            self.add_accelerations(t, a, motions, system);
            self.subtract_loads(t, (a, v), mode, motions, system);
        });
        self.subtract_contacts((q, v), mode, system);
        self.with_motions((q, v), |motions| self.add_unknowns(motions, system));
        for (equation, moves) in self.moves_by_forces.iter().flatten().enumerate() {
            if !moves {
                system.row(equation).fill(0.0);
            }
        }
        system.solve(self.mechanism.joints.len());
        self.with_motions((q, v), |motions| {
            system.forces.clear();
            for joint in 0..self.mechanism.joints.len() {
                let ([first, second], [a, b]) =
                    (self.reactions(joint, motions), [system.solution[2 * joint], system.solution[2 * joint + 1]]);
                let force = [0, 1].map(|k| a * first.0[k] + b * second.0[k]);
                let moment_n_m = a * first.1 + b * second.1;
                system.forces.push(JointForce { force_n: motions.body(self.palm).in_frame(force), moment_n_m });
            }
        });
        system.rates = Some(rates);
    }

    /// Adds the wrenches that give all bodies their accelerations.
    fn add_accelerations(&self, t: f64, a: &[f64], motions: &Motions<f64>, system: &mut JointForces) {
        let (gravity, right) = (self.mechanism.gravity_m_s2, system.unknowns);
        for (index, (body, motion)) in self.mechanism.bodies.iter().zip(&motions.bodies).enumerate() {
            let Span { first, size, is_free } = self.spans[index];
            let support = &motions.body_supports[index].coordinates;
            let [x, y, turn] = match is_free {
                true => [a[first], a[first + 1], if size > 2 { a[first + 2] } else { 0.0 }],
                false => [0, 1, 2].map(|axis| {
                    support
                        .iter()
                        .fold(motion.bias[axis], |sum, k| sum + motions.column(index, *k)[axis] * a[first + k])
                }),
            };
            let force = [x - gravity[0], y - gravity[1]].map(|part| body.mass_kg * part);
            let moment = body.inertia_kg_m2 * turn;
            system.add(right, Some(index), force, motion.origin, moment);
        }
        if let Some(InertialField { field, .. }) = self.inertial_field(t) {
            for (index, [x, y, moment]) in inertial_loads(&self.mechanism, (&field, motions)) {
                system.add(right, Some(index), [-x, -y], motions.bodies[index].origin, -moment);
            }
        }
    }

    /// Both reactions of a joint: a unit force and a unit moment each.
    fn reactions(&self, joint: usize, motions: &Motions<f64>) -> [([f64; 2], f64); 2] {
        let (_, direction, turn) = self.effort_direction(joint, motions);
        match turn == 0.0 {
            true => [(perp(direction), 0.0), ([0.0; 2], 1.0)],
            false => [([1.0, 0.0], 0.0), ([0.0, 1.0], 0.0)],
        }
    }

    /// Point, direction and turn of the effort of a joint: a force along its axis, or a torque.
    fn effort_direction(&self, joint: usize, motions: &Motions<f64>) -> ([f64; 2], [f64; 2], f64) {
        let of = &self.mechanism.joints[joint];
        let (direction, turn) = effort_direction(of, motions.body(of.bodies[0]));
        (motions.body(of.bodies[1]).position(of.points_m[1]), direction, turn)
    }

    /// Subtracts the loads of joints, actuators, springs and tendons at these accelerations and rates.
    fn subtract_loads(
        &self,
        t: f64,
        (a, v): StateRef<'_, Dynamic>,
        mode: &MechanismMode,
        motions: &Motions<f64>,
        system: &mut JointForces,
    ) {
        let right = system.unknowns;
        let mut tensions = std::mem::take(&mut system.tensions);
        let mut subtract = |joint: usize, effort: f64| {
            let (point, direction, turn) = self.effort_direction(joint, motions);
            let bodies = self.mechanism.joints[joint].bodies;
            system.add_pair(right, bodies, direction.map(|part| -effort * part), point, -effort * turn);
        };
        let mut subtract_combined = |on: &JointCombination, effort: f64| {
            on.terms.iter().for_each(|(joint, factor)| subtract(*joint, effort * factor));
        };
        for group in &self.groups {
            for element in &group.elements {
                let motion = motions.combination(&element.on);
                let row = element.row.support.iter().map(|k| motions.row_entry(&element.on, *k) * a[group.first + k]);
                let acceleration = row.fold(motion.bias, |sum, part| sum + part);
                let effort = element.effort(motion.coordinate, motion.rate) - element.inertia * acceleration;
                subtract_combined(&element.on, effort);
            }
        }
        for (index, actuator) in self.mechanism.actuators.iter().enumerate() {
            subtract_combined(&actuator.on, self.actuator_effort(t, (mode, v), motions, index));
        }
        tensions.clear();
        for cable in &self.cables {
            let first = tensions.len();
            self.strand_tensions(t, v, mode, motions, (cable, &mut tensions));
            for (spools, tension) in [(&cable.tendon.joints, first), (&cable.tendon.far_joints, tensions.len() - 1)] {
                spools.iter().for_each(|(joint, factor)| subtract(*joint, -factor * tensions[tension]));
            }
        }
        let mut left = &tensions[..];
        for cable in &self.cables {
            let of_cable;
            (of_cable, left) = left.split_at(self.strand_count(motions, cable));
            for (body, point, force, moment) in self.tendon_forces(motions, (cable, of_cable)) {
                system.add(right, body, force.map(|part| -part), point, -moment);
            }
        }
        system.tensions = tensions;
        for (index, bodies, points_m) in self.linear_springs() {
            let state = pairs::spring(points_m, &Self::frames(motions, bodies));
            let rates = Self::pair_rates(motions, bodies);
            let ([x, y, ..], _) = pairs::spring_loads(&self.mechanism.springs[index], &state, &rates);
            system.add_pair(right, bodies, [x, y], motions.body(bodies[1]).position(points_m[1]), 0.0);
        }
    }

    /// Subtracts the forces of contacts and limits.
    fn subtract_contacts(&self, state: StateRef<'_, Dynamic>, mode: &MechanismMode, system: &mut JointForces) {
        let right = system.unknowns;
        for (index, contact) in self.contacts.iter().enumerate() {
            let reading = self.with_motions(state, |motions| self.world_reading(motions, state.1, index, mode[index]));
            match contact.surfaces {
                Surfaces::Point(PointOnFace { bodies: [body, face], force_point, .. }) => {
                    let (normal, tangent) = (reading.geometry.normal, perp(reading.geometry.normal));
                    let force = [0, 1].map(|k| reading.normal * normal[k] + reading.tangential * tangent[k]);
                    let rates = self.with_motions(state, |motions| Self::pair_rates(motions, [body, face]));
                    let moment = contact.rolling_moment(&rates, reading.normal);
                    let point = reading.geometry.point;
                    let on_face = match force_point {
                        ForcePoint::Each => add(point, scale(normal, reading.delta)),
                        ForcePoint::Face | ForcePoint::Points | ForcePoint::Middle => point,
                    };
                    system.add(right, body, force.map(|part| -part), point, -moment);
                    system.add(right, face, force, on_face, moment);
                }
                Surfaces::Tendon(_) | Surfaces::Cable(..) => {}
                Surfaces::Limit(ref limit) => {
                    let total = -limit.side * reading.normal;
                    for (joint, factor) in self.mechanism.limited_terms(limit) {
                        self.subtract_effort(state, joint, factor * total, system);
                    }
                }
                Surfaces::Friction(joint) => self.subtract_effort(state, joint, reading.tangential, system),
            }
        }
    }

    /// Subtracts the effort of a joint.
    fn subtract_effort(&self, state: StateRef<'_, Dynamic>, joint: usize, effort: f64, system: &mut JointForces) {
        let (point, direction, turn) = self.with_motions(state, |motions| self.effort_direction(joint, motions));
        let (bodies, right) = (self.mechanism.joints[joint].bodies, system.unknowns);
        system.add_pair(right, bodies, direction.map(|part| -effort * part), point, -effort * turn);
    }

    /// Adds the wrenches of the forces of joints and couplings.
    fn add_unknowns(&self, motions: &Motions<f64>, system: &mut JointForces) {
        let Mechanism { joints, couplings, .. } = &self.mechanism;
        for (index, joint) in joints.iter().enumerate() {
            let (point, ..) = self.effort_direction(index, motions);
            for (k, (force, moment)) in self.reactions(index, motions).into_iter().enumerate() {
                system.add_pair(2 * index + k, joint.bodies, force, point, moment);
            }
        }
        for (index, coupling) in couplings.iter().enumerate() {
            for (joint, factor) in &coupling.on.terms {
                let (point, direction, turn) = self.effort_direction(*joint, motions);
                let (force, column) = (direction.map(|part| factor * part), 2 * joints.len() + index);
                system.add_pair(column, joints[*joint].bodies, force, point, factor * turn);
            }
        }
    }
}
