//! Radau IIA of order 5 (Hairer & Wanner, Solving ODEs II, IV.8): three implicit stages, simplified Newton on the
//! transformed system, filtered error estimate.

use num_complex::Complex64;

use super::layout::{Layout, VectorOf, add, add_scaled, copy};
use super::linear::{ShiftedSolver, Sizes};
use super::method::{Attempt, Method, StepStart};
use super::state::{DENSE_TERMS, IMPLICIT_TERMS};
use super::{Dense, Linearised, Rates, State, System};
use crate::numeric::elementary::{cbrt, powi};

/// Largest number of iterations of Newton's method. RADAU5 allows 7 with a looser criterion; here the iteration goes on to
/// [`NEWTON_TOLERANCE`].
const MAX_NEWTON: usize = 12;

/// Returns the abscissae and the Runge–Kutta matrix of Radau IIA of order 5. The last row of the matrix contains the
/// weights.
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

/// Coordinates and rates of one stage: increments relative to the state at the start of the step, or their derivatives.
#[derive(Clone, Debug)]
struct Stage<L: Layout> {
    q: VectorOf<L>,
    v: VectorOf<L>,
}

/// The three stages of a step.
type Stages<L> = [Stage<L>; 3];

fn zero_stages<L: Layout>(layout: L) -> Stages<L> {
    std::array::from_fn(|_| Stage { q: layout.vector(0.0), v: layout.vector(0.0) })
}

/// Radau IIA with the stages of the last step, which give the initial guess of the next stages.
#[derive(Clone)]
pub struct Radau5<L: Layout> {
    coefficients: Coefficients,
    /// The last accepted step, if `has_last`.
    last: Dense<L>,
    has_last: bool,
    candidate: Dense<L>,
    is_restarted: bool,
    memory: Memory<L>,
}

/// Memory of an attempt.
#[derive(Clone)]
struct Memory<L: Layout> {
    real: ShiftedSolver<f64, L>,
    pair: ShiftedSolver<Complex64, L>,
    /// Increments of the stages, and their transformed values.
    z: Stages<L>,
    w: Stages<L>,
    /// Corrections of the transformed values.
    dw: Stages<L>,
    /// Right-hand sides at the stages: rates of the coordinates and of the rates, and of the quadratures.
    f: Stages<L>,
    rates: [Rates<L>; 3],
    /// Transformed right-hand sides.
    tf: Stages<L>,
    complex_q: L::Vector<Complex64>,
    complex_v: L::Vector<Complex64>,
    complex_scratch: L::Vector<Complex64>,
    scratch: VectorOf<L>,
    /// A state.
    q: VectorOf<L>,
    v: VectorOf<L>,
}

/// w₁ a + w₂ b + w₃ c.
#[inline(always)]
fn weighted_sum(w: &[f64; 3], [a, b, c]: [&[f64]; 3], sum: &mut [f64]) {
    let n = sum.len();
    let (a, b, c) = (&a[..n], &b[..n], &c[..n]);
    for i in 0..n {
        sum[i] = w[0] * a[i] + w[1] * b[i] + w[2] * c[i];
    }
}

#[inline]
fn weighted_stages<L: Layout>(w: &[f64; 3], [a, b, c]: &Stages<L>, sum: &mut Stage<L>) {
    weighted_sum(w, [a.q.as_ref(), b.q.as_ref(), c.q.as_ref()], sum.q.as_mut());
    weighted_sum(w, [a.v.as_ref(), b.v.as_ref(), c.v.as_ref()], sum.v.as_mut());
}

fn transform<L: Layout>(m: &[[f64; 3]; 3], z: &Stages<L>, transformed: &mut Stages<L>) {
    m.iter().zip(transformed).for_each(|(row, sum)| weighted_stages(row, z, sum));
}

impl<L: Layout> Radau5<L> {
    /// Initial guess of the stages: extrapolation of the last step's collocation polynomial.
    fn predict(&mut self, from: &State<L>, t: f64, h: f64) {
        let Self { coefficients, last, has_last, memory, .. } = self;
        for (c, stage) in coefficients.c.iter().zip(&mut memory.z) {
            let theta = (t + c * h - last.t0) / last.h;
            if *has_last && theta <= 6.0 {
                last.motion(theta, &mut stage.q, &mut stage.v);
                add_scaled(stage.q.as_mut(), -1.0, from.q.as_ref());
                add_scaled(stage.v.as_mut(), -1.0, from.v.as_ref());
            } else {
                stage.q.as_mut().fill(0.0);
                stage.v.as_mut().fill(0.0);
            }
        }
    }

    /// Evaluates the right-hand sides at the stages.
    fn evaluate<Y: System<Layout = L>>(&mut self, origin: &StepStart<Y>, h: f64) {
        let Memory { z, f, rates, q, .. } = &mut self.memory;
        for (i, stage) in z.iter().enumerate() {
            copy(q, &origin.state.q);
            copy(&mut f[i].q, &origin.state.v);
            add(q.as_mut(), stage.q.as_ref());
            add(f[i].q.as_mut(), stage.v.as_ref());
            let time = (origin.t + self.coefficients.c[i] * h).min(origin.latest_time);
            origin.system.rates(time, q, &f[i].q, origin.mode, &mut rates[i]);
            copy(&mut f[i].v, &rates[i].a);
        }
    }

    /// Corrects the transformed stages by one Newton iteration from the right-hand sides; returns the size of the correction.
    #[inline(always)]
    fn correct<Y: System<Layout = L>>(
        &mut self,
        origin: &StepStart<Y>,
        (gamma, shift): (f64, Complex64),
        sizes: Sizes,
    ) -> f64 {
        let StepStart { linearised, tolerances, state: from, .. } = *origin;
        let Memory { real, pair, w, dw, f, tf, complex_q, complex_v, complex_scratch, scratch, .. } = &mut self.memory;
        transform(&self.coefficients.ti, f, tf);
        let [first, second, third] = dw;
        let n = scratch.as_ref().len();
        for i in 0..n {
            first.q[i] = tf[0].q[i] - gamma * w[0].q[i];
            first.v[i] = tf[0].v[i] - gamma * w[0].v[i];
            complex_q[i] = Complex64::new(tf[1].q[i], tf[2].q[i]) - shift * Complex64::new(w[1].q[i], w[2].q[i]);
            complex_v[i] = Complex64::new(tf[1].v[i], tf[2].v[i]) - shift * Complex64::new(w[1].v[i], w[2].v[i]);
        }
        real.solve(&linearised.a_q, sizes, (&mut first.q, &mut first.v), scratch);
        pair.solve(&linearised.a_q, sizes, (complex_q, complex_v), complex_scratch);
        for i in 0..n {
            (second.q[i], third.q[i]) = (complex_q[i].re, complex_q[i].im);
            (second.v[i], third.v[i]) = (complex_v[i].re, complex_v[i].im);
        }
        let size = |stage: &Stage<L>| powi(tolerances.norm((&stage.q, &stage.v), (from, from), sizes[1]), 2);
        ((size(first) + size(second) + size(third)) / 3.0).sqrt()
    }

    /// Size of the rounding errors of a state.
    fn rounding<Y: System<Layout = L>>(&mut self, origin: &StepStart<Y>, coordinates: usize) -> f64 {
        let Memory { q, v, .. } = &mut self.memory;
        let from = origin.state;
        for i in 0..q.as_ref().len() {
            q[i] = 16.0 * f64::EPSILON * from.q[i].abs();
            v[i] = 4.0 * f64::EPSILON * from.v[i].abs();
        }
        origin.tolerances.norm((q, v), (from, from), coordinates)
    }

    /// Solves the stages by Newton's method. Returns whether it converges, with the number of evaluations.
    #[inline(always)]
    fn solve_stages<Y: System<Layout = L>>(
        &mut self,
        origin: &StepStart<Y>,
        h: f64,
        shifts: (f64, Complex64),
        sizes: Sizes,
    ) -> (bool, u64) {
        self.predict(origin.state, origin.t, h);
        transform(&self.coefficients.ti, &self.memory.z, &mut self.memory.w);
        let floor = self.rounding(origin, sizes[1]);
        let (mut previous, mut contraction): (f64, f64) = (0.0, 0.0);
        let mut rhs = 0;
        for iteration in 0..MAX_NEWTON {
            self.evaluate(origin, h);
            rhs += 3;
            let size = self.correct(origin, shifts, sizes);
            if !size.is_finite() {
                return (false, rhs);
            }
            if iteration > 0 {
                let rate = size / previous;
                contraction = if iteration == 1 { rate } else { (rate * contraction).sqrt() };
                if contraction >= 0.99 && size > floor.max(NEWTON_TOLERANCE) {
                    return (false, rhs);
                }
            }
            previous = size;
            let Memory { w, dw, z, .. } = &mut self.memory;
            for (stage, change) in w.iter_mut().zip(&*dw) {
                add(stage.q.as_mut(), change.q.as_ref());
                add(stage.v.as_mut(), change.v.as_ref());
            }
            transform(&self.coefficients.t, w, z);
            let remaining = if iteration == 0 { size } else { size * contraction / (1.0 - contraction).max(0.01) };
            if size == 0.0 || size <= floor || (iteration > 0 && remaining <= NEWTON_TOLERANCE) {
                return (true, rhs);
            }
        }
        (false, rhs)
    }

    /// Writes the error (γ/h − J)⁻¹ (f₀ + Σ eᵢ zᵢ/h) over f₀.
    #[inline(always)]
    fn estimate_error(
        &mut self,
        (a_q, sizes, h): (&L::Square<f64>, Sizes, f64),
        (error_q, error_v): (&mut VectorOf<L>, &mut VectorOf<L>),
    ) {
        let Memory { real, z, dw, scratch, .. } = &mut self.memory;
        let ez = &mut dw[0];
        weighted_stages(&self.coefficients.e, z, ez);
        for i in 0..scratch.as_ref().len() {
            error_q[i] += ez.q[i] / h;
            error_v[i] += ez.v[i] / h;
        }
        real.solve(a_q, sizes, (error_q, error_v), scratch);
    }

    /// Stores the cubic through the start and the three stages, in the common form of dense output (d₃ = 0).
    fn store_candidate(&mut self, t0: f64, h: f64, from: &State<L>, end: &State<L>) {
        let Self {
            coefficients: Coefficients { c, a: weights, .. }, candidate, memory: Memory { z, rates, .. }, ..
        } = self;
        (candidate.t0, candidate.h) = (t0, h);
        candidate.start.copy_from(from);
        candidate.end.copy_from(end);
        // At c₁ and c₂: bump · (d₁ + c d₂) = offset − c · offset₃.
        let reduced = |i: usize, x: f64, last: f64| (x - c[i] * last) / (c[i] * (1.0 - c[i]));
        let solve = |x: [f64; 3]| {
            let (r1, r2) = (reduced(0, x[0], x[2]), reduced(1, x[1], x[2]));
            let d2 = (r2 - r1) / (c[1] - c[0]);
            [r1 - c[0] * d2, d2]
        };
        let [first, second, ..] = &mut candidate.d;
        for n in 0..from.q.as_ref().len() {
            [first.q[n], second.q[n]] = solve([z[0].q[n], z[1].q[n], z[2].q[n]]);
            [first.v[n], second.v[n]] = solve([z[0].v[n], z[1].v[n], z[2].v[n]]);
        }
        for m in 0..from.z.as_ref().len() {
            let offset = |w: &[f64; 3]| h * (w[0] * rates[0].g[m] + w[1] * rates[1].g[m] + w[2] * rates[2].g[m]);
            [first.z[m], second.z[m]] = solve([offset(&weights[0]), offset(&weights[1]), offset(&weights[2])]);
        }
    }
}

/// The Newton iteration ends when its remaining error is this part of the tolerance, or at the level of rounding. RADAU5 stops
/// at 3e-2 at most; a contact force is a large multiple of a small depth or rate.
const NEWTON_TOLERANCE: f64 = 1e-5;

impl<L: Layout> Method<L> for Radau5<L> {
    fn new(layout: L) -> Self {
        let stages = || zero_stages(layout);
        let complex = || layout.vector(Complex64::ZERO);
        Self {
            coefficients: Coefficients::new(),
            last: Dense::new(layout),
            has_last: false,
            candidate: Dense::new(layout),
            is_restarted: true,
            memory: Memory {
                real: ShiftedSolver::zero(layout),
                pair: ShiftedSolver::zero(layout),
                z: stages(),
                w: stages(),
                dw: stages(),
                f: stages(),
                rates: std::array::from_fn(|_| Rates::zero(layout)),
                tf: stages(),
                complex_q: complex(),
                complex_v: complex(),
                complex_scratch: complex(),
                scratch: layout.vector(0.0),
                q: layout.vector(0.0),
                v: layout.vector(0.0),
            },
        }
    }

    /// Order of the filtered error estimate: 4 (Hairer & Wanner IV.8.20).
    fn error_order(&self) -> f64 {
        4.0
    }

    fn restart(&mut self) {
        self.has_last = false;
        self.is_restarted = true;
    }

    fn follow(&mut self, other: &Self) {
        self.last.copy_from(&other.last);
        (self.has_last, self.is_restarted) = (other.has_last, other.is_restarted);
    }

    fn accept_step(&mut self) {
        self.last.copy_from(&self.candidate);
        self.has_last = true;
        self.is_restarted = false;
    }

    fn attempt<Y: System<Layout = L>>(&mut self, origin: &StepStart<Y>, h: f64, attempt: &mut Attempt<L>) {
        let StepStart { system, mode, linearised: lin, tolerances, t, state: from, .. } = *origin;
        let (gamma, alpha, beta) = (self.coefficients.gamma, self.coefficients.alpha, self.coefficients.beta);
        let (gamma, shift) = (gamma / h, Complex64::new(alpha / h, beta / h));
        let sizes = [system.second_order_count(), system.coordinate_count()];
        self.memory.real.factor(gamma, (&lin.a_q, &lin.a_v), sizes);
        self.memory.pair.factor(shift, (&lin.a_q, &lin.a_v), sizes);
        let (converged, evaluations) = self.solve_stages(origin, h, (gamma, shift), sizes);
        (attempt.error, attempt.rhs) = (f64::NAN, evaluations);
        if !converged {
            return;
        }
        self.evaluate(origin, h);
        attempt.rhs += 3;
        let Memory { z, rates, .. } = &self.memory;
        let end = &mut attempt.end;
        end.copy_from(from);
        add(end.q.as_mut(), z[2].q.as_ref());
        add(end.v.as_mut(), z[2].v.as_ref());
        let weights = &self.coefficients.a[2];
        for m in 0..end.z.as_ref().len() {
            end.z[m] += h * (weights[0] * rates[0].g[m] + weights[1] * rates[1].g[m] + weights[2] * rates[2].g[m]);
        }
        if !end.is_finite() {
            return;
        }

        // The error is filtered a second time if it is too large after a restart.
        let Attempt { end, error_q, error_v, .. } = attempt;
        copy(error_q, &from.v);
        copy(error_v, &lin.rates.a);
        self.estimate_error((&lin.a_q, sizes, h), (error_q, error_v));
        let mut error = tolerances.norm((error_q, error_v), (from, end), sizes[1]);
        self.store_candidate(t, h, from, end);
        if error >= 1.0 && self.is_restarted {
            let Memory { q, f, rates, .. } = &mut self.memory;
            copy(q, &from.q);
            copy(&mut f[0].q, &from.v);
            add(q.as_mut(), error_q.as_ref());
            add(f[0].q.as_mut(), error_v.as_ref());
            system.rates(t, q, &f[0].q, mode, &mut rates[0]);
            attempt.rhs += 1;
            copy(error_q, &f[0].q);
            copy(error_v, &rates[0].a);
            self.estimate_error((&lin.a_q, sizes, h), (error_q, error_v));
            error = tolerances.norm((error_q, error_v), (from, end), sizes[1]);
        }
        attempt.error = error;
    }

    fn dense(&self, _: Option<&Linearised<L>>, dense: &mut Dense<L>) {
        dense.copy_from(&self.candidate);
    }

    #[inline(always)]
    fn dense_positions(&self, d: &mut [VectorOf<L>; DENSE_TERMS]) -> usize {
        d[..IMPLICIT_TERMS].iter_mut().zip(&self.candidate.d).for_each(|(to, from)| copy(to, &from.q));
        IMPLICIT_TERMS
    }
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
