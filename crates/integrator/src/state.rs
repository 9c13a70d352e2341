//! Coordinates and rates, their dense output within a step, observers and the cost of an integration.

use super::layout::{Layout, VectorOf, add_scaled, copy};

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

/// Dense output: y(Θ) = y₀ + Θ (y₁ − y₀) + Θ (1 − Θ) (d₁ + Θ (d₂ + Θ d₃)) at the time t₀ + Θ h, Θ in 0…1.
#[derive(Clone, Debug)]
pub struct Dense<L: Layout> {
    pub t0: f64,
    pub h: f64,
    pub start: State<L>,
    pub end: State<L>,
    pub d: [State<L>; 3],
}

impl<L: Layout> Dense<L> {
    /// Memory for a dense output.
    pub(crate) fn new(layout: L) -> Self {
        let zero = || State::zero(layout);
        Self { t0: 0.0, h: 0.0, start: zero(), end: zero(), d: [zero(), zero(), zero()] }
    }

    /// Copies another dense output, without allocation.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        (self.t0, self.h) = (other.t0, other.h);
        self.start.copy_from(&other.start);
        self.end.copy_from(&other.end);
        self.d.iter_mut().zip(&other.d).for_each(|(to, from)| to.copy_from(from));
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
        let [a, b, c] = &self.d;
        let d = [a.z.as_ref(), b.z.as_ref(), c.z.as_ref()];
        blend(theta, state.z.as_mut(), (self.start.z.as_ref(), self.end.z.as_ref(), d));
    }

    /// Writes the coordinates and rates at the fraction `theta` of the step.
    #[inline(always)]
    pub(crate) fn motion(&self, theta: f64, q: &mut VectorOf<L>, v: &mut VectorOf<L>) {
        let [a, b, c] = &self.d;
        let (of_q, of_v) = (a.q.as_ref(), a.v.as_ref());
        blend(theta, q.as_mut(), (self.start.q.as_ref(), self.end.q.as_ref(), [of_q, b.q.as_ref(), c.q.as_ref()]));
        blend(theta, v.as_mut(), (self.start.v.as_ref(), self.end.v.as_ref(), [of_v, b.v.as_ref(), c.v.as_ref()]));
    }

    /// Writes the coordinates at the fraction `theta` of the step, and their derivative, which differs from the dense output
    /// of the rates by its error.
    pub(crate) fn coordinates_with_derivative(&self, theta: f64, q: &mut VectorOf<L>, v: &mut VectorOf<L>) {
        let [a, b, c] = &self.d;
        let slope = Slope::new(theta, self.h);
        let d = [a.q.as_ref(), b.q.as_ref(), c.q.as_ref()];
        blend(theta, q.as_mut(), (self.start.q.as_ref(), self.end.q.as_ref(), d));
        for i in 0..q.as_ref().len() {
            v[i] = slope.of(self.start.q[i], self.end.q[i], [a.q[i], b.q[i], c.q[i]]);
        }
    }

    /// Writes the time derivative of the state at the fraction `theta` of the step.
    #[inline(always)]
    pub(crate) fn derivative(&self, theta: f64, state: &mut State<L>) {
        let slope = Slope::new(theta, self.h);
        let [a, b, c] = &self.d;
        for i in 0..state.q.as_ref().len() {
            state.q[i] = slope.of(self.start.q[i], self.end.q[i], [a.q[i], b.q[i], c.q[i]]);
        }
        for i in 0..state.v.as_ref().len() {
            state.v[i] = slope.of(self.start.v[i], self.end.v[i], [a.v[i], b.v[i], c.v[i]]);
        }
        for i in 0..state.z.as_ref().len() {
            state.z[i] = slope.of(self.start.z[i], self.end.z[i], [a.z[i], b.z[i], c.z[i]]);
        }
    }

    /// Coordinates over the step.
    pub(crate) fn positions(&self) -> DensePositions<'_> {
        let [a, b, c] = &self.d;
        let d = [a.q.as_ref(), b.q.as_ref(), c.q.as_ref()];
        DensePositions { start: self.start.q.as_ref(), end: self.end.q.as_ref(), d, step_s: self.h }
    }
}

/// Factors of the time derivative of a dense output.
struct Slope {
    theta: f64,
    bump: f64,
    slope: f64,
    inverse: f64,
}

impl Slope {
    #[inline(always)]
    fn new(theta: f64, h: f64) -> Self {
        Self { theta, bump: theta * (1.0 - theta), slope: 1.0 - 2.0 * theta, inverse: 1.0 / h }
    }

    #[inline(always)]
    fn of(&self, y0: f64, y1: f64, d: [f64; 3]) -> f64 {
        let Self { theta, bump, slope, inverse } = *self;
        let bumps = slope * (d[0] + theta * (d[1] + theta * d[2])) + bump * (d[1] + 2.0 * theta * d[2]);
        inverse * ((y1 - y0) + bumps)
    }
}

/// y = y₀ + Θ (y₁ − y₀) + Θ (1 − Θ) (d₁ + Θ (d₂ + Θ d₃)).
#[inline(always)]
fn blend(theta: f64, y: &mut [f64], (y0, y1, [d1, d2, d3]): (&[f64], &[f64], [&[f64]; 3])) {
    // Slices of one length, so that the loop needs no bounds checks.
    let n = y.len();
    let (y0, y1, d1, d2, d3) = (&y0[..n], &y1[..n], &d1[..n], &d2[..n], &d3[..n]);
    let bump = theta * (1.0 - theta);
    for i in 0..n {
        y[i] = y0[i] + theta * (y1[i] - y0[i]) + bump * (d1[i] + theta * (d2[i] + theta * d3[i]));
    }
}

/// The coordinates of [`Dense`] alone.
pub(crate) struct DensePositions<'a> {
    pub start: &'a [f64],
    pub end: &'a [f64],
    pub d: [&'a [f64]; 3],
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
        let [a, b, c] = &self.d;
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
