//! Rodas5P: linearly implicit, L-stable, stiffly accurate, order 5(4). Coefficients: G. Steinebach, BIT Numer. Math.
//! 63:27 (2023), in the form (1/(hγ) − J) kᵢ = f(t + cᵢh, y + Σ aᵢⱼ kⱼ) + Σ Cᵢⱼ/h kⱼ + h dᵢ ∂f/∂t.

use super::linear::{MAX_DENSE_SIZE, ShiftedSolver};
use super::method::{Attempt, Method, StepStart};
use super::{Dense, State, System};
use crate::numeric::array_from;

/// Rodas5P with the stages of its last attempt, for dense output; it has no other history.
#[derive(Clone)]
pub struct Rodas5p<const N: usize, const Z: usize> {
    t0: f64,
    h: f64,
    start: State<N, Z>,
    end: State<N, Z>,
    k: [State<N, Z>; STAGES],
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
        Self { t0: 0.0, h: 0.0, start: zero, end: zero, k: [zero; STAGES] }
    }

    fn error_order(&self) -> f64 {
        5.0
    }

    fn restart(&mut self) {}

    fn accept_step(&mut self) {}

    #[inline(always)]
    fn attempt<Y: System<N, Z>>(&mut self, origin: &StepStart<Y, N, Z>, h: f64) -> Attempt<N, Z> {
        let StepStart { system, mode, linearised: lin, tolerances, t, latest_time, state: from } = *origin;
        let shift = 1.0 / (h * GAMMA);
        let coordinates = system.coordinate_count();
        let solver = ShiftedSolver::new(shift, &lin.a_q, &lin.a_v, coordinates);
        // Most quadratures of a gripper do not depend on the state in a given mode, so their derivatives are zero.
        let has_derivatives = |m: usize| N <= MAX_DENSE_SIZE || lin.g_q[m] != [0.0; N] || lin.g_v[m] != [0.0; N];
        let depends_on_state: [bool; Z] = array_from(has_derivatives);
        let k = &mut self.k;
        let mut stage = *from;
        for i in 0..STAGES {
            // Quadratures are never fed back: only their increments are needed, not their stage values.
            if (1..=5).contains(&i) {
                stage.q = from.q;
                stage.v = from.v;
                for (j, increment) in k.iter().enumerate().take(i.min(5)) {
                    for n in 0..N {
                        stage.q[n] += A[i][j] * increment.q[n];
                        stage.v[n] += A[i][j] * increment.v[n];
                    }
                }
            } else if i > 5 {
                for n in 0..N {
                    stage.q[n] += k[i - 1].q[n];
                    stage.v[n] += k[i - 1].v[n];
                }
            }
            let time = (t + NODES[i] * h).min(latest_time);
            let rates = if i == 0 { lin.rates } else { system.rates(time, &stage.q, &stage.v, mode) };
            let (mut r_q, mut r_v, mut r_z) = (stage.v, rates.a, rates.g);
            for (j, increment) in k.iter().enumerate().take(i) {
                let weight = C[i][j] / h;
                for n in 0..N {
                    r_q[n] += weight * increment.q[n];
                    r_v[n] += weight * increment.v[n];
                }
                for n in 0..Z {
                    r_z[n] += weight * increment.z[n];
                }
            }
            if D[i] != 0.0 {
                for n in 0..N {
                    r_v[n] += h * D[i] * lin.a_t[n];
                }
                for n in 0..Z {
                    r_z[n] += h * D[i] * lin.g_t[n];
                }
            }
            let (q, v) = solver.solve(r_q, r_v);
            let mut z = r_z;
            for m in 0..Z {
                if depends_on_state[m] {
                    for n in 0..N {
                        z[m] += lin.g_q[m][n] * q[n] + lin.g_v[m][n] * v[n];
                    }
                }
                z[m] *= h * GAMMA;
            }
            k[i] = State { q, v, z };
        }
        // Stiffly accurate: the last stage plus its increment is the result, and the increment is the error estimate.
        let mut end = stage;
        for n in 0..N {
            end.q[n] += k[7].q[n];
            end.v[n] += k[7].v[n];
        }
        for m in 0..Z {
            end.z[m] = from.z[m] + (k[5].z[m] + k[6].z[m] + k[7].z[m]);
            for j in 0..5 {
                end.z[m] += A[5][j] * k[j].z[m];
            }
        }
        let error = tolerances.norm((&k[7].q, &k[7].v), (from, &end), coordinates);
        let error = if end.is_finite() { error } else { f64::NAN };
        (self.t0, self.h, self.start, self.end) = (t, h, *from, end);
        Attempt { error, rhs: STAGES as u64 - 1, end, error_q: k[7].q, error_v: k[7].v }
    }

    fn dense(&self) -> Dense<N, Z> {
        let mut d = [State { q: [0.0; N], v: [0.0; N], z: [0.0; Z] }; 3];
        for i in 0..3 {
            for j in 0..STAGES {
                axpy(&mut d[i], H[i][j], &self.k[j]);
            }
        }
        Dense { t0: self.t0, h: self.h, start: self.start, end: self.end, d }
    }
}

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
