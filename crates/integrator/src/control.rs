//! Error norm and step-size control.

use super::State;
use super::layout::{Layout, VectorOf};
use crate::numeric::elementary::{ln, pow};

/// Tolerances of coordinates and rates. Angles have only an absolute tolerance: a relative one would hide penetrations
/// of 1e-8 rad, which occur together with angles of 1 rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    pub atol_q: f64,
    pub atol_v: f64,
    pub rtol_v: f64,
}

/// Allowed relative error of a depth or sticking range, as a multiple of the relative tolerance of rates.
const CONTACT_TOLERANCE_FACTOR: f64 = 1e3;
/// Smallest and largest allowed relative error of a depth or sticking range.
const CONTACT_TOLERANCE_RANGE: [f64; 2] = [1e-5, 0.05];

/// Tolerance of the normal rate of a rebound, relative to the tolerance of rates.
const REBOUND_FACTOR: f64 = 0.1;

/// Errors of single steps accumulate. A closing motion takes up to [`TYPICAL_STEPS`] steps at a relative tolerance of
/// 1e-5, and more at finer tolerances according to the order of the methods. For a longer run, with rebounds, sticking
/// and slipping, the tolerances are divided by the square of the ratio of its steps to these, down to
/// [`MIN_TOLERANCE_FACTOR`].
const TYPICAL_STEPS: f64 = 300.0;
/// Number of events in a typical closing motion.
const TYPICAL_EVENTS: u64 = 4;
/// Number of steps that each event beyond [`TYPICAL_EVENTS`] counts as, because an impact amplifies errors.
const STEPS_PER_EVENT: u64 = 80;
/// Smallest factor by which the tolerances of a long run are reduced.
const MIN_TOLERANCE_FACTOR: f64 = 1.0 / 100.0;
/// Relative tolerance from which the tolerances of a long run stay as they are: at equal errors of random mechanisms, such a run
/// takes a quarter fewer steps (tools/tolerances.py).
const COARSE_RTOL: f64 = 2e-5;
/// Smallest tolerances after tightening: below them, angles of 1 rad and rates of 100 rad/s are rounding noise.
const MIN_TOLERANCES: Tolerances = Tolerances { atol_q: 1e-14, atol_v: 1e-9, rtol_v: 1e-11 };

impl Tolerances {
    /// Allowed relative error of the depth, or of the sticking range, of an active contact in a step.
    #[inline(always)]
    pub(crate) fn contact_tolerance(&self) -> f64 {
        (CONTACT_TOLERANCE_FACTOR * self.rtol_v).clamp(CONTACT_TOLERANCE_RANGE[0], CONTACT_TOLERANCE_RANGE[1])
    }

    /// Tolerances for the normal rate of a rebound: its errors persist, and the next rebound multiplies them.
    #[inline(always)]
    pub(crate) fn for_rebounds(&self) -> Self {
        Self { atol_q: self.atol_q, ..self.scaled(REBOUND_FACTOR) }
    }

    /// Returns the tolerances times a factor, at least [`MIN_TOLERANCES`].
    #[inline(always)]
    fn scaled(&self, factor: f64) -> Self {
        let scale_tolerance = |tolerance: f64, minimum: f64| (factor * tolerance).max(minimum.min(tolerance));
        Self {
            atol_q: scale_tolerance(self.atol_q, MIN_TOLERANCES.atol_q),
            atol_v: scale_tolerance(self.atol_v, MIN_TOLERANCES.atol_v),
            rtol_v: scale_tolerance(self.rtol_v, MIN_TOLERANCES.rtol_v),
        }
    }

    /// Scaled error of the rate along a row.
    #[inline(always)]
    pub(crate) fn rate_error_along<L: Layout>(
        &self,
        row: &VectorOf<L>,
        error_v: &VectorOf<L>,
        from: &State<L>,
        to: &State<L>,
    ) -> f64 {
        let (mut error, mut scale) = (0.0, 0.0);
        for i in 0..row.as_ref().len() {
            error += row[i] * error_v[i];
            scale += row[i].abs() * (self.atol_v + self.rtol_v * from.v[i].abs().max(to.v[i].abs()));
        }
        if scale > 0.0 { error.abs() / scale } else { 0.0 }
    }

    /// Root mean square of the scaled errors of the first `coordinate_count` coordinates and of their rates. A step is
    /// acceptable if it is at most 1.
    #[inline(always)]
    pub fn norm<L: Layout>(
        &self,
        (error_q, error_v): (&VectorOf<L>, &VectorOf<L>),
        (from, to): (&State<L>, &State<L>),
        coordinate_count: usize,
    ) -> f64 {
        let mut sum = 0.0;
        for i in 0..coordinate_count.min(error_q.as_ref().len()) {
            let scaled_q = error_q[i] / self.atol_q;
            let scale_v = self.atol_v + self.rtol_v * from.v[i].abs().max(to.v[i].abs());
            let scaled_v = error_v[i] / scale_v;
            sum += scaled_q * scaled_q + scaled_v * scaled_v;
        }
        (sum / (2 * coordinate_count) as f64).sqrt()
    }
}

/// Tightens the tolerances as a run proceeds.
#[derive(Clone, Copy, Debug)]
pub struct ToleranceSchedule {
    /// Number of steps of a smooth closing.
    typical_steps: f64,
}

impl ToleranceSchedule {
    /// Returns the schedule of a run; `tolerances` are those at its start.
    pub fn new(tolerances: &Tolerances) -> Self {
        Self { typical_steps: TYPICAL_STEPS * pow(1e-5 / tolerances.rtol_v, 0.2) }
    }

    /// Returns the tolerances of the next step, after a number of steps and a number of events.
    #[inline(always)]
    pub fn tolerances(&self, requested: &Tolerances, [steps, events]: [u64; 2]) -> Tolerances {
        let event_steps = events.saturating_sub(TYPICAL_EVENTS) * STEPS_PER_EVENT;
        let length_ratio = (steps + event_steps) as f64 / self.typical_steps;
        if length_ratio <= 1.0 || requested.rtol_v >= COARSE_RTOL {
            *requested
        } else {
            requested.scaled((length_ratio * length_ratio).recip().max(MIN_TOLERANCE_FACTOR))
        }
    }
}

/// Proportional–integral control (Gustafsson; Hairer & Wanner, Solving ODEs II, IV.2).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Controller {
    exponent: f64,
    last_error: Option<f64>,
    last_h: f64,
    /// Attempts that were rejected since the last accepted step, and size and error of the last one.
    rejections: u32,
    last_rejection: (f64, f64),
}

/// Safety factor of the proposed step: that of Hairer's RADAU5 and RODAS.
const SAFETY: f64 = 0.9;
/// Largest growth of a step: FACR = 1/8 of RADAU5.
const MAX_GROWTH: f64 = 8.0;
/// Largest reduction of a step: between FACL = 1/5 of RADAU5 and 1/10 of other codes. It acts only after failed attempts.
const MAX_REDUCTION: f64 = 0.15;
/// Number of rejected attempts after which their errors give the order. In a stiff transient the error hardly depends on
/// the step size, so that the order of the method would suggest dozens of attempts.
const REJECTIONS_WITH_NOMINAL_ORDER: u32 = 2;
/// Smallest order that is assumed, and largest reduction by this order. They bound a division by a measured slope, and are
/// not tuned.
const MIN_ORDER: f64 = 0.5;
const MAX_REPEATED_REDUCTION: f64 = 0.1;

impl Controller {
    /// Creates a controller; `order` is the order in h of the leading term of the error estimate.
    pub fn new(order: f64) -> Self {
        Self { exponent: 1.0 / order, last_error: None, last_h: 0.0, rejections: 0, last_rejection: (0.0, 0.0) }
    }

    /// Changes the order of the error estimate, if another method takes over; the history then has no meaning.
    #[inline(always)]
    pub fn set_order(&mut self, order: f64) {
        let exponent = 1.0 / order;
        if exponent != self.exponent {
            self.exponent = exponent;
            self.restart();
        }
    }

    /// Discards the error history; called after an event.
    pub fn restart(&mut self) {
        self.last_error = None;
        self.rejections = 0;
    }

    /// Returns the next step size after an accepted step.
    #[inline(always)]
    pub fn accept(&mut self, h: f64, error: f64) -> f64 {
        let error = error.max(1e-10);
        let mut factor = SAFETY * pow(error, -self.exponent);
        if let Some(last) = self.last_error {
            let predicted = SAFETY * (h / self.last_h) * pow(last / (error * error), self.exponent);
            factor = factor.min(predicted);
        }
        let ceiling = if self.rejections > 0 { 1.0 } else { MAX_GROWTH };
        self.last_error = Some(error.max(1e-2));
        self.last_h = h;
        self.rejections = 0;
        h * factor.clamp(MAX_REDUCTION, ceiling)
    }

    /// Returns the next step size to attempt after a rejected step.
    pub fn reject(&mut self, h: f64, error: f64) -> f64 {
        let (longer, at_longer) = std::mem::replace(&mut self.last_rejection, (h, error));
        self.rejections += 1;
        if !error.is_finite() {
            return MAX_REDUCTION * h;
        }
        let nominal = 1.0 / self.exponent;
        let is_measured = self.rejections > REJECTIONS_WITH_NOMINAL_ORDER && longer > h && at_longer.is_finite();
        let (order, max_reduction) = match is_measured {
            true => (ln(at_longer / error) / ln(longer / h), MAX_REPEATED_REDUCTION),
            false => (nominal, MAX_REDUCTION),
        };
        let factor = SAFETY * pow(error, -1.0 / order.clamp(MIN_ORDER, nominal));
        h * factor.clamp(max_reduction, 0.9)
    }

    /// Returns `factor` times the size of a step that was rejected for a reason other than its error. The next accepted
    /// step is not followed by a larger one.
    pub fn cut(&mut self, h: f64, factor: f64) -> f64 {
        self.rejections += 1;
        self.last_rejection = (h, f64::INFINITY);
        factor * h
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_fine_tolerances_of_a_long_run_are_tightened() {
        for (rtol_v, factor) in [(2e-4, 1.0), (1e-5, 0.25), (3e-6, 0.4047)] {
            let requested = Tolerances { atol_q: 1e-4 * rtol_v, atol_v: rtol_v, rtol_v };
            let found = ToleranceSchedule::new(&requested).tolerances(&requested, [600, 0]);
            assert!((found.rtol_v / requested.rtol_v - factor).abs() < 1e-3, "{rtol_v}: {found:?}");
        }
    }
}
