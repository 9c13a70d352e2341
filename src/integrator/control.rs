//! Error norm and step-size control.

use super::State;

/// Angles have an absolute tolerance only: penetrations of 1e-8 rad live beside angles of 1 rad, and a relative tolerance
/// would hide them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    pub atol_q: f64,
    pub atol_v: f64,
    pub rtol_v: f64,
}

impl Tolerances {
    /// Root mean square of the scaled errors of coordinates and rates; 1 is just acceptable.
    #[inline(always)]
    pub fn norm<const N: usize, const Z: usize>(
        &self,
        error_q: &[f64; N],
        error_v: &[f64; N],
        from: &State<N, Z>,
        to: &State<N, Z>,
    ) -> f64 {
        let mut sum = 0.0;
        for i in 0..N {
            let scaled_q = error_q[i] / self.atol_q;
            let scale_v = self.atol_v + self.rtol_v * from.v[i].abs().max(to.v[i].abs());
            let scaled_v = error_v[i] / scale_v;
            sum += scaled_q * scaled_q + scaled_v * scaled_v;
        }
        (sum / (2 * N) as f64).sqrt()
    }
}

/// Proportional–integral control (Gustafsson; Hairer & Wanner, Solving ODEs II, IV.2).
#[derive(Clone, Copy, Debug)]
pub struct Controller {
    exponent: f64,
    last_error: Option<f64>,
    last_h: f64,
    rejected: bool,
}

const SAFETY: f64 = 0.9;
const LARGEST_GROWTH: f64 = 8.0;
const LARGEST_CUT: f64 = 0.15;

impl Controller {
    /// `order` is the order of the error estimate's leading term in h.
    pub fn new(order: f64) -> Self {
        Self { exponent: 1.0 / order, last_error: None, last_h: 0.0, rejected: false }
    }

    /// Forgets the past, as an event demands.
    pub fn restart(&mut self) {
        self.last_error = None;
        self.rejected = false;
    }

    /// Next step after an accepted one.
    #[inline(always)]
    pub fn accept(&mut self, h: f64, error: f64) -> f64 {
        let error = error.max(1e-10);
        let mut factor = SAFETY * error.powf(-self.exponent);
        if let Some(last) = self.last_error {
            let predicted = SAFETY * (h / self.last_h) * (last / (error * error)).powf(self.exponent);
            factor = factor.min(predicted);
        }
        let ceiling = if self.rejected { 1.0 } else { LARGEST_GROWTH };
        self.last_error = Some(error.max(1e-2));
        self.last_h = h;
        self.rejected = false;
        h * factor.clamp(LARGEST_CUT, ceiling)
    }

    /// Next try after a step whose error was too large.
    pub fn reject(&mut self, h: f64, error: f64) -> f64 {
        self.rejected = true;
        let factor = if error.is_finite() { SAFETY * error.powf(-self.exponent) } else { LARGEST_CUT };
        h * factor.clamp(LARGEST_CUT, 0.9)
    }
}
