//! Bodies and joints as in rapier, and the joint reactions to forces: a saddle-point (KKT) system over all bodies.
//!
//! Let M be the mass matrix of the bodies, J the Jacobian of the joint openings with respect to body velocities, and A
//! = J M⁻¹ Jᵀ:
//! * joint-consistent velocities: v ← v − M⁻¹ Jᵀ A⁻¹ (J v − b), with the required opening rates b;
//! * response to a generalised impulse c: M⁻¹ (c + Jᵀ λ) with A λ = −J M⁻¹ c, including joint reactions.
//!
//! The system is general in bodies and joints; it uses only rapier's masses and anchors.

use std::ops::Range;

use super::coordinate::{BodyPose, Row, Twist};
use super::joint::{Pair, constraints};
use super::lists::refill;
use super::plan::{Plan, PlannedBody, PlannedGear};
use super::world::World;
use crate::numeric::dense;
use crate::numeric::elementary::{atan2, hypot, powi};
use crate::numeric::plane::{dot, nearest_equivalent_angle, perp, rotate};

/// Mass and moment of inertia of a body, and their inverses.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inertia {
    pub mass: f64,
    pub inverse_mass: f64,
    pub inertia: f64,
    pub inverse_inertia: f64,
}

/// One side of a pair of constraints: a body, and the opening rates per velocity of the body. Sides on the ground do not
/// move and are omitted.
#[derive(Clone, Copy, Debug)]
struct Side {
    pair: usize,
    body: usize,
    rows: [Twist; 2],
    /// Anchor of a pin relative to the centre of mass in the body frame (`local`) and in the world frame (`arm`), and
    /// the sign of its velocity in the opening rate, 0 for other pairs.
    sign: f64,
    local: [f64; 2],
    arm: [f64; 2],
    /// Whether the reactions of the pair on bodies are not in equilibrium with one another.
    acts_on_ground: bool,
}

/// Consecutive pairs that share no body with other pairs, except for driven bodies, and their factorised part of A. The
/// pins of one finger are a block.
#[derive(Clone, Debug)]
struct Block {
    rows: Range<usize>,
    sides: Range<usize>,
    /// Sides on the same body, which couple their pairs.
    couplings: Vec<(usize, usize)>,
    /// Rows of pairs with one constraint only.
    unused_rows: Vec<usize>,
    factor: Vec<f64>,
    /// First nonzero column of each row of the factor.
    first_columns: Vec<usize>,
}

/// Error for constraints or masses for which the equations of motion have no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the joint constraints are singular: the mechanism is in or near a singular configuration")]
pub struct SingularConstraints;

/// Masses, poses and joints of all bodies, and the factorised joint system.
#[derive(Clone)]
pub struct Linkage {
    pub inertias: Vec<Inertia>,
    pub poses: Vec<BodyPose>,
    /// Constraints of all joints, then of all gears.
    pairs: Vec<Pair>,
    joints: usize,
    /// Sides of all pairs, pair by pair.
    sides: Vec<Side>,
    blocks: Vec<Block>,
    /// Right-hand side and solution.
    multipliers: Vec<f64>,
    responses: Responses,
    /// Rows of all sides and multipliers at the last node, with contacts.
    at_node: (Vec<[Twist; 2]>, Vec<f64>),
}

/// Responses to unit impulses along rows at the poses of the last factorisation. At the end of a step, in the forces of
/// joints and at the start of the next step the same rows are needed.
#[derive(Clone, Default)]
struct Responses {
    rows: Vec<Row>,
    /// Velocities of all bodies, row by row.
    velocities: Vec<Twist>,
    /// Multipliers of all constraints, row by row.
    multipliers: Vec<f64>,
}

impl Linkage {
    /// Reads masses, anchors and poses from rapier's bodies.
    pub fn new(world: &World, plan: &Plan) -> Self {
        let bodies = &world.physics.bodies;
        let rigid = |i: usize| &bodies[world.bodies[i]];
        let inertias: Vec<Inertia> = (0..world.bodies.len())
            .map(|i| {
                // No force moves a driven body.
                if !rigid(i).is_dynamic() {
                    return Inertia::default();
                }
                let properties = rigid(i).mass_properties().local_mprops;
                Inertia {
                    mass: properties.mass(),
                    inverse_mass: properties.inv_mass,
                    inertia: properties.principal_inertia(),
                    inverse_inertia: properties.inv_principal_inertia,
                }
            })
            .collect();
        let poses: Vec<BodyPose> = plan.bodies.iter().map(PlannedBody::pose).collect();
        let gear_pair = |gear: &PlannedGear| {
            let sum = |row: usize| gear.terms.iter().map(|(of, ratios)| ratios[row] * of.value(&poses)).sum();
            Pair::Relation { terms: gear.terms.clone(), closed: [sum(0), sum(1)] }
        };
        let pairs: Vec<Pair> =
            plan.joints.iter().map(|joint| constraints(plan, joint)).chain(plan.gears.iter().map(gear_pair)).collect();
        let (mut sides, mut unused_rows) = (Vec::new(), Vec::new());
        for (pair, of) in pairs.iter().enumerate() {
            let side = |body: usize| Side {
                pair,
                body,
                rows: [[0.0; 3]; 2],
                sign: 0.0,
                local: [0.0; 2],
                arm: [0.0; 2],
                acts_on_ground: true,
            };
            match of {
                Pair::Pin { .. } => {
                    let joint = &plan.joints[pair];
                    // The ground prevents the rotation of bodies that do not rotate.
                    let is_internal =
                        |body: Option<usize>| body.is_some_and(|body| inertias[body].inverse_inertia > 0.0);
                    let acts_on_ground = !joint.bodies.into_iter().all(is_internal);
                    for (k, sign) in [-1.0, 1.0].into_iter().enumerate() {
                        let Some(body) = joint.bodies[k] else { continue };
                        let (com, [x, y]) = (rigid(body).local_center_of_mass(), joint.anchors_m[k]);
                        sides.push(Side { sign, local: [x - com.x, y - com.y], acts_on_ground, ..side(body) });
                    }
                }
                Pair::Relation { terms, .. } => {
                    for (coordinate, _) in terms {
                        let row = coordinate.row(&poses);
                        sides.extend(std::iter::once(row.on).chain(row.against).map(|(body, _)| side(body)));
                    }
                    let is_unused = |row: &usize| terms.iter().all(|(_, ratios)| ratios[*row] == 0.0);
                    unused_rows.extend((0..2).filter(is_unused).map(|row| 2 * pair + row));
                }
            }
        }
        let blocks = find_blocks(pairs.len(), &sides, &unused_rows, &inertias);
        let mut linkage = Self {
            inertias,
            poses,
            joints: plan.joints.len(),
            multipliers: vec![0.0; 2 * pairs.len()],
            pairs,
            sides,
            blocks,
            responses: Responses::default(),
            at_node: (Vec::new(), Vec::new()),
        };
        linkage.read_poses(world, 0.0);
        linkage
    }

    /// Reads the poses of the bodies from rapier, after a step of this length.
    pub(crate) fn read_poses(&mut self, world: &World, dt: f64) {
        for (pose, handle) in self.poses.iter_mut().zip(&world.bodies) {
            let body = &world.physics.bodies[*handle];
            let (com, rotation) = (body.center_of_mass(), body.rotation());
            let direction = [rotation.re, rotation.im];
            // A step turns a body with forces by ω dt, which may be several turns, and a driven one by atan(ω dt).
            let turn = body.angvel() * dt;
            let expected = pose.angle + if body.is_dynamic() { turn } else { atan2(turn, 1.0) };
            let angle = nearest_equivalent_angle(atan2(direction[1], direction[0]), expected);
            *pose = BodyPose { com: [com.x, com.y], direction, angle };
        }
        for side in self.sides.iter_mut().filter(|side| side.sign != 0.0) {
            side.arm = rotate(side.local, self.poses[side.body].direction);
            let [x, y] = perp(side.arm).map(|component| side.sign * component);
            side.rows = [[side.sign, 0.0, x], [0.0, side.sign, y]];
        }
        let mut sides = self.sides.iter_mut().filter(|side| side.sign == 0.0);
        for pair in &self.pairs {
            let Pair::Relation { terms, .. } = pair else { continue };
            for (coordinate, ratios) in terms {
                let row = coordinate.row(&self.poses);
                for ((_, row), side) in std::iter::once(row.on).chain(row.against).zip(&mut sides) {
                    side.rows = ratios.map(|ratio| row.map(|component| ratio * component));
                }
            }
        }
    }

    /// Factorises A at the current poses; fails if the joint constraints are singular.
    pub(crate) fn factorise(&mut self) -> Result<(), SingularConstraints> {
        self.responses.rows.clear();
        self.responses.velocities.clear();
        self.responses.multipliers.clear();
        for Block { rows, couplings, unused_rows, factor, first_columns, .. } in &mut self.blocks {
            let size = rows.len();
            for (row, &first) in factor.chunks_exact_mut(size).zip(&*first_columns) {
                row[first..].fill(0.0);
            }
            for &(a, b) in &*couplings {
                let (a, b) = (&self.sides[a], &self.sides[b]);
                let Inertia { inverse_mass, inverse_inertia, .. } = self.inertias[a.body];
                let offset = (2 * a.pair - rows.start) * size + 2 * b.pair - rows.start;
                for (i, u) in a.rows.iter().enumerate() {
                    for (j, v) in b.rows.iter().enumerate() {
                        let translation = (u[0] * v[0] + u[1] * v[1]) * inverse_mass;
                        factor[offset + i * size + j] += translation + inverse_inertia * u[2] * v[2];
                    }
                }
            }
            unused_rows.iter().for_each(|row| factor[row * size + row] = 1.0);
            if !dense::factor_cholesky(factor, first_columns) {
                return Err(SingularConstraints);
            }
        }
        Ok(())
    }

    /// Returns the largest opening of a joint, m.
    pub(crate) fn max_joint_opening(&self) -> f64 {
        let joints = self.openings().zip(&self.pairs).take(self.joints);
        joints.fold(0.0, |largest, ([x, y], pair)| match pair {
            Pair::Pin { .. } => largest.max(hypot(x, y)),
            Pair::Relation { .. } => largest.max(x.abs()),
        })
    }

    /// Returns the openings of every pair of constraints.
    pub(crate) fn openings(&self) -> impl Iterator<Item = [f64; 2]> {
        let mut sides = self.sides.iter().filter(|side| side.sign != 0.0).peekable();
        self.pairs.iter().enumerate().map(move |(index, pair)| match pair {
            Pair::Pin { ground } => {
                let mut open = [-ground[0], -ground[1]];
                while let Some(side) = sides.next_if(|side| side.pair == index) {
                    let com = self.poses[side.body].com;
                    for axis in 0..2 {
                        open[axis] += side.sign * (com[axis] + side.arm[axis]);
                    }
                }
                open
            }
            Pair::Relation { terms, closed } => {
                let mut open = [-closed[0], -closed[1]];
                for (coordinate, ratios) in terms {
                    let value = coordinate.value(&self.poses);
                    (0..2).for_each(|axis| open[axis] += ratios[axis] * value);
                }
                open
            }
        })
    }

    /// Computes the openings' accelerations −J̇ v into `multipliers`, for pins the centripetal accelerations of the
    /// anchors.
    fn centripetal(&mut self, velocities: &[Twist]) {
        self.multipliers.fill(0.0);
        for side in self.sides.iter().filter(|side| side.sign != 0.0) {
            let square = side.sign * powi(velocities[side.body][2], 2);
            self.multipliers[2 * side.pair] += square * side.arm[0];
            self.multipliers[2 * side.pair + 1] += square * side.arm[1];
        }
        for (index, pair) in self.pairs.iter().enumerate() {
            let Pair::Relation { terms, .. } = pair else { continue };
            for (coordinate, ratios) in terms {
                let second_rate = coordinate.second_rate(&self.poses, velocities);
                (0..2).for_each(|axis| self.multipliers[2 * index + axis] -= ratios[axis] * second_rate);
            }
        }
    }

    /// Returns the opening of every pair in a step of `dt` if its bodies move straight on: ½ dt² J̇ v.
    pub(crate) fn overshoot(&mut self, velocities: &[Twist], dt: f64) -> impl Iterator<Item = [f64; 2]> {
        self.centripetal(velocities);
        let scale = -0.5 * dt * dt;
        self.multipliers.chunks_exact(2).map(move |pair| [scale * pair[0], scale * pair[1]])
    }

    /// Transforms a direction from the world to a body frame; `None` is the ground.
    pub(crate) fn direction_in_body(&self, body: Option<usize>, direction: [f64; 2]) -> [f64; 2] {
        body.map_or(direction, |body| {
            let [c, s] = self.poses[body].direction;
            rotate(direction, [c, -s])
        })
    }

    /// Returns the largest opening acceleration of a pair whose bodies move straight on, m/s².
    pub(crate) fn max_opening_acceleration(&mut self, velocities: &[Twist]) -> f64 {
        self.centripetal(velocities);
        self.multipliers.chunks_exact(2).fold(0.0, |largest, pair| largest.max(hypot(pair[0], pair[1])))
    }

    /// Projects velocities onto the joint constraints, with the smallest change in the mass metric.
    pub fn project(&mut self, velocities: &mut [Twist]) {
        self.multipliers.fill(0.0);
        self.correct(velocities);
    }

    /// Computes the accelerations M⁻¹ (f + Jᵀ λ) with J a = −J̇ v. The accelerations of `driven` bodies are prescribed.
    pub fn accelerations(&mut self, forces: &[Twist], rates: &[Twist], driven: &[(usize, Twist)], out: &mut [Twist]) {
        self.centripetal(rates);
        self.accelerate(forces, driven, out);
    }

    /// Returns the force and moment (x, y, angle) of each joint on its second body, after a call of
    /// [`Linkage::accelerations`] or [`Linkage::respond`].
    pub(crate) fn joint_forces(&self) -> impl Iterator<Item = Twist> {
        let reactions = self.multipliers.chunks_exact(2).zip(&self.pairs).take(self.joints);
        reactions.map(|(multipliers, pair)| match pair {
            Pair::Pin { .. } => [multipliers[0], multipliers[1], 0.0],
            Pair::Relation { terms, .. } => {
                let [x, y] = terms[0].0.axis(&self.poses);
                [multipliers[0] * x, multipliers[0] * y, multipliers[1]]
            }
        })
    }

    /// Returns the forces and moments of joints and gears on `body`. Without a body, returns those on all bodies, but
    /// omits pairs whose reactions on two bodies are in equilibrium with one another. Requires the same preceding call
    /// as [`Linkage::joint_forces`].
    pub(crate) fn reactions(&self, body: Option<usize>) -> impl Iterator<Item = (usize, Twist)> {
        let is_needed = move |side: &&Side| body.map_or(side.acts_on_ground, |body| side.body == body);
        self.sides.iter().filter(is_needed).filter_map(|side| {
            let [a, b] = [self.multipliers[2 * side.pair], self.multipliers[2 * side.pair + 1]];
            let acts = a != 0.0 || b != 0.0;
            acts.then(|| (side.body, std::array::from_fn(|k| a * side.rows[0][k] + b * side.rows[1][k])))
        })
    }

    /// Keeps the rows of all sides and the multipliers at a node, after a call of [`Linkage::accelerations`].
    pub(crate) fn save_reactions(&mut self) {
        let (rows, multipliers) = &mut self.at_node;
        refill(rows, self.sides.iter().map(|side| side.rows));
        multipliers.clone_from(&self.multipliers);
    }

    /// Adds the multipliers of a force along a row to those of the node.
    pub(crate) fn add_reactions(&mut self, row: &Row, force: f64) {
        let (index, size) = (self.response_index(row), self.multipliers.len());
        for (multiplier, unit) in self.at_node.1.iter_mut().zip(&self.responses.multipliers[index * size..]) {
            *multiplier += force * unit;
        }
    }

    /// Adds the rates J̇ᵀ λ of the reactions at the node, given the poses after an interval.
    pub(crate) fn add_reaction_rates(
        &self,
        velocities: &[Twist],
        (poses_after, interval_s): (&[BodyPose], f64),
        rates: &mut [Twist],
    ) {
        let (_, multipliers) = &self.at_node;
        for side in self.sides.iter().filter(|side| side.sign != 0.0) {
            let force = [multipliers[2 * side.pair], multipliers[2 * side.pair + 1]];
            rates[side.body][2] -= side.sign * velocities[side.body][2] * dot(side.arm, force);
        }
        for (pair, multipliers) in self.pairs.iter().zip(multipliers.chunks_exact(2)) {
            let Pair::Relation { terms, .. } = pair else { continue };
            for (coordinate, ratios) in terms {
                let rate = (ratios[0] * multipliers[0] + ratios[1] * multipliers[1]) / interval_s;
                coordinate.row(poses_after).add_to(rates, rate);
                coordinate.row(&self.poses).add_to(rates, -rate);
            }
        }
    }

    /// Adds the mean rates J̇ᵀ λ over the step of `dt` after the node, with the multipliers of the node.
    pub(crate) fn add_mean_reaction_rates(&self, dt: f64, rates: &mut [Twist]) {
        let (rows, multipliers) = &self.at_node;
        for (side, before) in self.sides.iter().zip(rows) {
            for ((row, before), multiplier) in side.rows.iter().zip(before).zip(&multipliers[2 * side.pair..]) {
                let factor = multiplier / dt;
                for (rate, (now, before)) in rates[side.body].iter_mut().zip(row.iter().zip(before)) {
                    *rate += factor * (now - before);
                }
            }
        }
    }

    /// Computes the accelerations that rapier produces from the same forces in a step of `dt` from rest, given the openings
    /// it starts with: J a = −2 open/dt², so that half a step closes them.
    pub(crate) fn accelerations_closing(
        &mut self,
        forces: &[Twist],
        (open, dt): (&[[f64; 2]], f64),
        driven: &[(usize, Twist)],
        out: &mut [Twist],
    ) {
        for (pin, [x, y]) in open.iter().enumerate() {
            let scale = -2.0 / (dt * dt);
            (self.multipliers[2 * pin], self.multipliers[2 * pin + 1]) = (scale * x, scale * y);
        }
        self.accelerate(forces, driven, out);
    }

    fn accelerate(&mut self, forces: &[Twist], driven: &[(usize, Twist)], out: &mut [Twist]) {
        for ((a, f), inertia) in out.iter_mut().zip(forces).zip(&self.inertias) {
            *a = [f[0] * inertia.inverse_mass, f[1] * inertia.inverse_mass, f[2] * inertia.inverse_inertia];
        }
        for (body, acceleration) in driven {
            out[*body] = *acceleration;
        }
        self.correct(out);
    }

    /// Computes the velocity response to a generalised impulse c, passed in `out`: M⁻¹ (c + Jᵀ λ).
    pub fn respond(&mut self, out: &mut [Twist]) {
        for (v, inertia) in out.iter_mut().zip(&self.inertias) {
            *v = [v[0] * inertia.inverse_mass, v[1] * inertia.inverse_mass, v[2] * inertia.inverse_inertia];
        }
        self.project(out);
    }

    /// Computes the velocity response to a unit impulse along a row.
    pub(crate) fn respond_to_unit(&mut self, row: &Row, out: &mut [Twist]) {
        let (index, bodies, size) = (self.response_index(row), out.len(), self.multipliers.len());
        out.copy_from_slice(&self.responses.velocities[index * bodies..(index + 1) * bodies]);
        self.multipliers.copy_from_slice(&self.responses.multipliers[index * size..(index + 1) * size]);
    }

    /// Returns the index of the response to a unit impulse along a row, computed at most once for the same poses.
    fn response_index(&mut self, row: &Row) -> usize {
        let index = self.responses.rows.iter().position(|known| known == row);
        index.unwrap_or_else(|| {
            let mut velocities = std::mem::take(&mut self.responses.velocities);
            let first = velocities.len();
            velocities.resize(first + self.inertias.len(), [0.0; 3]);
            row.add_to(&mut velocities[first..], 1.0);
            self.respond(&mut velocities[first..]);
            self.responses.velocities = velocities;
            self.responses.multipliers.extend_from_slice(&self.multipliers);
            self.responses.rows.push(row.clone());
            self.responses.rows.len() - 1
        })
    }

    /// v ← v + M⁻¹ Jᵀ A⁻¹ (b − J v), with b passed in `multipliers`.
    fn correct(&mut self, velocities: &mut [Twist]) {
        for block in &self.blocks {
            let sides = &self.sides[block.sides.clone()];
            for side in sides {
                let [x, y, w] = velocities[side.body];
                // An impulse acts on few bodies, and its reactions on those that are connected.
                if x == 0.0 && y == 0.0 && w == 0.0 {
                    continue;
                }
                let b = &mut self.multipliers[2 * side.pair..2 * side.pair + 2];
                for (b, row) in b.iter_mut().zip(&side.rows) {
                    *b -= row[0] * x + row[1] * y + w * row[2];
                }
            }
            let multipliers = &mut self.multipliers[block.rows.clone()];
            if multipliers.iter().all(|b| *b == 0.0) {
                continue;
            }
            dense::solve_cholesky(&block.factor, &block.first_columns, multipliers);
            for side in sides {
                let inertia = &self.inertias[side.body];
                let b = &self.multipliers[2 * side.pair..2 * side.pair + 2];
                let v = &mut velocities[side.body];
                let [row, other] = &side.rows;
                v[0] += inertia.inverse_mass * (row[0] * b[0] + other[0] * b[1]);
                v[1] += inertia.inverse_mass * (row[1] * b[0] + other[1] * b[1]);
                v[2] += inertia.inverse_inertia * (other[2] * b[1] + row[2] * b[0]);
            }
        }
    }
}

/// Divides the pairs into blocks.
fn find_blocks(pairs: usize, sides: &[Side], unused_rows: &[usize], inertias: &[Inertia]) -> Vec<Block> {
    let moves = |side: &Side| inertias[side.body].inverse_mass > 0.0 || inertias[side.body].inverse_inertia > 0.0;
    let share_body = |&(a, b): &(usize, usize)| {
        let (a, b) = (&sides[a], &sides[b]);
        a.body == b.body && b.pair <= a.pair && moves(a)
    };
    let couplings: Vec<(usize, usize)> =
        (0..sides.len()).flat_map(|a| (0..sides.len()).map(move |b| (a, b))).filter(share_body).collect();
    let first_pair = |pair: usize| {
        let coupled = couplings.iter().filter(|(a, _)| sides[*a].pair == pair);
        coupled.map(|(_, b)| sides[*b].pair).min().unwrap_or(pair)
    };
    let mut blocks = Vec::new();
    let mut end = pairs;
    for start in (0..pairs).rev() {
        if (start..end).any(|pair| first_pair(pair) < start) {
            continue;
        }
        let (rows, contained) = (2 * start..2 * end, start..end);
        let first_side = sides.partition_point(|side| side.pair < start);
        blocks.push(Block {
            sides: first_side..sides.partition_point(|side| side.pair < end),
            couplings: couplings.iter().copied().filter(|(a, _)| contained.contains(&sides[*a].pair)).collect(),
            unused_rows: unused_rows.iter().filter(|row| rows.contains(row)).map(|row| row - rows.start).collect(),
            factor: vec![0.0; rows.len() * rows.len()],
            first_columns: rows.clone().map(|row| 2 * (first_pair(row / 2) - start)).collect(),
            rows,
        });
        end = start;
    }
    blocks.reverse();
    blocks
}
