//! Radau IIA of order 5 (Hairer & Wanner, Solving ODEs II, IV.8): three implicit stages, simplified Newton on the
//! transformed system, filtered error estimate.

use num_complex::Complex64;

use super::linear::ShiftedSolver;
use super::method::{Attempt, Method, StepStart};
use super::{Dense, Linearised, Rates, State, System};
use crate::numeric::array_from;
use crate::numeric::elementary::{cbrt, powi};

const MAX_NEWTON: usize = 12;

/// Abscissae and Runge–Kutta matrix of Radau IIA of order 5; the last row of the matrix contains the weights.
pub fn radau5_tableau() -> ([f64; 3], [[f64; 3]; 3]) {
    let s6 = 6f64.sqrt();
    let c = [(4.0 - s6) / 10.0, (4.0 + s6) / 10.0, 1.0];
    let a = [
        [(88.0 - 7.0 * s6) / 360.0, (296.0 - 169.0 * s6) / 1800.0, (-2.0 + 3.0 * s6) / 225.0],
        [(296.0 + 169.0 * s6) / 1800.0, (88.0 + 7.0 * s6) / 360.0, (-2.0 - 3.0 * s6) / 225.0],
        [(16.0 - s6) / 36.0, (16.0 + s6) / 36.0, 1.0 / 9.0],
    ];
    (c, a)
}

/// Coefficients of the method, all from closed forms.
#[derive(Clone, Copy, Debug)]
struct Coefficients {
    /// Abscissae c₁, c₂, c₃ = 1.
    c: [f64; 3],
    /// Runge–Kutta matrix.
    a: [[f64; 3]; 3],
    /// Real eigenvalue of A⁻¹.
    gamma: f64,
    /// Real part of the complex eigenvalues α ± iβ of A⁻¹.
    alpha: f64,
    /// Imaginary part of the complex eigenvalues.
    beta: f64,
    /// T of A⁻¹ T = T Λ.
    t: [[f64; 3]; 3],
    /// Inverse of T.
    ti: [[f64; 3]; 3],
    /// Weights of the error estimate.
    e: [f64; 3],
}

impl Coefficients {
    fn new() -> Self {
        let (s6, (c, a)) = (6f64.sqrt(), radau5_tableau());
        // Eigenvalues of A: the roots of 60 μ³ − 36 μ² + 9 μ − 1. A⁻¹ has their reciprocals.
        let (cube9, cube81) = (cbrt(9.0), cbrt(81.0));
        let real_root = (6.0 + cube81 - cube9) / 30.0;
        let pair_root = Complex64::new((12.0 - cube81 + cube9) / 60.0, (cube81 + cube9) * 3f64.sqrt() / 60.0);
        let (gamma, pair_inverse) = (1.0 / real_root, pair_root.conj().inv());
        let (alpha, beta) = (pair_inverse.re, pair_inverse.im);
        // Columns of T: an eigenvector of A for 1/γ, then the real and imaginary parts of an eigenvector for 1/(α −
        // iβ). Both span the null space of A − λ I: the cross product of two of its rows, scaled to a last component of
        // 1 (and 1 + 0 i).
        let vector = |lambda: Complex64| -> [Complex64; 3] {
            let row = |i: usize| -> [Complex64; 3] {
                std::array::from_fn(|j| Complex64::from(a[i][j]) - if i == j { lambda } else { 0.0.into() })
            };
            let (p, r) = (row(0), row(1));
            let v = [p[1] * r[2] - p[2] * r[1], p[2] * r[0] - p[0] * r[2], p[0] * r[1] - p[1] * r[0]];
            v.map(|x| x / v[2])
        };
        let real = vector(Complex64::from(real_root));
        let pair = vector(pair_root);
        let t = std::array::from_fn(|i| [real[i].re, pair[i].re, pair[i].im]);
        Self {
            c,
            a,
            gamma,
            alpha,
            beta,
            t,
            ti: inverse3(&t),
            e: [-(13.0 + 7.0 * s6) / 3.0, (-13.0 + 7.0 * s6) / 3.0, -1.0 / 3.0],
        }
    }
}

fn inverse3(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let minor = |i: usize, j: usize| {
        let (r, s) = ((i + 1) % 3, (i + 2) % 3);
        let (k, l) = ((j + 1) % 3, (j + 2) % 3);
        m[r][k] * m[s][l] - m[r][l] * m[s][k]
    };
    let det: f64 = (0..3).map(|j| m[0][j] * minor(0, j)).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| minor(j, i) / det))
}

/// Increments of a stage relative to the state at the start of the step: coordinates, then rates.
type Stage<const N: usize> = ([f64; N], [f64; N]);
/// The three stages of a step.
type Stages<const N: usize> = [Stage<N>; 3];

/// Radau IIA with the stages of the last step, which give the initial guess of the next ones.
#[derive(Clone)]
pub struct Radau5<const N: usize, const Z: usize> {
    coefficients: Coefficients,
    last: Option<Dense<N, Z>>,
    candidate: Dense<N, Z>,
    is_restarted: bool,
}

/// w₁ a + w₂ b + w₃ c.
#[inline(always)]
fn weighted_sum<const N: usize>(w: &[f64; 3], [a, b, c]: [&[f64; N]; 3]) -> [f64; N] {
    array_from(|n| w[0] * a[n] + w[1] * b[n] + w[2] * c[n])
}

#[inline]
fn weighted_stages<const N: usize>(w: &[f64; 3], [a, b, c]: &Stages<N>) -> Stage<N> {
    (weighted_sum(w, [&a.0, &b.0, &c.0]), weighted_sum(w, [&a.1, &b.1, &c.1]))
}

fn transform<const N: usize>(m: &[[f64; 3]; 3], z: &Stages<N>) -> Stages<N> {
    [weighted_stages(&m[0], z), weighted_stages(&m[1], z), weighted_stages(&m[2], z)]
}

#[inline(always)]
fn add<const N: usize>(a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    array_from(|n| a[n] + b[n])
}

impl<const N: usize, const Z: usize> Radau5<N, Z> {
    /// Initial guess of the stages: extrapolation of the last step's collocation polynomial.
    fn predict(&self, from: &State<N, Z>, t: f64, h: f64) -> Stages<N> {
        let mut stages = [([0.0; N], [0.0; N]); 3];
        let Some(last) = &self.last else { return stages };
        for (c, stage) in self.coefficients.c.iter().zip(&mut stages) {
            let theta = (t + c * h - last.t0) / last.h;
            if theta <= 6.0 {
                let guess = last.evaluate(theta);
                *stage = (array_from(|n| guess.q[n] - from.q[n]), array_from(|n| guess.v[n] - from.v[n]));
            }
        }
        stages
    }

    /// Right-hand sides at the stages.
    fn evaluate<Y: System<N, Z>>(
        &self,
        origin: &StepStart<Y, N, Z>,
        h: f64,
        z: &Stages<N>,
    ) -> [(Rates<N, Z>, [f64; N]); 3] {
        let at = |i: usize| {
            let (q, v) = (add(&origin.state.q, &z[i].0), add(&origin.state.v, &z[i].1));
            let time = (origin.t + self.coefficients.c[i] * h).min(origin.latest_time);
            (origin.system.rates(time, &q, &v, origin.mode), v)
        };
        [at(0), at(1), at(2)]
    }
}

impl<const N: usize, const Z: usize> Method<N, Z> for Radau5<N, Z> {
    fn new() -> Self {
        let zero = State { q: [0.0; N], v: [0.0; N], z: [0.0; Z] };
        let candidate = Dense { t0: 0.0, h: 0.0, start: zero, end: zero, d: [zero; 3] };
        Self { coefficients: Coefficients::new(), last: None, candidate, is_restarted: true }
    }

    /// Order of the filtered error estimate: 4 (Hairer & Wanner IV.8.20).
    fn error_order(&self) -> f64 {
        4.0
    }

    fn restart(&mut self) {
        self.last = None;
        self.is_restarted = true;
    }

    fn follow(&mut self, other: &Self) {
        (self.last, self.is_restarted) = (other.last, other.is_restarted);
    }

    fn accept_step(&mut self) {
        self.last = Some(self.candidate);
        self.is_restarted = false;
    }

    fn attempt<Y: System<N, Z>>(&mut self, origin: &StepStart<Y, N, Z>, h: f64) -> Attempt<N, Z> {
        let StepStart { system, mode, linearised: lin, tolerances, t, state: from, .. } = *origin;
        let (k, coordinates) = (self.coefficients, system.coordinate_count());
        let (gamma, shift) = (k.gamma / h, Complex64::new(k.alpha / h, k.beta / h));
        let matrices = (&lin.a_q, &lin.a_v);
        let sizes = [Y::SECOND_ORDER, coordinates];
        let (real, pair) = (ShiftedSolver::new(gamma, matrices, sizes), ShiftedSolver::new(shift, matrices, sizes));
        let mut rhs = 0;
        let failed = |rhs| Attempt { error: f64::NAN, rhs, end: *from, error_q: [0.0; N], error_v: [0.0; N] };

        let mut z = self.predict(from, t, h);
        let mut w = transform(&k.ti, &z);
        // The Newton iteration ends when its remaining error is far below the tolerance, or at the level of rounding.
        let newton_tolerance = 1e-5;
        let floor = {
            let eps_q = array_from(|n| 16.0 * f64::EPSILON * from.q[n].abs());
            let eps_v = array_from(|n| 4.0 * f64::EPSILON * from.v[n].abs());
            tolerances.norm((&eps_q, &eps_v), (from, from), coordinates)
        };
        let (mut previous, mut contraction): (f64, f64) = (0.0, 0.0);
        let mut converged = false;
        for iteration in 0..MAX_NEWTON {
            let f = self.evaluate(origin, h, &z);
            rhs += 3;
            let tf = transform(&k.ti, &[(f[0].1, f[0].0.a), (f[1].1, f[1].0.a), (f[2].1, f[2].0.a)]);
            let residual_q = array_from(|n| tf[0].0[n] - gamma * w[0].0[n]);
            let residual_v = array_from(|n| tf[0].1[n] - gamma * w[0].1[n]);
            let (dq1, dv1) = real.solve(&lin.a_q, sizes, (residual_q, residual_v));
            let complex = |a: &[f64; N], b: &[f64; N], wa: &[f64; N], wb: &[f64; N]| -> [Complex64; N] {
                array_from(|n| Complex64::new(a[n], b[n]) - shift * Complex64::new(wa[n], wb[n]))
            };
            let residual_q = complex(&tf[1].0, &tf[2].0, &w[1].0, &w[2].0);
            let residual_v = complex(&tf[1].1, &tf[2].1, &w[1].1, &w[2].1);
            let (dq2, dv2) = pair.solve(&lin.a_q, sizes, (residual_q, residual_v));
            let (re, im) = (|x: &[Complex64; N]| array_from(|n| x[n].re), |x: &[Complex64; N]| array_from(|n| x[n].im));
            let dw: Stages<N> = [(dq1, dv1), (re(&dq2), re(&dv2)), (im(&dq2), im(&dv2))];
            let size = |(q, v): &Stage<N>| powi(tolerances.norm((q, v), (from, from), coordinates), 2);
            let size = ((size(&dw[0]) + size(&dw[1]) + size(&dw[2])) / 3.0).sqrt();
            if !size.is_finite() {
                return failed(rhs);
            }
            if iteration > 0 {
                let rate = size / previous;
                contraction = if iteration == 1 { rate } else { (rate * contraction).sqrt() };
                if contraction >= 0.99 && size > floor.max(newton_tolerance) {
                    return failed(rhs);
                }
            }
            previous = size;
            for i in 0..3 {
                for n in 0..N {
                    w[i].0[n] += dw[i].0[n];
                    w[i].1[n] += dw[i].1[n];
                }
            }
            z = transform(&k.t, &w);
            let remaining = if iteration == 0 { size } else { size * contraction / (1.0 - contraction).max(0.01) };
            if size == 0.0 || size <= floor || (iteration > 0 && remaining <= newton_tolerance) {
                converged = true;
                break;
            }
        }
        if !converged {
            return failed(rhs);
        }

        let stages = self.evaluate(origin, h, &z);
        rhs += 3;
        let offset = |i: usize| {
            let sums = weighted_sum(&k.a[i], [&stages[0].0.g, &stages[1].0.g, &stages[2].0.g]);
            State { q: z[i].0, v: z[i].1, z: array_from(|m| h * sums[m]) }
        };
        let offsets: [State<N, Z>; 3] = [offset(0), offset(1), offset(2)];
        let last = &offsets[2];
        let end = State { q: add(&from.q, &last.q), v: add(&from.v, &last.v), z: add(&from.z, &last.z) };
        if !end.is_finite() {
            return failed(rhs);
        }

        // Error (γ/h − J)⁻¹ (f₀ + Σ eᵢ zᵢ/h), filtered a second time if it is too large after a restart.
        let ez = weighted_stages(&k.e, &z);
        let estimate = |v0: &[f64; N], a0: &[f64; N]| {
            real.solve(&lin.a_q, sizes, (array_from(|n| v0[n] + ez.0[n] / h), array_from(|n| a0[n] + ez.1[n] / h)))
        };
        let (mut eq, mut ev) = estimate(&from.v, &lin.rates.a);
        let mut error = tolerances.norm((&eq, &ev), (from, &end), coordinates);
        if error >= 1.0 && self.is_restarted {
            let (q, v) = (add(&from.q, &eq), add(&from.v, &ev));
            let shifted = system.rates(t, &q, &v, mode);
            rhs += 1;
            (eq, ev) = estimate(&v, &shifted.a);
            error = tolerances.norm((&eq, &ev), (from, &end), coordinates);
        }
        self.candidate = collocation(t, h, from, end, &offsets, &k.c);
        Attempt { error, rhs, end, error_q: eq, error_v: ev }
    }

    fn dense(&self, _: Option<&Linearised<N, Z>>) -> Dense<N, Z> {
        self.candidate
    }

    #[inline(always)]
    fn dense_positions(&self) -> [[f64; N]; 3] {
        let [a, b, c] = &self.candidate.d;
        [a.q, b.q, c.q]
    }
}

/// Returns the cubic through the start and the three stages, in the common form of dense output (d₃ = 0).
fn collocation<const N: usize, const Z: usize>(
    t0: f64,
    h: f64,
    from: &State<N, Z>,
    end: State<N, Z>,
    offsets: &[State<N, Z>; 3],
    c: &[f64; 3],
) -> Dense<N, Z> {
    // At c₁ and c₂: bump · (d₁ + c d₂) = offset − c · offset₃.
    let reduced = |i: usize, x: f64, last: f64| (x - c[i] * last) / (c[i] * (1.0 - c[i]));
    let solve = |x: [f64; 3]| {
        let (r1, r2) = (reduced(0, x[0], x[2]), reduced(1, x[1], x[2]));
        let d2 = (r2 - r1) / (c[1] - c[0]);
        [r1 - c[0] * d2, d2]
    };
    let mut d = [State { q: [0.0; N], v: [0.0; N], z: [0.0; Z] }; 3];
    let [a, b, last] = offsets;
    for n in 0..N {
        [d[0].q[n], d[1].q[n]] = solve([a.q[n], b.q[n], last.q[n]]);
        [d[0].v[n], d[1].v[n]] = solve([a.v[n], b.v[n], last.v[n]]);
    }
    for m in 0..Z {
        [d[0].z[m], d[1].z[m]] = solve([a.z[m], b.z[m], last.z[m]]);
    }
    Dense { t0, h, start: *from, end, d }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// T Λ T⁻¹ = A⁻¹; eigenvalues as Hairer's radau5.f computes them (U1, ALPH, BETA).
    #[test]
    fn transformation_diagonalises_the_inverse_of_a() {
        let k = Coefficients::new();
        assert!((k.gamma - 3.637834252744496).abs() < 1e-14);
        assert!((k.alpha - 2.6810828736277523).abs() < 1e-14);
        assert!((k.beta - 3.0504301992474105).abs() < 1e-14);
        let lambda = [[k.gamma, 0.0, 0.0], [0.0, k.alpha, -k.beta], [0.0, k.beta, k.alpha]];
        let product = |x: &[[f64; 3]; 3], y: &[[f64; 3]; 3]| -> [[f64; 3]; 3] {
            std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|m| x[i][m] * y[m][j]).sum()))
        };
        let inverse = product(&product(&k.t, &lambda), &k.ti);
        let identity = product(&inverse, &k.a);
        for (i, row) in identity.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((value - expected).abs() < 1e-13, "{i} {j}: {value}");
            }
        }
    }
}
