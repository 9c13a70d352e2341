//! Interpolation between two samples.

use super::{BodyState, Channels, FingerState, Sample};
use crate::numeric::array_from;
use crate::numeric::plane::nearest_equivalent_angle;

/// Returns the sample at time `t` between `a` and `b`: cubic Hermite interpolation of coordinates with their rates,
/// linear interpolation of everything else.
pub fn interpolate(a: &Sample, b: &Sample, t: f64) -> Sample {
    let mut sample = Sample::default();
    sample.interpolate_from(a, b, t);
    sample
}

impl Sample {
    /// Sets this sample to the result of [`interpolate`], reusing its allocations.
    pub(super) fn interpolate_from(&mut self, a: &Sample, b: &Sample, t: f64) {
        let h = b.time_s - a.time_s;
        if h <= 0.0 {
            self.clone_from(b);
            return;
        }
        let instant = Instant { h, x: ((t - a.time_s) / h).clamp(0.0, 1.0) };
        self.time_s = t;
        refill(&mut self.fingers, &a.fingers, &b.fingers, |a, b| instant.finger(a, b));
        refill(&mut self.bodies, &a.bodies, &b.bodies, |a, b| instant.body(a, b));
        refill(&mut self.contacts, &a.contacts, &b.contacts, |a, b| instant.linear_values(a, b));
        self.energy = instant.linear_values(&a.energy, &b.energy);
    }
}

fn refill<T>(items: &mut Vec<T>, a: &[T], b: &[T], combine: impl Fn(&T, &T) -> T) {
    items.clear();
    items.extend(a.iter().zip(b).map(|(a, b)| combine(a, b)));
}

/// An instant between two samples.
#[derive(Clone, Copy, Debug)]
struct Instant {
    /// Time between the samples, s.
    h: f64,
    /// Elapsed fraction of the interval.
    x: f64,
}

impl Instant {
    /// Linear interpolation from `p` to `q`.
    fn linear(&self, p: f64, q: f64) -> f64 {
        if p.is_finite() && q.is_finite() { p + self.x * (q - p) } else { q }
    }

    /// Cubic Hermite interpolation from `p` to `q` with the rates `v` and `w`.
    fn cubic(&self, p: f64, v: f64, q: f64, w: f64) -> f64 {
        let Self { h, x } = *self;
        let (x2, x3) = (x * x, x * x * x);
        p + (q - p) * (3.0 * x2 - 2.0 * x3) + h * (v * (x3 - 2.0 * x2 + x) + w * (x3 - x2))
    }

    /// Linear interpolation of all values.
    fn linear_values<const K: usize, T: Channels<K>>(&self, a: &T, b: &T) -> T {
        let (p, q) = (a.values(), b.values());
        T::from_values(array_from(|i| self.linear(p[i], q[i])))
    }

    fn finger(&self, a: &FingerState, b: &FingerState) -> FingerState {
        let (p, q) = (a.values(), b.values());
        // Rates of q11, q21, q12, q22, and of the sum q13 = q21 + q22.
        let [v, w] = [p, q].map(|values| [values[5], values[6], values[7], values[8], values[6] + values[8]]);
        FingerState::from_values(array_from(|i| match v.get(i) {
            // A passive angle can leave at π and return at −π.
            Some(rate) => self.cubic(p[i], *rate, nearest_equivalent_angle(q[i], p[i]), w[i]),
            None => self.linear(p[i], q[i]),
        }))
    }

    fn body(&self, a: &BodyState, b: &BodyState) -> BodyState {
        let (p, q) = (a.values(), b.values());
        BodyState::from_values(array_from(|i| match (p.get(i + 3), q.get(i + 3)) {
            (Some(v), Some(w)) => self.cubic(p[i], *v, q[i], *w),
            _ => self.linear(p[i], q[i]),
        }))
    }
}
