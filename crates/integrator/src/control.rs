//! Error norm and step-size control.

use super::{Counters, State};
use crate::numeric::elementary::pow;

/// Angles have an absolute tolerance only: penetrations of 1e-8 rad live beside angles of 1 rad, and a relative tolerance
/// would hide them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    pub atol_q: f64,
    pub atol_v: f64,
    pub rtol_v: f64,
}

/// Part of a depth or sticking range that a step may err by, in relative tolerances of rates, and its bounds.
const SHARE: f64 = 1e3;
const SHARES: [f64; 2] = [1e-5, 0.05];

/// Part of the tolerance of rates for the normal rate of a rebound.
const REBOUND_SHARE: f64 = 0.1;

/// Errors of single steps add up. A closing takes up to [`USUAL_STEPS`] at a relative tolerance of 1e-5, and as many more as the order
/// of the methods asks for at finer ones; a run that takes longer, for it rebounds and sticks and slips, gets tolerances tighter by
/// the square of how much longer it is, down to a [`TIGHTEST`] part.
const USUAL_STEPS: f64 = 300.0;
/// Events that a closing has, and the steps that every other one counts for: an impact makes the most of errors.
const USUAL_EVENTS: u64 = 4;
const STEPS_PER_EVENT: u64 = 80;
const TIGHTEST: f64 = 1.0 / 100.0;
/// Tolerances that are not tightened further: below them angles of 1 rad and rates of 100 rad/s have no digits.
const FINEST: Tolerances = Tolerances { atol_q: 1e-14, atol_v: 1e-9, rtol_v: 1e-11 };

impl Tolerances {
    /// Part of the depth, or of the sticking range, of a pressing contact that a step may err by.
    #[inline(always)]
    pub fn share(&self) -> f64 {
        (SHARE * self.rtol_v).clamp(SHARES[0], SHARES[1])
    }

    /// Those of the normal rate of a rebound: it keeps every error, and the next rebound multiplies it.
    #[inline(always)]
    pub fn of_rebounds(&self) -> Self {
        Self { atol_q: self.atol_q, ..self.part(REBOUND_SHARE) }
    }

    /// A part of them, as far as numbers have digits.
    #[inline(always)]
    fn part(&self, part: f64) -> Self {
        let tighter = |tolerance: f64, finest: f64| (part * tolerance).max(finest.min(tolerance));
        Self {
            atol_q: tighter(self.atol_q, FINEST.atol_q),
            atol_v: tighter(self.atol_v, FINEST.atol_v),
            rtol_v: tighter(self.rtol_v, FINEST.rtol_v),
        }
    }

    /// Scaled error of the rate along a row.
    #[inline(always)]
    pub fn rate_along<const N: usize, const Z: usize>(
        &self,
        row: &[f64; N],
        error_v: &[f64; N],
        from: &State<N, Z>,
        to: &State<N, Z>,
    ) -> f64 {
        let (mut error, mut scale) = (0.0, 0.0);
        for i in 0..N {
            error += row[i] * error_v[i];
            scale += row[i].abs() * (self.atol_v + self.rtol_v * from.v[i].abs().max(to.v[i].abs()));
        }
        if scale > 0.0 { error.abs() / scale } else { 0.0 }
    }

    /// Root mean square of the scaled errors of so many coordinates and their rates; 1 is just acceptable.
    #[inline(always)]
    pub fn norm<const N: usize, const Z: usize>(
        &self,
        (error_q, error_v): (&[f64; N], &[f64; N]),
        (from, to): (&State<N, Z>, &State<N, Z>),
        coordinates: usize,
    ) -> f64 {
        let mut sum = 0.0;
        for i in 0..coordinates.min(N) {
            let scaled_q = error_q[i] / self.atol_q;
            let scale_v = self.atol_v + self.rtol_v * from.v[i].abs().max(to.v[i].abs());
            let scaled_v = error_v[i] / scale_v;
            sum += scaled_q * scaled_q + scaled_v * scaled_v;
        }
        (sum / (2 * coordinates) as f64).sqrt()
    }
}

/// How tolerances tighten as a run goes on.
#[derive(Clone, Copy, Debug)]
pub struct Pacing {
    /// Steps of a smooth closing.
    usual: f64,
}

impl Pacing {
    /// Of a run with these tolerances.
    pub fn new(tolerances: &Tolerances) -> Self {
        Self { usual: USUAL_STEPS * pow(1e-5 / tolerances.rtol_v, 0.2) }
    }

    /// Tolerances of the next step of a run that has come so far.
    #[inline(always)]
    pub fn tolerances(&self, asked: &Tolerances, counters: &Counters) -> Tolerances {
        let eventful = counters.events.saturating_sub(USUAL_EVENTS) * STEPS_PER_EVENT;
        let longer = (counters.steps + eventful) as f64 / self.usual;
        if longer <= 1.0 { *asked } else { asked.part((longer * longer).recip().max(TIGHTEST)) }
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
        let mut factor = SAFETY * pow(error, -self.exponent);
        if let Some(last) = self.last_error {
            let predicted = SAFETY * (h / self.last_h) * pow(last / (error * error), self.exponent);
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
        let factor = if error.is_finite() { SAFETY * pow(error, -self.exponent) } else { LARGEST_CUT };
        h * factor.clamp(LARGEST_CUT, 0.9)
    }
}
