//! Rodas5P: linearly implicit, L-stable, stiffly accurate, order 5(4) (Steinebach 2023).

use super::linear::{MAX_DENSE_SIZE, ShiftedSolver};
use super::method::{Attempt, Method, StepStart};
use super::tableau::{A, C, D, GAMMA, H, NODES, STAGES};
use super::{Dense, State, System};
use crate::numeric::array_from;

/// Rodas5P with the stages of its last attempt, for dense output; it has no other history.
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
