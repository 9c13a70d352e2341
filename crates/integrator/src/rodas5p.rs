//! Rodas5P: linearly implicit, L-stable, stiffly accurate, order 5(4). Coefficients: G. Steinebach, BIT Numer. Math.
//! 63:27 (2023), in the form (1/(hγ) − J) kᵢ = f(t + cᵢh, y + Σ aᵢⱼ kⱼ) + Σ Cᵢⱼ/h kⱼ + h dᵢ ∂f/∂t.

use super::linear::{ShiftedSolver, dot};
use super::method::{Attempt, Method, StepStart};
use super::{Dense, Linearised, State, System};

/// Rodas5P with the stages of its last attempt, for dense output; it has no other history.
#[derive(Clone)]
pub struct Rodas5p<const N: usize, const Z: usize> {
    t0: f64,
    h: f64,
    start: State<N, Z>,
    end: State<N, Z>,
    /// Increments of coordinates and rates, and the rates of the quadratures.
    k: [State<N, Z>; STAGES],
    solver: ShiftedSolver<f64, N>,
}

/// Maximum number of corrections of a state of the dense output. In a cycle of a gripper, 8 of 1,900 states need more.
const MAX_REFINEMENTS: usize = 3;
/// Error of a corrected state, relative to the tolerances of a step: a state in a separate step may have 10.
const REFINED_ERROR: f64 = 1e-3;
/// Error of contact forces in a corrected state, relative to the largest rate of a quadrature: the forces at the ends of
/// steps have 1e-5 to 1e-4 at the default tolerances.
const REFINED_FORCE_ERROR: f64 = 1e-6;

impl<const N: usize, const Z: usize> Rodas5p<N, Z> {
    /// Increments of the quadratures over a step of size `h`: the sum of their rates with these weights. The rates are
    /// linear in the increments of the state, so their derivatives are applied once, to the sum of these increments.
    #[inline(always)]
    fn quadratures(&self, h: f64, lin: &Linearised<N, Z>, weights: &[f64; STAGES]) -> [f64; Z] {
        let mut sum = State { q: [0.0; N], v: [0.0; N], z: [0.0; Z] };
        let mut time_weight = 0.0;
        for i in 0..STAGES {
            axpy(&mut sum, weights[i], &self.k[i]);
            time_weight += weights[i] * D[i];
        }
        let State { q, v, mut z } = sum;
        for m in 0..Z {
            let by_state = dot(&lin.g_q[m], &q, N) + dot(&lin.g_v[m], &v, N);
            z[m] = h * (z[m] + h * time_weight * lin.g_t[m] + by_state);
        }
        z
    }
}

#[inline(always)]
fn axpy<const N: usize, const Z: usize>(y: &mut State<N, Z>, weight: f64, k: &State<N, Z>) {
    for i in 0..N {
        y.q[i] += weight * k.q[i];
        y.v[i] += weight * k.v[i];
    }
    for i in 0..Z {
        y.z[i] += weight * k.z[i];
    }
}

impl<const N: usize, const Z: usize> Method<N, Z> for Rodas5p<N, Z> {
    fn new() -> Self {
        let zero = State { q: [0.0; N], v: [0.0; N], z: [0.0; Z] };
        Self { t0: 0.0, h: 0.0, start: zero, end: zero, k: [zero; STAGES], solver: ShiftedSolver::zero() }
    }

    fn error_order(&self) -> f64 {
        5.0
    }

    fn restart(&mut self) {}

    fn accept_step(&mut self) {}

    fn follow(&mut self, _: &Self) {}

    #[inline(always)]
    fn attempt<Y: System<N, Z>>(&mut self, origin: &StepStart<Y, N, Z>, h: f64) -> Attempt<N, Z> {
        let StepStart { system, mode, linearised: lin, tolerances, t, latest_time, state: from } = *origin;
        let shift = 1.0 / (h * GAMMA);
        let coordinates = system.coordinate_count();
        let Self { k, solver, .. } = self;
        let sizes = [Y::SECOND_ORDER, coordinates];
        solver.factor(shift, (&lin.a_q, &lin.a_v), sizes);
        let (mut q, mut v) = (from.q, from.v);
        for i in 0..STAGES {
            if (1..=5).contains(&i) {
                (q, v) = (from.q, from.v);
                for (j, increment) in k.iter().enumerate().take(i.min(5)) {
                    for n in 0..Y::SECOND_ORDER {
                        q[n] += A[i][j] * increment.q[n];
                    }
                    for n in 0..N {
                        v[n] += A[i][j] * increment.v[n];
                    }
                }
            } else if i > 5 {
                for n in 0..Y::SECOND_ORDER {
                    q[n] += k[i - 1].q[n];
                }
                for n in 0..N {
                    v[n] += k[i - 1].v[n];
                }
            }
            let time = (t + NODES[i] * h).min(latest_time);
            let rates = if i == 0 { lin.rates } else { system.rates(time, &q, &v, mode) };
            let (mut r_q, mut r_v) = (v, rates.a);
            for (j, increment) in k.iter().enumerate().take(i) {
                let weight = C[i][j] / h;
                for n in 0..Y::SECOND_ORDER {
                    r_q[n] += weight * increment.q[n];
                }
                for n in 0..N {
                    r_v[n] += weight * increment.v[n];
                }
            }
            if D[i] != 0.0 {
                for n in 0..N {
                    r_v[n] += h * D[i] * lin.a_t[n];
                }
            }
            let (dq, dv) = solver.solve(&lin.a_q, sizes, (r_q, r_v));
            k[i] = State { q: dq, v: dv, z: rates.g };
        }
        // Stiffly accurate: the last stage plus its increment is the result, and the increment is the error estimate.
        for n in 0..N {
            q[n] += k[7].q[n];
            v[n] += k[7].v[n];
        }
        let [error_q, error_v] = [k[7].q, k[7].v];
        let mut end = State { q, v, z: self.quadratures(h, lin, &Z_WEIGHTS[0]) };
        for m in 0..Z {
            end.z[m] += from.z[m];
        }
        let error = tolerances.norm((&error_q, &error_v), (from, &end), coordinates);
        let error = if end.is_finite() { error } else { f64::NAN };
        (self.t0, self.h, self.start, self.end) = (t, h, *from, end);
        Attempt { error, rhs: STAGES as u64 - 1, end, error_q, error_v }
    }

    /// Solves (y − u)/τ = f(y) − u̇ for the dense output u, with τ = γ h: then y differs from u by the error of stiff
    /// components, whose forces are large multiples of their rates, and hardly otherwise. The matrix of the corrections is
    /// that of the step.
    #[inline(always)]
    fn refine<Y: System<N, Z>>(
        &self,
        origin: &StepStart<Y, N, Z>,
        dense: &Dense<N, Z>,
        theta: f64,
    ) -> Option<State<N, Z>> {
        let StepStart { system, mode, linearised: lin, tolerances, t, latest_time, state: from } = *origin;
        let (shift, time) = (1.0 / (self.h * GAMMA), (t + theta * self.h).min(latest_time));
        let sizes = [Y::SECOND_ORDER, system.coordinate_count()];
        let (start, slope) = (dense.evaluate(theta), dense.derivative(theta));
        let mut state = start;
        let mut previous = f64::INFINITY;
        for _ in 0..MAX_REFINEMENTS {
            let rates = system.rates(time, &state.q, &state.v, mode);
            let (mut r_q, mut r_v) = (state.v, rates.a);
            for n in 0..Y::SECOND_ORDER {
                r_q[n] -= slope.q[n] + shift * (state.q[n] - start.q[n]);
            }
            for n in 0..N {
                r_v[n] -= slope.v[n] + shift * (state.v[n] - start.v[n]);
            }
            let (q, v) = self.solver.solve(&lin.a_q, sizes, (r_q, r_v));
            for n in 0..N {
                state.q[n] += q[n];
                state.v[n] += v[n];
            }
            let (mut largest, mut change) = (f64::MIN_POSITIVE, 0.0_f64);
            for m in 0..Z {
                largest = largest.max(rates.g[m].abs());
                let by_state = dot(&lin.g_q[m], &q, N) + dot(&lin.g_v[m], &v, N);
                change = change.max(by_state.abs());
                // Quadratures follow the same equation, so that impulses stay equal to changes of momentum.
                state.z[m] = start.z[m] + (rates.g[m] + by_state - slope.z[m]) / shift;
            }
            let norm = tolerances.norm((&q, &v), (from, &state), sizes[1]);
            let error = (norm / REFINED_ERROR).max(change / (REFINED_FORCE_ERROR * largest));
            // The error that remains after linear convergence.
            let remaining = if previous.is_finite() { error * error / (previous - error).max(0.0) } else { error };
            if remaining <= 1.0 && state.is_finite() {
                return Some(state);
            }
            previous = error;
        }
        None
    }

    fn dense(&self, linearised: Option<&Linearised<N, Z>>) -> Dense<N, Z> {
        let mut d = [State { q: [0.0; N], v: [0.0; N], z: [0.0; Z] }; 3];
        for i in 0..3 {
            for j in 0..STAGES {
                for n in 0..N {
                    d[i].q[n] += H[i][j] * self.k[j].q[n];
                    d[i].v[n] += H[i][j] * self.k[j].v[n];
                }
            }
            if let Some(linearised) = linearised {
                d[i].z = self.quadratures(self.h, linearised, &Z_WEIGHTS[i + 1]);
            }
        }
        Dense { t0: self.t0, h: self.h, start: self.start, end: self.end, d }
    }

    #[inline(always)]
    fn dense_positions(&self) -> [[f64; N]; 3] {
        let mut d = [[0.0; N]; 3];
        for i in 0..3 {
            for j in 0..STAGES {
                (0..N).for_each(|n| d[i][n] += H[i][j] * self.k[j].q[n]);
            }
        }
        d
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

/// Weights of the stage increments. Rows 7 and 8 and the result are row 6 with a unit weight for every later stage.
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
