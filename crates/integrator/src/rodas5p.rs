//! Rodas5P: linearly implicit, L-stable, stiffly accurate, order 5(4). Coefficients: G. Steinebach, BIT Numer. Math.
//! 63:27 (2023), in the form (1/(hγ) − J) kᵢ = f(t + cᵢh, y + Σ aᵢⱼ kⱼ) + Σ Cᵢⱼ/h kⱼ + h dᵢ ∂f/∂t.

use super::layout::{Layout, VectorOf, add, add_scaled, add_weighted, copy};
use super::linear::{ShiftedSolver, dot};
use super::method::{Attempt, Method, Refinement, StepStart};
use super::state::{DENSE_TERMS, IMPLICIT_TERMS};
use super::{Dense, Linearised, Rates, State, System};
use crate::numeric::array_from;

/// Rodas5P with the stages of its last attempt, which give the dense output. It has no other history.
#[derive(Clone)]
pub struct Rodas5p<L: Layout> {
    t0: f64,
    h: f64,
    start: State<L>,
    end: State<L>,
    /// Increments of coordinates and rates, and the rates of the quadratures.
    k: [State<L>; STAGES],
    solver: ShiftedSolver<f64, L>,
    rates: Rates<L>,
    /// Right-hand side of a stage.
    right: [VectorOf<L>; 2],
    scratch: VectorOf<L>,
}

/// Maximum number of corrections of a state of the dense output. In a cycle of a gripper, 8 of 1,900 states need more.
const MAX_REFINEMENTS: usize = 3;
/// Error of a corrected state, relative to the tolerances of a step: a state in a separate step may have 10.
const REFINED_ERROR: f64 = 1e-3;
/// Error of contact forces in a corrected state, relative to the largest rate of a quadrature: the forces at the ends of
/// steps have 1e-5 to 1e-4 at the default tolerances.
const REFINED_FORCE_ERROR: f64 = 1e-6;

/// Writes the increments of the quadratures over a step of size `h`: the sum of their rates with these weights. The rates are
/// linear in the increments of the state, so their derivatives are applied once, to the sum of these increments, for which the
/// rest of `sum` is memory.
#[inline(always)]
fn quadratures<L: Layout>(
    stages: &[State<L>; STAGES],
    h: f64,
    lin: &Linearised<L>,
    weights: &[f64; STAGES],
    sum: &mut State<L>,
) {
    let State { q, v, z } = sum;
    q.as_mut().fill(0.0);
    v.as_mut().fill(0.0);
    z.as_mut().fill(0.0);
    add_weighted(q.as_mut(), &weights[..], &stages[..], |k| k.q.as_ref());
    add_weighted(v.as_mut(), &weights[..], &stages[..], |k| k.v.as_ref());
    add_weighted(z.as_mut(), &weights[..], &stages[..], |k| k.z.as_ref());
    let time_weight: f64 = weights.iter().zip(D).fold(0.0, |sum, (weight, d)| sum + weight * d);
    for m in 0..z.as_ref().len() {
        let by_state = dot(&lin.g_q[m], q.as_ref()) + dot(&lin.g_v[m], v.as_ref());
        z[m] = h * (z[m] + h * time_weight * lin.g_t[m] + by_state);
    }
}

impl<L: Layout> Method<L> for Rodas5p<L> {
    fn new(layout: L) -> Self {
        Self {
            t0: 0.0,
            h: 0.0,
            start: State::zero(layout),
            end: State::zero(layout),
            k: std::array::from_fn(|_| State::zero(layout)),
            solver: ShiftedSolver::zero(layout),
            rates: Rates::zero(layout),
            right: [layout.vector(0.0), layout.vector(0.0)],
            scratch: layout.vector(0.0),
        }
    }

    fn error_order(&self) -> f64 {
        5.0
    }

    fn restart(&mut self) {}

    fn accept_step(&mut self) {}

    fn follow(&mut self, _: &Self) {}

    #[inline(always)]
    fn attempt<Y: System<Layout = L>>(&mut self, origin: &StepStart<Y>, h: f64, attempt: &mut Attempt<L>) {
        let StepStart { system, mode, linearised: lin, tolerances, t, latest_time, state: from } = *origin;
        let shift = 1.0 / (h * GAMMA);
        let Self { k, solver, rates, right: [r_q, r_v], scratch, .. } = self;
        let sizes = [system.second_order_count(), system.coordinate_count()];
        // Coordinates of first-order states stay at 0: whole vectors need no remainders of loops.
        let of_q = if L::IS_FIXED { sizes[0] } else { r_q.as_ref().len() };
        solver.factor(shift, (&lin.a_q, &lin.a_v), sizes);
        let Attempt { end: State { q, v, .. }, .. } = &mut *attempt;
        copy(q, &from.q);
        copy(v, &from.v);
        for i in 0..STAGES {
            if (1..=5).contains(&i) {
                copy(q, &from.q);
                copy(v, &from.v);
                let weights = &A[i][..i];
                add_weighted(&mut q.as_mut()[..of_q], weights, &k[..], |k| k.q.as_ref());
                add_weighted(v.as_mut(), weights, &k[..], |k| k.v.as_ref());
            } else if i > 5 {
                add(&mut q.as_mut()[..of_q], k[i - 1].q.as_ref());
                add(v.as_mut(), k[i - 1].v.as_ref());
            }
            let time = (t + NODES[i] * h).min(latest_time);
            let rates = if i == 0 {
                &lin.rates
            } else {
                system.rates(time, q, v, mode, rates);
                &*rates
            };
            copy(r_q, v);
            copy(r_v, &rates.a);
            let weights: [f64; STAGES - 1] = array_from(|j| C[i][j] / h);
            add_weighted(&mut r_q.as_mut()[..of_q], &weights[..i], &k[..], |k| k.q.as_ref());
            add_weighted(r_v.as_mut(), &weights[..i], &k[..], |k| k.v.as_ref());
            if D[i] != 0.0 {
                add_scaled(r_v.as_mut(), h * D[i], lin.a_t.as_ref());
            }
            solver.solve(&lin.a_q, sizes, (r_q, r_v), scratch);
            copy(&mut k[i].q, r_q);
            copy(&mut k[i].v, r_v);
            copy(&mut k[i].z, &rates.g);
        }
        // Stiffly accurate: the last stage plus its increment is the result, and the increment is the error estimate.
        add(q.as_mut(), k[7].q.as_ref());
        add(v.as_mut(), k[7].v.as_ref());
        copy(&mut attempt.error_q, &k[7].q);
        copy(&mut attempt.error_v, &k[7].v);
        // The end of the step is memory for the sum of increments.
        quadratures(&self.k, h, lin, &Z_WEIGHTS[0], &mut self.end);
        copy(&mut attempt.end.z, &self.end.z);
        add(attempt.end.z.as_mut(), from.z.as_ref());
        let Attempt { end, error_q, error_v, .. } = &mut *attempt;
        let error = tolerances.norm((error_q, error_v), (from, end), sizes[1]);
        (self.t0, self.h) = (t, h);
        self.start.copy_from(from);
        self.end.copy_from(end);
        attempt.error = if attempt.end.is_finite() { error } else { f64::NAN };
        attempt.rhs = STAGES as u64 - 1;
    }

    /// Solves (y − u)/τ = f(y) − u̇ for the dense output u, with τ = γ h: then y differs from u by the error of stiff
    /// components, whose forces are large multiples of their rates, and hardly otherwise. The matrix of the corrections is
    /// that of the step.
    #[inline(always)]
    fn refine<Y: System<Layout = L>>(
        &self,
        origin: &StepStart<Y>,
        dense: &Dense<L>,
        theta: f64,
        refinement: &mut Refinement<L>,
    ) -> bool {
        let StepStart { system, mode, linearised: lin, tolerances, t, latest_time, state: from } = *origin;
        let (shift, time) = (1.0 / (self.h * GAMMA), (t + theta * self.h).min(latest_time));
        let sizes = [system.second_order_count(), system.coordinate_count()];
        let (m, n) = (sizes[0], self.scratch.as_ref().len());
        let Refinement { state, start, slope, rates, q, v, scratch } = refinement;
        dense.write(theta, start);
        dense.derivative(theta, slope);
        state.copy_from(start);
        let mut previous = f64::INFINITY;
        for _ in 0..MAX_REFINEMENTS {
            system.rates(time, &state.q, &state.v, mode, rates);
            copy(q, &state.v);
            copy(v, &rates.a);
            for i in 0..m {
                q[i] -= slope.q[i] + shift * (state.q[i] - start.q[i]);
            }
            for i in 0..n {
                v[i] -= slope.v[i] + shift * (state.v[i] - start.v[i]);
            }
            self.solver.solve(&lin.a_q, sizes, (q, v), scratch);
            add(state.q.as_mut(), q.as_ref());
            add(state.v.as_mut(), v.as_ref());
            let (mut largest, mut change) = (f64::MIN_POSITIVE, 0.0_f64);
            for i in 0..state.z.as_ref().len() {
                largest = largest.max(rates.g[i].abs());
                let by_state = dot(&lin.g_q[i], q.as_ref()) + dot(&lin.g_v[i], v.as_ref());
                change = change.max(by_state.abs());
                // Quadratures follow the same equation, so that impulses stay equal to changes of momentum.
                state.z[i] = start.z[i] + (rates.g[i] + by_state - slope.z[i]) / shift;
            }
            let norm = tolerances.norm((q, v), (from, state), sizes[1]);
            let error = (norm / REFINED_ERROR).max(change / (REFINED_FORCE_ERROR * largest));
            // The error that remains after linear convergence.
            let remaining = if previous.is_finite() { error * error / (previous - error).max(0.0) } else { error };
            if remaining <= 1.0 && state.is_finite() {
                return true;
            }
            previous = error;
        }
        false
    }

    fn dense(&self, linearised: Option<&Linearised<L>>, dense: &mut Dense<L>) {
        (dense.t0, dense.h, dense.terms) = (self.t0, self.h, IMPLICIT_TERMS);
        dense.start.copy_from(&self.start);
        dense.end.copy_from(&self.end);
        for i in 0..IMPLICIT_TERMS {
            let d = &mut dense.d[i];
            match linearised {
                Some(linearised) => quadratures(&self.k, self.h, linearised, &Z_WEIGHTS[i + 1], d),
                None => d.z.as_mut().fill(0.0),
            }
            d.q.as_mut().fill(0.0);
            d.v.as_mut().fill(0.0);
            add_weighted(d.q.as_mut(), &H[i], &self.k, |k| k.q.as_ref());
            add_weighted(d.v.as_mut(), &H[i], &self.k, |k| k.v.as_ref());
        }
    }

    #[inline(always)]
    fn dense_positions(&self, d: &mut [VectorOf<L>; DENSE_TERMS]) -> usize {
        for i in 0..IMPLICIT_TERMS {
            d[i].as_mut().fill(0.0);
            add_weighted(d[i].as_mut(), &H[i], &self.k, |k| k.q.as_ref());
        }
        IMPLICIT_TERMS
    }
}

/// Weights of the quadratures' rates, as parts of a step: of the result, and of the three terms of dense output.
///
/// The increments k of a quadrature satisfy (1/γ I − C) k = h r for its rates r (with derivative terms), so that a sum wᵀ k
/// is h times the sum of r with the weights x of (1/γ I − C)ᵀ x = w. They are rounded from the exact solution: an error of
/// 1e-13 would be visible in the balance of energy.
#[rustfmt::skip]
const Z_WEIGHTS: [[f64; STAGES]; 4] = [
    [0.12236007991300805, 0.050238881884186654, 1.3238392208663683, 1.2643883758622312, -0.7904031855871827, -0.9680932754194287, -0.21426766071346695, 0.21193756319429014],
    [0.8232744916805105, -0.3181483349120232, -0.16922330104086536, 0.049879453396321126, -0.1983179197726122, -0.3148814828769921, 0.1638750616770419, -0.03645796815138229],
    [0.6726085201966632, 1.3128972079521062, -9.467244336394264, -12.924520918142036, 9.002714541842755, 11.404611057341922, 1.4210850083209665, -1.4221510811179898],
    [-1.402518520693367, -0.9860299407499562, 11.006871867857456, 14.112585514422289, -9.574969612795115, -12.076626078349426, -2.1142228286973404, 1.0349095990054304],
];

pub(crate) const STAGES: usize = 8;

pub const GAMMA: f64 = 0.21193756319429014;

/// Weights of the stage increments. Rows 7 and 8 and the result repeat row 6, with a unit weight for each later stage.
pub const A: [[f64; 5]; 6] = [
    [0.0; 5],
    [3.0, 0.0, 0.0, 0.0, 0.0],
    [2.849394379747939, 0.45842242204463923, 0.0, 0.0, 0.0],
    [-6.954028509809101, 2.489845061869568, -10.358996098473584, 0.0, 0.0],
    [2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641, 0.0],
    [-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946],
];

pub const C: [[f64; 7]; STAGES] = [
    [0.0; 7],
    [-14.155112264123755, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [-17.97296035885952, -2.859693295451294, 0.0, 0.0, 0.0, 0.0, 0.0],
    [147.12150275711716, -1.41221402718213, 71.68940251302358, 0.0, 0.0, 0.0, 0.0],
    [165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306, 0.0, 0.0, 0.0],
    [24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471, 0.0, 0.0],
    [
        30.91273214028599,
        -3.1208243349937974,
        77.79954646070892,
        34.28646028294783,
        -19.097331116725623,
        -28.087943162872662,
        0.0,
    ],
    [
        37.80277123390563,
        -3.2571969029072276,
        112.26918849496327,
        66.9347231244047,
        -40.06618937091002,
        -54.66780262877968,
        -9.48861652309627,
    ],
];

/// Abscissae cᵢ.
pub(crate) const NODES: [f64; STAGES] =
    [0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1.0, 1.0, 1.0];

/// Weights dᵢ of ∂f/∂t.
pub const D: [f64; STAGES] = [
    0.21193756319429014,
    -0.42387512638858027,
    -0.3384627126235924,
    1.8046452872882734,
    2.325825639765069,
    0.0,
    0.0,
    0.0,
];

/// Dense output of order 4.
pub const H: [[f64; STAGES]; 3] = [
    [
        25.948786856663858,
        -2.5579724845846235,
        10.433815404888879,
        -2.3679251022685204,
        0.524948541321073,
        1.1241088310450404,
        0.4272876194431874,
        -0.17202221070155493,
    ],
    [
        -9.91568850695171,
        -0.9689944594115154,
        3.0438037242978453,
        -24.495224566215796,
        20.176138334709044,
        15.98066361424651,
        -6.789040303419874,
        -6.710236069923372,
    ],
    [
        11.419903575922262,
        2.8879645146136994,
        72.92137995996029,
        80.12511834622643,
        -52.072871366152654,
        -59.78993625266729,
        -0.15582684282751913,
        4.883087185713722,
    ],
];
