//! Forces in joints, by Newton–Euler equations of every body at the accelerations of the model.
//!
//! A revolute joint transmits a force, a prismatic joint a force across its axis and a moment; a coupling adds one
//! unknown. Without redundant constraints, the 3 equations of every body determine all of them.

use super::model::{MechanismMode, MechanismModel, Surfaces};
use super::motion::Motions;
use super::nearest::PointOnFace;
use super::pairs;
use crate::analytic::mode::StateRef;
use crate::integrator::System;
use crate::mechanism::{ForcePoint, JointCombination, JointKind, Limit};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{add, cross, perp, scale, sub};

/// Force and moment of a joint on its second body: the force acts at the joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointForce {
    pub force_n: [f64; 2],
    /// Moment of a prismatic joint, N·m; 0 for a revolute joint.
    pub moment_n_m: f64,
}

/// Forces and moments about the centres of mass of all bodies.
struct Wrenches<'a> {
    moves_by_forces: &'a [[bool; 3]],
    centers: Vec<[f64; 2]>,
    values: Vec<[f64; 3]>,
}

impl Wrenches<'_> {
    /// Adds a force at a point, and a moment, on a body, where they affect its motion.
    fn add(&mut self, body: Option<usize>, force: [f64; 2], point: [f64; 2], moment: f64) {
        let Some(body) = body else { return };
        let wrench = [force[0], force[1], cross(sub(point, self.centers[body]), force) + moment];
        for ((sum, part), moves) in self.values[body].iter_mut().zip(wrench).zip(self.moves_by_forces[body]) {
            *sum += if moves { part } else { 0.0 };
        }
    }

    /// Adds a force at a point, and a moment, on the second of two bodies, with the reaction on the first.
    fn add_pair(&mut self, bodies: [Option<usize>; 2], force: [f64; 2], point: [f64; 2], moment: f64) {
        self.add(bodies[1], force, point, moment);
        self.add(bodies[0], [-force[0], -force[1]], point, -moment);
    }
}

impl<const N: usize, const K: usize, const C: usize> MechanismModel<N, K, C> {
    /// Returns the forces of all joints in a state, in the frame of a moving palm.
    pub fn joint_forces<const Z: usize>(
        &self,
        t: f64,
        (q, v): StateRef<'_, N>,
        mode: &MechanismMode<C>,
    ) -> Vec<JointForce> {
        let a = <Self as System<N, Z>>::rates(self, t, q, v, mode).a;
        let mut wrenches = self.with_motions((q, v), |motions| self.required_wrenches(&a, motions));
        self.with_motions((q, v), |motions| self.subtract_loads(t, (&a, v), mode, motions, &mut wrenches));
        self.subtract_contacts((q, v), mode, &mut wrenches);
        self.with_motions((q, v), |motions| self.solve_joint_forces(motions, &wrenches))
    }

    /// Wrenches that give all bodies their accelerations.
    fn required_wrenches(&self, a: &[f64; N], motions: &Motions<f64, K>) -> Wrenches<'_> {
        let gravity = self.mechanism.gravity_m_s2;
        let moves_by_forces = &self.moves_by_forces;
        let mut wrenches = Wrenches { moves_by_forces, centers: Vec::new(), values: Vec::new() };
        for (index, (body, center)) in self.mechanism.bodies.iter().zip(&motions.centers).enumerate() {
            let (group, motion) = (&self.groups[self.group_of[index]], &motions.bodies[index]);
            let acceleration =
                |row: &[f64; K], bias: f64| (0..group.size()).fold(bias, |sum, k| sum + row[k] * a[group.first + k]);
            let force =
                |axis: usize| body.mass_kg * (acceleration(&center.jacobian[axis], center.bias[axis]) - gravity[axis]);
            let moment = body.inertia_kg_m2 * acceleration(&motion.jacobian[2], motion.bias[2]);
            wrenches.centers.push(center.position);
            wrenches.values.push([force(0), force(1), moment]);
        }
        wrenches
    }

    /// Point, direction and turn of the effort of a joint: a force along its axis, or a torque.
    fn effort_direction(&self, joint: usize, motions: &Motions<f64, K>) -> ([f64; 2], [f64; 2], f64) {
        let of = &self.mechanism.joints[joint];
        let point = motions.body(of.bodies[1]).position(of.points_m[1]);
        match of.kind {
            JointKind::Revolute => (point, [0.0; 2], 1.0),
            JointKind::Prismatic { axis_rad } => {
                let (sin, cos) = sin_cos(axis_rad);
                (point, motions.body(of.bodies[0]).rotated([cos, sin]), 0.0)
            }
        }
    }

    /// Subtracts the loads of joints, actuators, springs and tendons at these accelerations and rates.
    fn subtract_loads(
        &self,
        t: f64,
        (a, v): StateRef<'_, N>,
        mode: &MechanismMode<C>,
        motions: &Motions<f64, K>,
        wrenches: &mut Wrenches<'_>,
    ) {
        let mut subtract = |joint: usize, effort: f64| {
            let (point, direction, turn) = self.effort_direction(joint, motions);
            let bodies = self.mechanism.joints[joint].bodies;
            wrenches.add_pair(bodies, direction.map(|part| -effort * part), point, -effort * turn);
        };
        let mut subtract_combined = |on: &JointCombination, effort: f64| {
            on.terms.iter().for_each(|(joint, factor)| subtract(*joint, effort * factor));
        };
        for group in &self.groups {
            for element in &group.elements {
                let motion = motions.combination(&element.on);
                let acceleration =
                    (0..group.size()).fold(motion.bias, |sum, k| sum + motion.row[k] * a[group.first + k]);
                let effort = element.effort(motion.coordinate, motion.rate) - element.inertia * acceleration;
                subtract_combined(&element.on, effort);
            }
        }
        for (index, actuator) in self.mechanism.actuators.iter().enumerate() {
            subtract_combined(&actuator.on, self.actuator_effort(t, (mode, v), motions, index));
        }
        let tensions: Vec<f64> =
            self.cables.iter().map(|cable| self.tension(t, v, mode, motions, cable).1.total()).collect();
        for (cable, tension) in self.cables.iter().zip(&tensions) {
            cable.tendon.joints.iter().for_each(|(joint, factor)| subtract(*joint, -factor * tension));
        }
        for (body, point, force) in self.tendon_forces(motions, &tensions) {
            wrenches.add(body, force.map(|part| -part), point, 0.0);
        }
        for (index, bodies, points_m) in self.linear_springs() {
            let state = pairs::spring(points_m, &Self::frames(motions, bodies));
            let rates = Self::pair_rates(motions, bodies);
            let ([.., x, y, _], _) = pairs::spring_loads(&self.mechanism.springs[index], &state, &rates);
            wrenches.add_pair(bodies, [-x, -y], motions.body(bodies[1]).position(points_m[1]), 0.0);
        }
    }

    /// Subtracts the forces of contacts and limits.
    fn subtract_contacts(&self, state: StateRef<'_, N>, mode: &MechanismMode<C>, wrenches: &mut Wrenches<'_>) {
        for (index, contact) in self.contacts.iter().enumerate() {
            let reading = self.world_reading(state, index, mode[index]);
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
                    wrenches.add(body, force.map(|part| -part), point, -moment);
                    wrenches.add(face, force, on_face, moment);
                }
                Surfaces::Tendon(_) => {}
                Surfaces::Limit(Limit { joint, .. }) | Surfaces::Friction(joint) => {
                    let total = match contact.surfaces {
                        Surfaces::Limit(limit) => -limit.side * reading.normal,
                        _ => reading.tangential,
                    };
                    let (point, direction, turn) =
                        self.with_motions(state, |motions| self.effort_direction(joint, motions));
                    let bodies = self.mechanism.joints[joint].bodies;
                    wrenches.add_pair(bodies, direction.map(|part| -total * part), point, -total * turn);
                }
            }
        }
    }

    /// Solves the equations of all bodies for the forces of joints and couplings.
    fn solve_joint_forces(&self, motions: &Motions<f64, K>, wrenches: &Wrenches<'_>) -> Vec<JointForce> {
        let (joints, couplings) = (&self.mechanism.joints, &self.mechanism.couplings);
        // Columns: two unknowns of each joint, one of each coupling, then the right-hand side.
        let mut columns: Vec<Vec<[f64; 3]>> = Vec::new();
        let mut directions = Vec::new();
        let mut column = |add: &dyn Fn(&mut Wrenches<'_>)| {
            let (values, centers) = (vec![[0.0; 3]; wrenches.values.len()], wrenches.centers.clone());
            let mut unit = Wrenches { values, centers, ..*wrenches };
            add(&mut unit);
            columns.push(unit.values);
        };
        for (index, joint) in joints.iter().enumerate() {
            let (point, direction, _) = self.effort_direction(index, motions);
            let (first, moment) = match joint.kind {
                JointKind::Revolute => ([1.0, 0.0], 0.0),
                JointKind::Prismatic { .. } => (perp(direction), 1.0),
            };
            let second = if moment == 0.0 { [0.0, 1.0] } else { [0.0; 2] };
            column(&|unit| unit.add_pair(joint.bodies, first, point, 0.0));
            column(&|unit| unit.add_pair(joint.bodies, second, point, moment));
            directions.push((first, moment));
        }
        for coupling in couplings {
            column(&|unit| {
                for (joint, factor) in &coupling.on.terms {
                    let (point, direction, turn) = self.effort_direction(*joint, motions);
                    let force = direction.map(|part| factor * part);
                    unit.add_pair(joints[*joint].bodies, force, point, factor * turn);
                }
            });
        }
        let solution = solve_consistent(&columns, &wrenches.values);
        directions
            .iter()
            .enumerate()
            .map(|(index, (first, moment))| {
                let [a, b] = [solution[2 * index], solution[2 * index + 1]];
                let (force, moment_n_m) = match *moment == 0.0 {
                    true => ([a, b], 0.0),
                    false => ([a * first[0], a * first[1]], b),
                };
                JointForce { force_n: motions.body(self.palm).in_frame(force), moment_n_m }
            })
            .collect()
    }
}

/// Solves a consistent system of at least as many equations as unknowns, by elimination with the largest scaled pivot of
/// each column.
fn solve_consistent(columns: &[Vec<[f64; 3]>], right: &[[f64; 3]]) -> Vec<f64> {
    let unknowns = columns.len();
    let mut rows: Vec<Vec<f64>> = (0..3 * right.len())
        .map(|row| {
            let entry = |wrenches: &[[f64; 3]]| wrenches[row / 3][row % 3];
            columns.iter().map(|column| entry(column)).chain([entry(right)]).collect()
        })
        .collect();
    let largest = |row: &[f64]| row[..unknowns].iter().fold(f64::MIN_POSITIVE, |max, entry| max.max(entry.abs()));
    let scales: Vec<f64> = rows.iter().map(|row| largest(row)).collect();
    let mut order: Vec<usize> = (0..rows.len()).collect();
    for k in 0..unknowns.min(rows.len()) {
        let scaled = |row: &usize| rows[*row][k].abs() / scales[*row];
        let pivot = (k..order.len()).max_by(|a, b| scaled(&order[*a]).total_cmp(&scaled(&order[*b]))).unwrap_or(k);
        order.swap(k, pivot);
        let pivot_row = rows[order[k]].clone();
        for &row in &order[k + 1..] {
            let factor = rows[row][k] / pivot_row[k];
            if factor != 0.0 {
                (k..=unknowns).for_each(|j| rows[row][j] -= factor * pivot_row[j]);
            }
        }
    }
    let mut solution = vec![0.0; unknowns];
    for k in (0..unknowns.min(rows.len())).rev() {
        let row = &rows[order[k]];
        let sum = (k + 1..unknowns).fold(row[unknowns], |sum, j| sum - row[j] * solution[j]);
        solution[k] = sum / row[k];
    }
    solution
}
