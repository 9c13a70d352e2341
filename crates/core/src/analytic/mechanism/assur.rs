//! Assur groups beyond dyads: four or more bodies that close several loops at once. Newton's method places them, from the
//! coordinates at the last accepted state; rates, derivatives and bias accelerations follow from the constraints, which are
//! linear in them.
//!
//! The unknowns are the coordinates of the joints of a tree, by which each body is attached to one before it, without those
//! that are coordinates of the mechanism; the equations are the constraints of the joints that close the loops. For a dyad
//! they are those of [`super::dyad`].

use super::dyad::{Transmission, applied, move_joint_between};
use super::joint::{Closure, carried, carried_bias, closure, column, joint_coordinate, misfit, place, quadratic_terms};
use super::motion::{BodyMotion, Motions, Part, pair, triple};
use crate::mechanism::structure::Attachment;
use crate::mechanism::{Joint, Mechanism};
use crate::numeric::plane::{dot, perp, sub};
use crate::numeric::{Dual, Real};

/// Correction, in rad or parts of the length of the bodies, after which the next one would be near rounding errors.
const CONVERGED: f64 = 1e-7;
/// Grid from which the last iterations start, in these units, so that the result is a function of the state alone, whatever
/// the start: a power of 2, far above the error that is left.
const GRID: f64 = 1.0 / (1 << 20) as f64;
/// Iterations from the grid to rounding errors.
const LAST_ITERATIONS: usize = 2;
/// Largest change of a coordinate from the last accepted state, and largest correction, in these units: steps change them by
/// a part of it.
const MAX_CHANGE: f64 = 1.0;
/// Enough for a start that a valid step reaches: corrections are squared from one iteration to the next.
const MAX_ITERATIONS: usize = 20;

/// Largest change of the coordinate of a joint in a step, as a part of the sine, with the rates at its start: the sine, which
/// changes by about as much, cannot vanish within the step, and Newton's method stays on its branch.
const STEP: f64 = 0.2;
/// The same at the end of the step.
const STEP_AT_END: f64 = 0.4;

/// The joints of an Assur group: those of its tree, in the order of placement, and those that close its loops.
#[derive(Clone, Copy)]
pub(super) struct Assur<'a> {
    pub mechanism: &'a Mechanism,
    pub tree: &'a [Attachment],
    /// For each joint of the tree, its index among the coordinates of the group; `None` if its coordinate is not
    /// independent.
    pub known: &'a [Option<usize>],
    pub closing: &'a [usize],
}

/// Equations of the loops in one state.
struct Equations<T> {
    /// Motion of each body per unit of the rate of its own joint, and its arm from its base, turned by a quarter.
    columns: Vec<[T; 3]>,
    across: Vec<[T; 2]>,
    /// Derivatives of the constraints of each closing joint by x, y and θ of its bodies.
    closures: Vec<Closure<T>>,
    /// Inverse of the derivatives of all constraints by the unknown coordinates of the tree, row by row.
    inverse: Vec<T>,
    /// Sign of its determinant.
    sign: f64,
}

impl<'a> Assur<'a> {
    /// Index of a body in the tree; `None` for a base.
    pub fn member(&self, body: Option<usize>) -> Option<usize> {
        body.and_then(|body| self.tree.iter().position(|at| at.body == body))
    }

    /// Joints of the tree with unknown coordinates.
    fn unknowns(&self) -> Vec<usize> {
        (0..self.tree.len()).filter(|k| self.known[*k].is_none()).collect()
    }

    fn joint(&self, k: usize) -> &'a Joint {
        &self.mechanism.joints[self.tree[k].joint]
    }

    /// Joints that connect the bodies of the group; those of the tree come first.
    pub fn joints(self) -> impl Iterator<Item = usize> + 'a {
        self.tree.iter().map(|at| at.joint).chain(self.closing.iter().copied())
    }

    /// Distance of the joint that attaches a body from the furthest one of its others, in the frame of the body.
    fn arm(&self, k: usize) -> f64 {
        let at = &self.tree[k];
        let own = self.joint(k).points_m[usize::from(at.is_second)];
        let of_body = |joint: usize| {
            let Joint { bodies, points_m, .. } = &self.mechanism.joints[joint];
            let sides = bodies.iter().zip(points_m).filter(|(body, _)| **body == Some(at.body));
            sides.map(|(_, point)| sub(*point, own)).map(|arm| dot(arm, arm)).fold(0.0, f64::max)
        };
        self.joints().map(of_body).fold(0.0, f64::max).sqrt()
    }

    /// Length of the longest body.
    pub fn length(&self) -> f64 {
        let longest = (0..self.tree.len()).map(|k| self.arm(k)).fold(0.0, f64::max);
        if longest > 0.0 { longest } else { 1.0 }
    }

    /// Length by which the rotation of each body about its joint is multiplied to compare it with the misfit of the
    /// loops; 1 for a sliding body.
    pub fn scales(&self) -> Vec<f64> {
        let length = self.length();
        let scale = |k: usize| match (self.joint(k).kind.is_angle(), self.arm(k)) {
            (false, _) => 1.0,
            (true, arm) if arm > 0.0 => arm,
            _ => length,
        };
        (0..self.tree.len()).map(scale).collect()
    }

    /// Unit of the coordinate of a joint of the tree: a radian, or the length of the bodies.
    fn unit(&self, k: usize) -> f64 {
        if self.joint(k).kind.is_angle() { 1.0 } else { self.length() }
    }

    fn equations<T: Real>(&self, body: impl Fn(Option<usize>) -> BodyMotion<T>) -> Equations<T> {
        let (size, unknowns) = (self.tree.len(), self.unknowns());
        let joint_motion = |k: usize| {
            let (base, own) = (body(self.tree[k].base), body(Some(self.tree[k].body)));
            (column(self.joint(k), &self.tree[k], [&base, &own]), perp(sub(own.origin, base.origin)))
        };
        let (columns, across): (Vec<_>, Vec<_>) = (0..size).map(joint_motion).unzip();
        // Motion of each body per unit of the rate of each joint.
        let mut moved = vec![[T::zero(); 3]; size * size];
        for k in 0..size {
            if let Some(base) = self.member(self.tree[k].base) {
                (0..k).for_each(|other| moved[k * size + other] = carried(moved[base * size + other], across[k]));
            }
            moved[k * size + k] = columns[k];
        }
        let closure_of = |joint: &usize| {
            let joint = &self.mechanism.joints[*joint];
            closure(joint, [0, 1], &pair(|side| body(joint.bodies[side])))
        };
        let closures: Vec<_> = self.closing.iter().map(closure_of).collect();
        let mut matrix = Vec::with_capacity(unknowns.len() * unknowns.len());
        for (joint, closure) in self.closing.iter().zip(&closures) {
            let members = self.mechanism.joints[*joint].bodies.map(|body| self.member(body));
            for equation in 0..2 {
                matrix.extend(unknowns.iter().map(|k| {
                    let sides = members.iter().enumerate().filter_map(|(side, member)| Some((side, (*member)?)));
                    sides.fold(T::zero(), |sum, (side, member)| {
                        sum + applied(closure, equation, side, moved[member * size + k])
                    })
                }));
            }
        }
        let (inverse, sign) = invert(matrix, unknowns.len());
        Equations { columns, across, closures, inverse, sign }
    }

    /// Misfit of the constraints of the closing joints.
    fn misfits(&self, motions: &Motions<f64>) -> Vec<f64> {
        let of_joint = |joint: &usize| {
            let joint = &self.mechanism.joints[*joint];
            misfit(joint, joint.bodies.map(|body| motions.body(body)))
        };
        self.closing.iter().flat_map(of_joint).collect()
    }

    fn place_at(&self, coordinates: &[f64], motions: &mut Motions<f64>) {
        for (k, at) in self.tree.iter().enumerate() {
            let base = *motions.body(at.base);
            place(self.joint(k), at, &base, coordinates[k], &mut motions.bodies[at.body]);
            motions.joints[at.joint].coordinate = coordinates[k];
        }
    }

    /// One iteration of Newton's method: corrects the coordinates, and returns the largest correction, in rad or parts of the
    /// length of the bodies, and the sign of the determinant.
    fn correct(&self, coordinates: &mut [f64], motions: &mut Motions<f64>) -> (f64, f64) {
        self.place_at(coordinates, motions);
        let (equations, misfits) = (self.equations(|body| *motions.body(body)), self.misfits(motions));
        let mut largest = 0.0;
        for (row, k) in equations.inverse.chunks_exact(misfits.len()).zip(self.unknowns()) {
            let correction: f64 = row.iter().zip(&misfits).map(|(entry, misfit)| entry * misfit).sum();
            coordinates[k] -= correction;
            let relative = correction.abs() / self.unit(k);
            if relative.is_nan() || relative > largest {
                largest = relative;
            }
        }
        (largest, equations.sign)
    }

    /// Evaluates the poses of all bodies and the coordinates of all joints, on the branch on which the determinant has
    /// this sign. They are NaN if Newton's method does not find them near the coordinates of the last accepted state.
    pub fn place(&self, sign: f64, q: &[f64], motions: &mut Motions<f64>) {
        let unknowns = self.unknowns();
        let near = self.tree.iter().zip(self.known).map(|(at, known)| known.map_or(motions.near[at.joint], |k| q[k]));
        let start: Vec<f64> = near.collect();
        let mut coordinates = start.clone();
        let has_converged = (0..MAX_ITERATIONS)
            .map(|_| self.correct(&mut coordinates, motions).0)
            .find(|largest| !(CONVERGED..=MAX_CHANGE).contains(largest))
            .is_some_and(|largest| largest < CONVERGED);
        let change = |k: &usize| (coordinates[*k] - start[*k]).abs() / self.unit(*k);
        let is_near = has_converged && unknowns.iter().all(|k| change(k) < MAX_CHANGE);
        for k in unknowns {
            let grid = GRID * self.unit(k);
            coordinates[k] = if is_near { (coordinates[k] / grid).round() * grid } else { f64::NAN };
        }
        let on_branch = (0..LAST_ITERATIONS).fold(false, |_, _| self.correct(&mut coordinates, motions).1 == sign);
        if !on_branch {
            coordinates.fill(f64::NAN);
        }
        self.place_at(&coordinates, motions);
        for &joint in self.closing {
            motions.joints[joint].coordinate =
                joint_coordinate(&self.mechanism.joints[joint], |body| *motions.body(body));
        }
    }

    /// Sign of the determinant of the constraints in these poses. It is constant on a branch.
    pub fn sign(&self, motions: &Motions<f64>) -> f64 {
        self.equations(|body| *motions.body(body)).sign
    }

    /// Evaluates the motions of all bodies and joints at the rates `v` of the coordinates of the group. Their poses and
    /// coordinates are known.
    pub fn close<T: Real>(&self, v: &[f64], motions: &mut Motions<T>, part: Part) {
        let (size, unknowns) = (self.tree.len(), self.unknowns());
        let equations = self.equations(|body| *motions.body(body));
        let bases: Vec<usize> = self.tree.iter().map(|at| motions.index(at.base)).collect();
        let (mut moved, mut rates) = (vec![[T::zero(); 3]; size], vec![T::zero(); size]);
        if part.has_rates() {
            let known = |index: usize| v[index];
            self.move_closed(&equations, (|body| motions.body(body).rate, known), (&mut moved, &mut rates));
            for (k, at) in self.tree.iter().enumerate() {
                motions.joints[at.joint].rate = rates[k];
                motions.bodies[at.body].rate = moved[k];
            }
        }
        if part.has_derivatives() {
            for i in motions.body_supports[self.tree[0].body].coordinates.clone() {
                let of_body = |body: Option<usize>| motions.column(motions.index(body), i);
                let known = |index: usize| if index == i { 1.0 } else { 0.0 };
                self.move_closed(&equations, (of_body, known), (&mut moved, &mut rates));
                for (k, at) in self.tree.iter().enumerate() {
                    let (row, column) = (motions.joint_supports[at.joint].first, motions.body_supports[at.body].first);
                    motions.rows[row + i] = rates[k];
                    motions.columns[column + i] = moved[k];
                }
            }
            // The bias accelerations with the joints of the tree at rest, and what is missing to close the loops.
            let carried_biases = |motions: &mut Motions<T>, accelerations: &[T]| {
                for (k, at) in self.tree.iter().enumerate() {
                    let bodies = [&motions.bodies[bases[k]], &motions.bodies[at.body]];
                    let carried = carried_bias(self.joint(k), at, bodies, motions.joints[at.joint].rate);
                    let own = equations.columns[k];
                    motions.joints[at.joint].bias = accelerations[k];
                    motions.bodies[at.body].bias = triple(|axis| carried[axis] + own[axis] * accelerations[k]);
                }
            };
            carried_biases(motions, &vec![T::zero(); size]);
            let residual = |(closing, joint): (usize, &usize)| {
                let joint = &self.mechanism.joints[*joint];
                let bodies = pair(|side| *motions.body(joint.bodies[side]));
                let terms = quadratic_terms(joint, [0, 1], &bodies);
                let closure = &equations.closures[closing];
                pair(|equation| {
                    applied(closure, equation, 0, bodies[0].bias)
                        + applied(closure, equation, 1, bodies[1].bias)
                        + terms[equation]
                })
            };
            let residuals: Vec<T> = self.closing.iter().enumerate().flat_map(residual).collect();
            rates.fill(T::zero());
            equations.solve(&residuals, (&unknowns, &mut rates));
            carried_biases(motions, &rates);
        }
        for &joint in self.closing {
            let bodies = pair(|side| motions.index(self.mechanism.joints[joint].bodies[side]));
            move_joint_between(self.mechanism, bodies, joint, motions, part);
        }
    }

    /// Evaluates the motions of all bodies and the rates of the joints of the tree from the motions of the bases and the known
    /// rates.
    fn move_closed<T: Real>(
        &self,
        equations: &Equations<T>,
        (base, known): (impl Fn(Option<usize>) -> [T; 3], impl Fn(usize) -> f64),
        (moved, rates): (&mut [[T; 3]], &mut [T]),
    ) {
        let motion = |moved: &[[T; 3]], body: Option<usize>| self.member(body).map_or_else(|| base(body), |k| moved[k]);
        let move_bodies = |moved: &mut [[T; 3]], rates: &[T]| {
            for (k, at) in self.tree.iter().enumerate() {
                let (carried, own) = (carried(motion(moved, at.base), equations.across[k]), equations.columns[k]);
                moved[k] = triple(|axis| carried[axis] + own[axis] * rates[k]);
            }
        };
        for (rate, index) in rates.iter_mut().zip(self.known) {
            *rate = index.map_or(T::zero(), |index| T::constant(known(index)));
        }
        move_bodies(moved, rates);
        let residual = |(joint, closure): (&usize, &Closure<T>)| {
            let bodies = self.mechanism.joints[*joint].bodies.map(|body| motion(moved, body));
            pair(|equation| applied(closure, equation, 0, bodies[0]) + applied(closure, equation, 1, bodies[1]))
        };
        let residuals: Vec<T> = self.closing.iter().zip(&equations.closures).flat_map(residual).collect();
        equations.solve(&residuals, (&self.unknowns(), rates));
        move_bodies(moved, rates);
    }

    /// Sine of the smallest angle between the motion of the loops by the turn of one body, or by one slide, and the motions by
    /// all others: 0 in a singular configuration. For a dyad of pins it is the sine of its transmission angle. The reciprocal
    /// of the turns of the bodies, times their lengths, per unit of a misfit of the loops.
    fn sine_with<T: Real>(&self, body: impl Fn(Option<usize>) -> BodyMotion<T>) -> T {
        let (length, scales) = (self.length(), self.scales());
        let inverse = self.equations(body).inverse;
        // An angle of a closing joint counts as the motion of the end of a body.
        let weights = self.closing.iter().flat_map(|joint| {
            let is_angle = self.mechanism.joints[*joint].kind.is_angle();
            [1.0, if is_angle { 1.0 } else { 1.0 / length }]
        });
        let weights: Vec<f64> = weights.collect();
        let size = weights.len();
        let mut turns = vec![T::zero(); self.tree.len() * size];
        let mut rows = inverse.chunks_exact(size);
        let mut largest = T::zero();
        for (k, at) in self.tree.iter().enumerate() {
            let row = if self.known[k].is_none() { rows.next() } else { None };
            let is_slide = !self.joint(k).kind.is_angle();
            let mut squared = T::zero();
            for equation in 0..size {
                let own = row.map_or(T::zero(), |row| row[equation] * weights[equation]);
                let carried = self.member(at.base).map_or(T::zero(), |base| turns[base * size + equation]);
                let turn = if is_slide { carried } else { carried + own * at.sign() };
                turns[k * size + equation] = turn;
                squared += (if is_slide { own } else { turn }).squared();
            }
            squared = squared * (scales[k] * scales[k]);
            if squared.value().is_nan() || squared.value() > largest.value() {
                largest = squared;
            }
        }
        largest.sqrt().recip()
    }

    /// Sine of the angle that corresponds to the transmission angle of a dyad; NaN without a pose.
    pub fn sine(&self, motions: &Motions<f64>) -> f64 {
        self.sine_with(|body| *motions.body(body))
    }

    /// Returns [`Assur::sine`] and its rate.
    pub fn sine_and_rate(&self, motions: &Motions<f64>) -> [f64; 2] {
        let in_time = |body: Option<usize>| {
            let motion = motions.body(body);
            let (rate, [cos, sin]) = (motion.rate, motion.direction);
            let number = |value: f64, rate: f64| Dual { value, grad: [rate] };
            BodyMotion::<Dual<1>> {
                origin: pair(|axis| number(motion.origin[axis], rate[axis])),
                direction: [number(cos, -sin * rate[2]), number(sin, cos * rate[2])],
                angle: number(motion.angle, rate[2]),
                ..BodyMotion::ground()
            }
        };
        let sine = self.sine_with(in_time);
        [sine.value, sine.grad[0]]
    }

    /// Returns the sine in the form of a transmission: as the sine of an angle whose rate is that of the sine.
    pub fn transmission(&self, motions: &Motions<f64>) -> Transmission {
        let [sine, rate] = self.sine_and_rate(motions);
        Transmission { sine, cosine: 1.0, angle_rate: rate }
    }

    /// Returns the longest allowed step from this state.
    pub fn max_step(&self, motions: &Motions<f64>) -> f64 {
        let [sine, sine_rate] = self.sine_and_rate(motions);
        let rates = (0..self.tree.len()).map(|k| motions.joints[self.tree[k].joint].rate.abs() / self.unit(k));
        STEP * sine / rates.fold((-sine_rate).max(0.0), f64::max)
    }

    /// Whether a step of length `dt` that ends in this state stays on the branch of its start; `motions` contains the
    /// coordinates at the start as `near`.
    pub fn is_valid(&self, dt: f64, motions: &Motions<f64>) -> bool {
        let [sine, sine_rate] = self.sine_and_rate(motions);
        let change = |(k, at): (usize, &Attachment)| {
            (motions.joints[at.joint].coordinate - motions.near[at.joint]).abs() / self.unit(k)
        };
        let largest = self.tree.iter().enumerate().map(change).fold(sine_rate.abs() * dt, f64::max);
        largest <= STEP_AT_END * sine
    }
}

impl<T: Real> Equations<T> {
    /// Rates of the unknown joints of the tree that remove these residuals of the closing joints.
    fn solve(&self, residuals: &[T], (unknowns, rates): (&[usize], &mut [T])) {
        for (row, k) in self.inverse.chunks_exact(residuals.len()).zip(unknowns) {
            rates[*k] = -row.iter().zip(residuals).fold(T::zero(), |sum, (entry, residual)| sum + *entry * *residual);
        }
    }
}

/// Inverse of a matrix by elimination with row pivoting, and the sign of its determinant. Not finite if it is singular.
fn invert<T: Real>(mut matrix: Vec<T>, size: usize) -> (Vec<T>, f64) {
    let mut inverse = vec![T::zero(); size * size];
    (0..size).for_each(|k| inverse[k * size + k] = T::constant(1.0));
    let mut sign = 1.0;
    for k in 0..size {
        let entry = |row: usize| matrix[row * size + k].value().abs();
        let pivot = (k + 1..size).fold(k, |pivot, row| if entry(row) > entry(pivot) { row } else { pivot });
        if pivot != k {
            sign = -sign;
            for column in 0..size {
                matrix.swap(k * size + column, pivot * size + column);
                inverse.swap(k * size + column, pivot * size + column);
            }
        }
        sign *= matrix[k * size + k].value().signum();
        let reciprocal = matrix[k * size + k].recip();
        for column in 0..size {
            matrix[k * size + column] = matrix[k * size + column] * reciprocal;
            inverse[k * size + column] = inverse[k * size + column] * reciprocal;
        }
        for row in (0..size).filter(|row| *row != k) {
            let factor = matrix[row * size + k];
            for column in 0..size {
                let (of_matrix, of_inverse) = (matrix[k * size + column], inverse[k * size + column]);
                matrix[row * size + column] -= factor * of_matrix;
                inverse[row * size + column] -= factor * of_inverse;
            }
        }
    }
    (inverse, sign)
}

#[cfg(test)]
mod tests {
    use super::super::dyad::transmission;
    use super::super::group::motions_at;
    use super::*;
    use crate::mechanism::Body;
    use crate::mechanism::JointKind;

    /// A coupler and a rocker between the ground and a crank.
    fn dyad() -> Mechanism {
        let pin = JointKind::Revolute;
        Mechanism {
            bodies: ["crank", "coupler", "rocker"].map(|name| Body::new(name, 1.0, 1.0)).to_vec(),
            joints: vec![
                Joint::new("crank", pin, [None, Some(0)], [[0.0; 2]; 2]),
                Joint::new("a", pin, [Some(0), Some(1)], [[0.03, 0.0], [0.0; 2]]),
                Joint::new("b", pin, [Some(1), Some(2)], [[0.08, 0.0], [0.05, 0.0]]),
                Joint::new("rocker", pin, [None, Some(2)], [[0.04, 0.0], [0.0; 2]]),
            ],
            ..Mechanism::default()
        }
    }

    const TREE: [Attachment; 2] = [
        Attachment { joint: 1, body: 1, base: Some(0), is_second: true },
        Attachment { joint: 3, body: 2, base: None, is_second: true },
    ];

    #[test]
    fn the_sine_of_a_dyad_of_pins_is_that_of_its_transmission_angle() {
        let mechanism = dyad();
        for (coupler, rocker) in [(0.3, 1.2), (-0.7, 2.0), (2.5, -0.4), (0.5, 0.5)] {
            let motions = motions_at(&mechanism, &[[0.0; 3], [0.03, 0.0, coupler], [0.04, 0.0, rocker]]);
            let assur = Assur { mechanism: &mechanism, tree: &TREE, known: &[None; 2], closing: &[2] };
            let sine = transmission(&mechanism, (&TREE, 2), &motions).sine;
            let found = assur.sine(&motions);
            assert!((found - sine.abs()).abs() < 1e-13, "{found}, {sine}");
        }
    }

    /// Newton's method closes the dyad on the branch of its start, and finds nothing out of reach.
    #[test]
    fn the_place_of_a_dyad_closes_it_on_its_branch() {
        let mechanism = dyad();
        let assur = Assur { mechanism: &mechanism, tree: &TREE, known: &[None; 2], closing: &[2] };
        // The triangle with the sides 0.01, 0.08 and 0.05 does not close; with a crank at a right angle it does.
        let place = |crank: f64, near: [f64; 2]| {
            let mut motions = motions_at(&mechanism, &[[0.0, 0.0, crank], [0.0; 3], [0.0; 3]]);
            motions.near = vec![0.0, near[0], 0.0, near[1]];
            let branch = {
                let poses = [[0.0, 0.0, crank], [0.0, 0.03, near[0] + crank], [0.04, 0.0, near[1]]];
                assur.sign(&motions_at(&mechanism, &poses))
            };
            assur.place(branch, &[], &mut motions);
            (motions, branch)
        };
        for near in [[-1.6, 0.9], [-2.6, -1.8]] {
            let (motions, branch) = place(std::f64::consts::FRAC_PI_2, near);
            let ends = [motions.bodies[1].position([0.08, 0.0]), motions.bodies[2].position([0.05, 0.0])];
            let miss = sub(ends[0], ends[1]);
            assert!(dot(miss, miss).sqrt() < 4e-16 && assur.sign(&motions) == branch, "{ends:?}");
        }
        assert!(place(0.0, [0.3, 0.5]).0.bodies[1].angle.is_nan());
    }

    #[test]
    fn an_inverse_times_its_matrix_is_the_unit_matrix() {
        let matrix = vec![0.0, 2.0, 1.0, 1.0, -1.0, 3.0, 4.0, 0.5, 0.0];
        let (inverse, sign) = invert(matrix.clone(), 3);
        for (row, column) in (0..9).map(|k| (k / 3, k % 3)) {
            let entry: f64 = (0..3).map(|k| inverse[3 * row + k] * matrix[3 * k + column]).sum();
            assert!((entry - f64::from(u8::from(row == column))).abs() < 1e-15, "{entry}");
        }
        // The determinant is 28.5.
        assert_eq!(sign, 1.0);
        assert!(!invert(vec![1.0, 2.0, 2.0, 4.0], 2).0.iter().all(|entry: &f64| entry.is_finite()));
    }
}
