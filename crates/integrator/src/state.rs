//! Coordinates and rates, their dense output within a step, observers and the cost of an integration.

use super::layout::{Layout, VectorOf, add_scaled, copy};
use crate::numeric::array_from;

/// Coordinates, their rates, and quadratures.
#[derive(Clone, Debug, PartialEq)]
pub struct State<L: Layout> {
    pub q: VectorOf<L>,
    pub v: VectorOf<L>,
    pub z: L::Quadratures,
}

impl<L: Layout> State<L> {
    /// Returns the state in which all numbers are 0.
    pub fn zero(layout: L) -> Self {
        Self { q: layout.vector(0.0), v: layout.vector(0.0), z: layout.zero_quadratures() }
    }

    /// Copies another state, without allocation.
    #[inline(always)]
    pub fn copy_from(&mut self, other: &Self) {
        copy(&mut self.q, &other.q);
        copy(&mut self.v, &other.v);
        copy(&mut self.z, &other.z);
    }

    /// Adds a multiple of another state.
    #[inline(always)]
    pub fn add_scaled(&mut self, factor: f64, other: &Self) {
        add_scaled(self.q.as_mut(), factor, other.q.as_ref());
        add_scaled(self.v.as_mut(), factor, other.v.as_ref());
        add_scaled(self.z.as_mut(), factor, other.z.as_ref());
    }

    pub fn is_finite(&self) -> bool {
        // On slices, so that it is compiled once.
        let finite = |all: &[f64]| all.iter().all(|x| x.is_finite());
        finite(self.q.as_ref()) && finite(self.v.as_ref()) && finite(self.z.as_ref())
    }
}

/// Largest number of terms of a dense output.
pub(crate) const DENSE_TERMS: usize = 6;
/// Number of terms of the implicit methods.
pub(crate) const IMPLICIT_TERMS: usize = 3;

/// Dense output: y(Θ) = y₀ + Θ (y₁ − y₀) + Θ (1 − Θ) (d₁ + Θ (d₂ + Θ (d₃ + …))) at the time t₀ + Θ h, Θ in 0…1.
#[derive(Clone, Debug)]
pub struct Dense<L: Layout> {
    pub t0: f64,
    pub h: f64,
    pub start: State<L>,
    pub end: State<L>,
    /// The terms dᵢ. The first `terms` of them are in use.
    pub d: [State<L>; DENSE_TERMS],
    pub terms: usize,
}

impl<L: Layout> Dense<L> {
    /// Memory for a dense output.
    pub(crate) fn new(layout: L) -> Self {
        let zero = || State::zero(layout);
        let d = std::array::from_fn(|_| zero());
        Self { t0: 0.0, h: 0.0, start: zero(), end: zero(), d, terms: IMPLICIT_TERMS }
    }

    /// Copies another dense output, without allocation.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        (self.t0, self.h, self.terms) = (other.t0, other.h, other.terms);
        self.start.copy_from(&other.start);
        self.end.copy_from(&other.end);
        self.d[..self.terms].iter_mut().zip(&other.d).for_each(|(to, from)| to.copy_from(from));
    }

    /// State at the fraction `theta` of the step.
    pub fn evaluate(&self, theta: f64) -> State<L> {
        let mut state = self.start.clone();
        self.write(theta, &mut state);
        state
    }

    /// Writes the state at the fraction `theta` of the step.
    #[inline(always)]
    pub(crate) fn write(&self, theta: f64, state: &mut State<L>) {
        self.motion(theta, &mut state.q, &mut state.v);
        let d: [&[f64]; DENSE_TERMS] = array_from(|i| self.d[i].z.as_ref());
        blend(theta, state.z.as_mut(), (self.start.z.as_ref(), self.end.z.as_ref(), &d[..self.terms]));
    }

    /// Writes the coordinates and rates at the fraction `theta` of the step.
    #[inline(always)]
    pub(crate) fn motion(&self, theta: f64, q: &mut VectorOf<L>, v: &mut VectorOf<L>) {
        let of_q: [&[f64]; DENSE_TERMS] = array_from(|i| self.d[i].q.as_ref());
        let of_v: [&[f64]; DENSE_TERMS] = array_from(|i| self.d[i].v.as_ref());
        blend(theta, q.as_mut(), (self.start.q.as_ref(), self.end.q.as_ref(), &of_q[..self.terms]));
        blend(theta, v.as_mut(), (self.start.v.as_ref(), self.end.v.as_ref(), &of_v[..self.terms]));
    }

    /// Writes the coordinates at the fraction `theta` of the step, and their derivative, which differs from the dense output
    /// of the rates by its error.
    pub(crate) fn coordinates_with_derivative(&self, theta: f64, q: &mut VectorOf<L>, v: &mut VectorOf<L>) {
        let d: [&[f64]; DENSE_TERMS] = array_from(|i| self.d[i].q.as_ref());
        let path = (self.start.q.as_ref(), self.end.q.as_ref(), &d[..self.terms]);
        blend(theta, q.as_mut(), path);
        self.slope(theta, v.as_mut(), path);
    }

    /// Writes the time derivative of the state at the fraction `theta` of the step.
    #[inline(always)]
    pub(crate) fn derivative(&self, theta: f64, state: &mut State<L>) {
        let terms = self.terms;
        let d: [&[f64]; DENSE_TERMS] = array_from(|i| self.d[i].q.as_ref());
        self.slope(theta, state.q.as_mut(), (self.start.q.as_ref(), self.end.q.as_ref(), &d[..terms]));
        let d: [&[f64]; DENSE_TERMS] = array_from(|i| self.d[i].v.as_ref());
        self.slope(theta, state.v.as_mut(), (self.start.v.as_ref(), self.end.v.as_ref(), &d[..terms]));
        let d: [&[f64]; DENSE_TERMS] = array_from(|i| self.d[i].z.as_ref());
        self.slope(theta, state.z.as_mut(), (self.start.z.as_ref(), self.end.z.as_ref(), &d[..terms]));
    }

    /// Writes the time derivative of a path: its ends and terms.
    #[inline(always)]
    fn slope(&self, theta: f64, slope: &mut [f64], (y0, y1, d): (&[f64], &[f64], &[&[f64]])) {
        let (bump, bump_slope, inverse) = (theta * (1.0 - theta), 1.0 - 2.0 * theta, 1.0 / self.h);
        for (i, slope) in slope.iter_mut().enumerate() {
            // Value and derivative of the polynomial of the terms.
            let (value, derivative) = match d {
                [a, b, c] => (a[i] + theta * (b[i] + theta * c[i]), b[i] + 2.0 * theta * c[i]),
                _ => d
                    .iter()
                    .rev()
                    .fold((0.0, 0.0), |(value, derivative), d| (d[i] + theta * value, value + theta * derivative)),
            };
            *slope = inverse * ((y1[i] - y0[i]) + (bump_slope * value + bump * derivative));
        }
    }

    /// Coordinates over the step.
    pub(crate) fn positions(&self) -> DensePositions<'_> {
        let d = array_from(|i| self.d[i].q.as_ref());
        let (start, end) = (self.start.q.as_ref(), self.end.q.as_ref());
        DensePositions { start, end, d, terms: self.terms, step_s: self.h }
    }
}

/// y = y₀ + Θ (y₁ − y₀) + Θ (1 − Θ) (d₁ + Θ (d₂ + Θ (d₃ + …))).
#[inline(always)]
fn blend(theta: f64, y: &mut [f64], (y0, y1, d): (&[f64], &[f64], &[&[f64]])) {
    // Slices of one length, so that the loops need no bounds checks.
    let n = y.len();
    let (y0, y1) = (&y0[..n], &y1[..n]);
    let bump = theta * (1.0 - theta);
    if let [d1, d2, d3] = d {
        let (d1, d2, d3) = (&d1[..n], &d2[..n], &d3[..n]);
        for i in 0..n {
            y[i] = y0[i] + theta * (y1[i] - y0[i]) + bump * (d1[i] + theta * (d2[i] + theta * d3[i]));
        }
    } else {
        for i in 0..n {
            let terms = d.iter().rev().fold(0.0, |sum, d| d[i] + theta * sum);
            y[i] = y0[i] + theta * (y1[i] - y0[i]) + bump * terms;
        }
    }
}

/// The coordinates of [`Dense`] alone.
pub(crate) struct DensePositions<'a> {
    pub start: &'a [f64],
    pub end: &'a [f64],
    pub d: [&'a [f64]; DENSE_TERMS],
    pub terms: usize,
    pub step_s: f64,
}

impl DensePositions<'_> {
    /// Bounds the first and second derivatives with respect to Θ of the first `count` coordinates between two fractions
    /// of the step; the other coordinates are at rest. A polynomial lies within the hull of its Bernstein coefficients,
    /// so nothing is sampled.
    #[inline(always)]
    pub fn bounds<L: Layout>(&self, [from, to]: [f64; 2], count: usize, bounds: &mut CoordinateBounds<L>) {
        let width = to - from;
        (bounds.step_s, bounds.width) = (self.step_s, width);
        if self.terms != IMPLICIT_TERMS {
            for n in 0..count {
                (bounds.rate[n], bounds.acceleration[n]) = self.largest_derivatives(n, [from, to]);
            }
            return;
        }
        let [a, b, c, ..] = &self.d;
        for n in 0..count {
            // Coefficients of Θ to Θ⁴.
            let (c1, c2) = (self.end[n] - self.start[n] + a[n], b[n] - a[n]);
            let (c3, c4) = (c[n] - b[n], -c[n]);
            let rate = |x: f64| c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4)));
            let acceleration = |x: f64| 2.0 * c2 + x * (6.0 * c3 + x * (12.0 * c4));
            let ([r0, r3], [a0, a2]) = ([from, to].map(rate), [from, to].map(acceleration));
            let (r1, r2) = (r0 + width / 3.0 * a0, r3 - width / 3.0 * a2);
            let a1 = a0 + 0.5 * width * (6.0 * c3 + 24.0 * c4 * from);
            bounds.rate[n] = r0.abs().max(r1.abs()).max(r2.abs().max(r3.abs()));
            bounds.acceleration[n] = a0.abs().max(a1.abs()).max(a2.abs());
        }
    }

    /// [`DensePositions::bounds`] of one coordinate with all terms.
    fn largest_derivatives(&self, n: usize, [from, to]: [f64; 2]) -> (f64, f64) {
        // Coefficients of the first derivative.
        let mut rate = [0.0; DENSE_TERMS + 1];
        for (power, coefficient) in rate.iter_mut().enumerate() {
            let term = |index: usize| self.d.get(index).map_or(0.0, |d| d[n]);
            let before = if power == 0 { self.start[n] - self.end[n] } else { term(power - 1) };
            *coefficient = (power + 1) as f64 * (term(power) - before);
        }
        let acceleration: [f64; DENSE_TERMS] = array_from(|power| (power + 1) as f64 * rate[power + 1]);
        (largest_coefficient(rate, [from, to]), largest_coefficient(acceleration, [from, to]))
    }
}

/// Largest Bernstein coefficient of a polynomial between two points, from its coefficients by power.
fn largest_coefficient<const N: usize>(mut by_power: [f64; N], [from, to]: [f64; 2]) -> f64 {
    // Taylor coefficients about the first point, by the width (Horner's scheme).
    for lowest in 0..N {
        for power in (lowest..N - 1).rev() {
            by_power[power] += from * by_power[power + 1];
        }
    }
    let mut scale = 1.0;
    for (power, coefficient) in by_power.iter_mut().enumerate() {
        // Divided by the binomial coefficient of the power.
        *coefficient *= scale;
        scale *= (to - from) * (power + 1) as f64 / (N - 1 - power).max(1) as f64;
    }
    // Sums of differences: the coefficient i is Σ C(i, j) of these.
    for lowest in 1..N {
        for index in (lowest..N).rev() {
            by_power[index] += by_power[index - 1];
        }
    }
    by_power.into_iter().fold(0.0, |largest, coefficient| largest.max(coefficient.abs()))
}

/// Upper bounds of the first and second derivatives of the coordinates with respect to Θ, over a part of a step.
#[derive(Clone, Debug)]
pub struct CoordinateBounds<L: Layout> {
    /// Length of the step, s.
    pub step_s: f64,
    /// Length of the part, as a fraction of the step.
    pub width: f64,
    pub rate: VectorOf<L>,
    pub acceleration: VectorOf<L>,
}

impl<L: Layout> CoordinateBounds<L> {
    /// Returns the bounds of a system at rest.
    pub fn at_rest(layout: L) -> Self {
        Self { step_s: 0.0, width: 0.0, rate: layout.vector(0.0), acceleration: layout.vector(0.0) }
    }
}

/// An accepted step from `t0` to `t1`.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a, L: Layout> {
    pub t0: f64,
    pub t1: f64,
    /// Step size, exact even if t1 − t0 cancels completely.
    pub h: f64,
    pub start: &'a State<L>,
    pub end: &'a State<L>,
}

/// Tools that evaluate states inside a step.
pub trait StepTools<L: Layout> {
    /// Returns the dense output at the fraction `theta` of the step. It is accurate for angles and rates.
    fn interpolate(&mut self, theta: f64) -> &State<L>;

    /// Returns the dense output, corrected so that it also gives accurate contact forces.
    fn refine(&mut self, theta: f64) -> &State<L>;

    /// Like [`StepTools::refine`], but without the quadratures, whose values are then unspecified. Forces do not depend
    /// on them.
    fn refine_motion(&mut self, theta: f64) -> &State<L>;

    /// Returns the most accurate state: the end of a separate step from the same start. The force of a stiff damper
    /// requires this accuracy, because it is a large multiple of a tiny rate.
    fn resolve(&mut self, theta: f64) -> &State<L>;
}

/// Observer of an integration. `()` ignores everything.
pub trait Observer<L: Layout, M> {
    /// Called after each accepted step, taken in `mode`. Returning `false` ends the integration.
    fn step(&mut self, step: &Step<L>, mode: &M, tools: &mut dyn StepTools<L>) -> bool;

    /// Called for each event, at the end of the step just reported. Several events may occur at the same time. `mode`
    /// is the mode after the event.
    fn event(&mut self, t: f64, state: &State<L>, index: usize, mode: &M);

    /// Called before the next step. State, mode and clearance (of [`EventSet`](super::EventSet)) are those from which
    /// it starts. Returning `true` suspends the advance, so that other equations can take over with
    /// [`Integration::restart`](super::Integration::restart).
    #[inline(always)]
    fn suspends(&mut self, _state: &State<L>, _mode: &M, _clearance: f64) -> bool {
        false
    }
}

impl<L: Layout, M> Observer<L, M> for () {
    #[inline(always)]
    fn step(&mut self, _: &Step<L>, _: &M, _: &mut dyn StepTools<L>) -> bool {
        true
    }

    #[inline(always)]
    fn event(&mut self, _: f64, _: &State<L>, _: usize, _: &M) {}
}

/// Cost of an integration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    pub steps: u64,
    /// Attempts rejected by the error estimate, made to locate an event, or shortened before a singularity.
    pub rejected: u64,
    /// Right-hand-side evaluations, without those requested by an observer.
    pub rhs: u64,
    pub jacobians: u64,
    pub events: u64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Fixed;

    /// The bounds of a dense output with all its terms contain its derivatives, and are attained where these are monotonic.
    #[test]
    fn bounds_of_long_polynomials_contain_their_derivatives() {
        let mut dense: Dense<Fixed<1, 0>> = Dense::new(Fixed);
        (dense.h, dense.terms, dense.end.q) = (2.0, DENSE_TERMS, [0.7]);
        for (d, value) in dense.d.iter_mut().zip([0.3, -1.1, 0.8, 2.0, -0.6, -1.7]) {
            d.q = [value];
        }
        let mut bounds = CoordinateBounds::at_rest(Fixed::<1, 0>);
        let rate_at = |theta: f64| {
            let mut state = State::zero(Fixed);
            dense.derivative(theta, &mut state);
            dense.h * state.q[0]
        };
        for (from, to) in [(0.0, 1.0), (0.0, 0.5), (0.3, 0.31), (0.9, 1.0)] {
            dense.positions().bounds([from, to], 1, &mut bounds);
            let at = |i: i32| from + f64::from(i) / 200.0 * (to - from);
            let rates: Vec<f64> = (0..=200).map(|i| rate_at(at(i))).collect();
            let step = 1e-5;
            let largest = rates.iter().fold(0.0_f64, |largest, rate| largest.max(rate.abs()));
            let acceleration = |theta: f64| (rate_at(theta + step) - rate_at(theta - step)) / (2.0 * step);
            let steepest = (0..=200).map(|i| acceleration(at(i)).abs()).fold(0.0, f64::max);
            assert!(bounds.rate[0] >= largest * (1.0 - 1e-9), "{from} to {to}: {} {largest}", bounds.rate[0]);
            assert!(bounds.acceleration[0] >= steepest * (1.0 - 1e-6), "{from} to {to}");
            if to - from < 0.02 {
                assert!(bounds.rate[0] < 1.01 * largest && bounds.acceleration[0] < 1.05 * steepest, "{from} to {to}");
            }
        }
        // A value by its derivative.
        let sum: f64 = (0..1000).map(|i| rate_at((f64::from(i) + 0.5) / 1000.0)).sum::<f64>() / 1000.0;
        assert!((sum - 0.7).abs() < 1e-5, "{sum}");
    }
}
