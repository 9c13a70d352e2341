//! Dense output of one step, in a common form for both methods.

use super::State;
use crate::numeric::array_from;

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
        let bump = theta * (1.0 - theta);
        let blend =
            |y0: f64, y1: f64, d: [f64; 3]| y0 + theta * (y1 - y0) + bump * (d[0] + theta * (d[1] + theta * d[2]));
        let [a, b, c] = &self.d;
        State {
            q: array_from(|i| blend(self.start.q[i], self.end.q[i], [a.q[i], b.q[i], c.q[i]])),
            v: array_from(|i| blend(self.start.v[i], self.end.v[i], [a.v[i], b.v[i], c.v[i]])),
            z: array_from(|i| blend(self.start.z[i], self.end.z[i], [a.z[i], b.z[i], c.z[i]])),
        }
    }
}
