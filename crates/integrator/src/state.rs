//! Coordinates and rates, their dense output within a step, observers and the cost of an integration.

use crate::numeric::array_from;

/// Coordinates, their rates, and quadratures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<const N: usize, const Z: usize> {
    pub q: [f64; N],
    pub v: [f64; N],
    pub z: [f64; Z],
}

impl<const N: usize, const Z: usize> State<N, Z> {
    pub fn is_finite(&self) -> bool {
        // On slices, so that it is compiled once.
        let finite = |all: &[f64]| all.iter().all(|x| x.is_finite());
        finite(&self.q) && finite(&self.v) && finite(&self.z)
    }
}

/// y(Θ) = y₀ + Θ (y₁ − y₀) + Θ (1 − Θ) (d₁ + Θ (d₂ + Θ d₃)) on t₀ + Θ h, Θ in 0…1.
#[derive(Clone, Copy, Debug)]
pub struct Dense<const N: usize, const Z: usize> {
    pub t0: f64,
    pub h: f64,
    pub start: State<N, Z>,
    pub end: State<N, Z>,
    pub d: [State<N, Z>; 3],
}

impl<const N: usize, const Z: usize> Dense<N, Z> {
    /// State at the fraction `theta` of the step.
    #[inline(always)]
    pub fn evaluate(&self, theta: f64) -> State<N, Z> {
        let (q, v) = self.motion(theta);
        let [a, b, c] = &self.d;
        let z = array_from(|i| blend(theta, self.start.z[i], self.end.z[i], [a.z[i], b.z[i], c.z[i]]));
        State { q, v, z }
    }

    /// Coordinates and rates at the fraction `theta` of the step.
    #[inline(always)]
    pub(crate) fn motion(&self, theta: f64) -> ([f64; N], [f64; N]) {
        let [a, b, c] = &self.d;
        (
            array_from(|i| blend(theta, self.start.q[i], self.end.q[i], [a.q[i], b.q[i], c.q[i]])),
            array_from(|i| blend(theta, self.start.v[i], self.end.v[i], [a.v[i], b.v[i], c.v[i]])),
        )
    }

    /// Coordinates over the step.
    pub(crate) fn positions(&self) -> DensePositions<'_, N> {
        let [a, b, c] = &self.d;
        DensePositions { start: &self.start.q, end: &self.end.q, d: [a.q, b.q, c.q], step_s: self.h }
    }

    /// Time derivative of the state at the fraction `theta` of the step.
    #[inline(always)]
    pub(crate) fn derivative(&self, theta: f64) -> State<N, Z> {
        let (bump, slope, inverse) = (theta * (1.0 - theta), 1.0 - 2.0 * theta, 1.0 / self.h);
        let blend = |y0: f64, y1: f64, d: [f64; 3]| {
            let bumps = slope * (d[0] + theta * (d[1] + theta * d[2])) + bump * (d[1] + 2.0 * theta * d[2]);
            inverse * ((y1 - y0) + bumps)
        };
        let [a, b, c] = &self.d;
        State {
            q: array_from(|i| blend(self.start.q[i], self.end.q[i], [a.q[i], b.q[i], c.q[i]])),
            v: array_from(|i| blend(self.start.v[i], self.end.v[i], [a.v[i], b.v[i], c.v[i]])),
            z: array_from(|i| blend(self.start.z[i], self.end.z[i], [a.z[i], b.z[i], c.z[i]])),
        }
    }
}

/// y₀ + Θ (y₁ − y₀) + Θ (1 − Θ) (d₁ + Θ (d₂ + Θ d₃)).
#[inline(always)]
fn blend(theta: f64, y0: f64, y1: f64, d: [f64; 3]) -> f64 {
    y0 + theta * (y1 - y0) + theta * (1.0 - theta) * (d[0] + theta * (d[1] + theta * d[2]))
}

/// The coordinates of [`Dense`] alone.
pub(crate) struct DensePositions<'a, const N: usize> {
    pub start: &'a [f64; N],
    pub end: &'a [f64; N],
    pub d: [[f64; N]; 3],
    pub step_s: f64,
}

impl<const N: usize> DensePositions<'_, N> {
    /// Largest first and second derivatives of the first `count` coordinates by Θ between two fractions of the step; the others
    /// are at rest. A polynomial lies within the hull of its Bernstein coefficients, so nothing is sampled.
    #[inline(always)]
    pub fn bounds(&self, from: f64, to: f64, count: usize) -> CoordinateBounds<N> {
        let width = to - from;
        let mut bounds = CoordinateBounds { step_s: self.step_s, width, rate: [0.0; N], acceleration: [0.0; N] };
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
        bounds
    }
}

/// Upper bounds of the first and second derivatives of the coordinates by Θ, over a part of a step.
#[derive(Clone, Copy, Debug)]
pub struct CoordinateBounds<const N: usize> {
    /// Length of the step, s.
    pub step_s: f64,
    /// Length of the part, as a fraction of the step.
    pub width: f64,
    pub rate: [f64; N],
    pub acceleration: [f64; N],
}

/// An accepted step from `t0` to `t1`.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a, const N: usize, const Z: usize> {
    pub t0: f64,
    pub t1: f64,
    /// Step size, exact even if t1 − t0 cancels completely.
    pub h: f64,
    pub start: &'a State<N, Z>,
    pub end: &'a State<N, Z>,
}

/// States inside a step.
pub trait StepTools<const N: usize, const Z: usize> {
    /// Returns the dense output at the fraction `theta` of the step: accurate for angles and rates.
    fn interpolate(&mut self, theta: f64) -> State<N, Z>;

    /// Returns the dense output, corrected so that it gives contact forces as accurately.
    fn refine(&mut self, theta: f64) -> State<N, Z>;

    /// Returns the end of a separate step from the same start, the most accurate state. The force of a stiff damper requires this accuracy,
    /// since it is a large multiple of a tiny rate.
    fn resolve(&mut self, theta: f64) -> State<N, Z>;
}

/// Observer of an integration. `()` ignores everything.
pub trait Observer<const N: usize, const Z: usize, M> {
    /// Called after each accepted step, taken in `mode`. Returning `false` ends the integration.
    fn step(&mut self, step: &Step<N, Z>, mode: &M, tools: &mut dyn StepTools<N, Z>) -> bool;

    /// Called for each event, at the end of the step just reported. Several events may occur at the same time. `mode`
    /// is the mode after the event.
    fn event(&mut self, t: f64, state: &State<N, Z>, index: usize, mode: &M);

    /// Called before the next step, in the state, mode and clearance (of [`EventSet`](super::EventSet)) from which it starts.
    /// Returning `true` suspends the advance, so that other equations can take over by
    /// [`Integration::restart`](super::Integration::restart).
    #[inline(always)]
    fn suspends(&mut self, _state: &State<N, Z>, _mode: &M, _clearance: f64) -> bool {
        false
    }
}

impl<const N: usize, const Z: usize, M> Observer<N, Z, M> for () {
    #[inline(always)]
    fn step(&mut self, _: &Step<N, Z>, _: &M, _: &mut dyn StepTools<N, Z>) -> bool {
        true
    }

    #[inline(always)]
    fn event(&mut self, _: f64, _: &State<N, Z>, _: usize, _: &M) {}
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
