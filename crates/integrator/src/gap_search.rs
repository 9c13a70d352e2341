//! The first zero of a gap within a step, found with bounds of its derivatives instead of samples.
//!
//! A gap of g ≥ 0 with the rate r, whose graph lies above each of its tangents less A τ²/2 and whose rate is at most V,
//! stays positive over the reach max(g/V, (r + √(r² + 2 A g))/A). An interval has no zero if the reaches from both of
//! its ends cover it; otherwise it is divided in the middle of the part that is left. All fractions, rates and bounds are
//! those of the step: per step and per step².

use std::cell::{Cell, RefCell};

use super::interior::Interior;
use super::layout::Layout;
use super::{CoordinateBounds, GapBound, GapBounds, Hybrid, Method};

/// Largest number of states at which one step is evaluated to exclude zeros between them; a step that needs more is
/// shortened. The value only ends the work of one step and is not tuned.
const MAX_EVALUATIONS: u32 = 400;

/// Intervals between the points at which the rate of a gap shows that it is at rest. A polynomial of degree 8, more than the
/// rates of coordinates have, is between nine such points at most 11 times as large as there.
const REST_INTERVALS: u32 = 8;
/// Largest change over a step of a gap at rest, relative to the gap; 11 times this is less than 1.
const REST_CHANGE: f64 = 0.05;

/// A gap at a fraction of the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    pub theta: f64,
    pub value: f64,
    /// Rate per step.
    pub rate: f64,
}

impl GapBound {
    /// Whether a gap stays above `-tolerance` between two points.
    #[inline(always)]
    pub(crate) fn excludes_zero(&self, [left, right]: [Point; 2], tolerance: f64) -> bool {
        if !(left.value >= -tolerance && right.value >= 0.0) {
            return false;
        }
        // Most pairs are so far apart that their largest rate alone decides.
        if left.value + right.value > self.rate * (right.theta - left.theta) {
            return true;
        }
        let uncovered = self.uncovered([left, right], tolerance);
        uncovered[0] >= uncovered[1]
    }

    /// Ends of the part between two points that the reaches from both do not cover.
    #[inline(always)]
    fn uncovered(&self, [left, right]: [Point; 2], tolerance: f64) -> [f64; 2] {
        [
            left.theta + self.reach(left.value + tolerance, left.rate),
            right.theta - self.reach(right.value + tolerance, -right.rate),
        ]
    }
}

/// The first zero of a gap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Zero {
    pub theta: f64,
    /// A later fraction at which the gap is known to be negative.
    pub negative_at: f64,
}

/// The step cannot be searched with the allowed number of evaluations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unresolved;

/// Bounds over a part of a step.
#[derive(Clone, Debug)]
pub(crate) struct Part<L: Layout> {
    pub bounds: GapBounds,
    pub motion: CoordinateBounds<L>,
}

/// Search within one step, whose dense output is evaluated if the bounds over the whole step decide nothing.
pub(crate) struct GapSearch<'a, Y: Hybrid, K> {
    interior: &'a Interior<'a, Y, K>,
    evaluations: Cell<u32>,
    /// Memory for the bounds over a part of the step.
    part: &'a RefCell<Part<Y::Layout>>,
}

impl<'a, Y: Hybrid, K: Method<Y::Layout>> GapSearch<'a, Y, K> {
    pub fn new(interior: &'a Interior<'a, Y, K>, part: &'a RefCell<Part<Y::Layout>>) -> Self {
        Self { interior, evaluations: Cell::new(0), part }
    }

    /// Reads the bounds between two fractions of the step; `at` is one of them.
    #[inline(never)]
    fn bounds_between<R>(&self, from: f64, to: f64, at: f64, read: impl FnOnce(&GapBounds) -> R) -> R {
        let Interior { system, mode, .. } = self.interior;
        let Part { bounds, motion } = &mut *self.part.borrow_mut();
        self.interior.dense().positions().bounds([from, to], system.coordinate_count(), motion);
        self.interior.at_derivative(at, |q, v| {
            let clearance = system.clearance(q, v, mode);
            system.gap_bounds(motion, (q, v), clearance, bounds);
        });
        read(bounds)
    }

    /// Counts an evaluation.
    fn count(&self) -> Result<(), Unresolved> {
        self.evaluations.set(self.evaluations.get() + 1);
        if self.evaluations.get() > MAX_EVALUATIONS { Err(Unresolved) } else { Ok(()) }
    }

    /// Evaluates a gap at a fraction of the step.
    pub fn point(&self, index: usize, theta: f64) -> Result<Point, Unresolved> {
        self.count()?;
        let Interior { system, mode, .. } = self.interior;
        let function = self.interior.at_derivative(theta, |q, v| system.eval_event(q, v, mode, index));
        if function.value.is_nan() {
            return Err(Unresolved);
        }
        Ok(Point { theta, value: function.value, rate: function.rate * self.interior.dense().h })
    }

    /// Whether a gap hardly changes between two points, because a constraint holds it: no bound of rates tells this. It does if
    /// its rates at these points and at some more between them are small, because coordinates are polynomials of lower degree.
    pub fn rests(&self, index: usize, [left, right]: [Point; 2], tolerance: f64) -> Result<bool, Unresolved> {
        let is_at_rest =
            |Point { value, rate, .. }: Point| value >= -tolerance && rate.abs() <= tolerance.max(REST_CHANGE * value);
        if !(is_at_rest(left) && is_at_rest(right)) {
            return Ok(false);
        }
        let at = |k: u32| left.theta + f64::from(k) / f64::from(REST_INTERVALS) * (right.theta - left.theta);
        for k in 1..REST_INTERVALS {
            if !is_at_rest(self.point(index, at(k))?) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Returns the first zero of a gap between two points. Dips of less than `tolerance` below zero do not count.
    pub fn first_zero(
        &self,
        index: usize,
        [left, right]: [Point; 2],
        bound: GapBound,
        tolerance: f64,
    ) -> Result<Option<Zero>, Unresolved> {
        if left.value < -tolerance {
            return Ok(Some(Zero { theta: left.theta.max(f64::EPSILON * right.theta), negative_at: right.theta }));
        }
        if right.value < 0.0 {
            let value = |theta: f64| self.interior.function(index, theta).value;
            let [low, high] = [left, right].map(|point| (point.theta, point.value));
            let middle = 0.5 * (left.theta + right.theta);
            let middle = (middle, value(middle));
            let [low, high] = if middle.1 < 0.0 { [low, middle] } else { [middle, high] };
            let (theta, high) = (find_root(&value, [low, high], ROOT_TOLERANCE * tolerance), high.0);
            let root = Point { value: 0.0, ..self.point(index, theta)? };
            let earlier = self.first_zero(index, [left, root], bound, tolerance)?;
            return Ok(earlier.or(Some(Zero { theta, negative_at: high })));
        }
        if bound.excludes_zero([left, right], tolerance) {
            return Ok(None);
        }
        let [from, to] = bound.uncovered([left, right], tolerance);
        let middle = self.point(index, 0.5 * (from + to))?;
        let part = |from: f64, to: f64| self.bounds_between(from, to, middle.theta, |bounds| bounds.gaps[index]);
        let before = self.first_zero(index, [left, middle], part(left.theta, middle.theta), tolerance)?;
        if before.is_some() {
            return Ok(before);
        }
        let middle = Point { value: middle.value.max(0.0), ..middle };
        self.first_zero(index, [middle, right], part(middle.theta, right.theta), tolerance)
    }

    /// Whether the clearance stays positive over the whole step; `reach_at_end` is the [`GapBounds::clearance_reach`]
    /// of its end.
    pub fn stays_clear(&self, reach_at_end: f64) -> bool {
        reach_at_end >= 1.0 || self.is_clear_between([0.0, 1.0]).unwrap_or(false)
    }

    fn is_clear_between(&self, [from, to]: [f64; 2]) -> Result<bool, Unresolved> {
        self.count()?;
        let reaches = [from, to].map(|at| self.bounds_between(from, to, at, |bounds| bounds.clearance_reach));
        // A reach of 0 is that of an unknown bound, which a shorter part may have.
        if reaches.iter().any(|reach| reach.is_nan() || *reach < 0.0) {
            return Ok(false);
        }
        let left = to - from - reaches[0] - reaches[1];
        if left <= 0.0 {
            return Ok(true);
        }
        let middle = from + reaches[0] + 0.5 * left;
        Ok(self.is_clear_between([from, middle])? && self.is_clear_between([middle, to])?)
    }
}

/// Largest number of evaluations in the search of a root.
const MAX_ROOT_EVALUATIONS: usize = 80;

/// Ratio of the value at a root that is found to the tolerance of the event. Times of events are smooth functions of parameters
/// only if they do not depend on the search.
pub(crate) const ROOT_TOLERANCE: f64 = 1e-6;

/// Returns a root of `value` between two points with their values; the first value is not negative, and the second one is.
/// The root is the far end of a tight bracket, or a point with a value between 0 and `tolerance`.
///
/// Chandrupatla's method (Adv. Eng. Softw. 28:145, 1997): inverse quadratic interpolation where the last three points
/// allow it, otherwise bisection, because the event function of a clamped law may jump. The first point is that of the
/// secant.
pub(crate) fn find_root(value: &dyn Fn(f64) -> f64, [low, high]: [(f64, f64); 2], tolerance: f64) -> f64 {
    // The latest point, and the other end of the bracket.
    let (mut a, mut at_a) = (low.0, low.1.max(0.0));
    let (mut b, mut at_b) = high;
    // A value that begins within the tolerance may rise before it falls.
    let tolerance = if at_a > tolerance { tolerance } else { 0.0 };
    let mut fraction = at_a / (at_a - at_b);
    for _ in 0..MAX_ROOT_EVALUATIONS {
        let at_far = if at_a < 0.0 { at_a } else { at_b };
        let width = 2.0 * f64::EPSILON * a.max(b) / (b - a).abs();
        if width >= 0.5 || at_far > -1e-300 {
            break;
        }
        // A fraction that is not a number becomes a bisection.
        let fraction_inside = if fraction.is_finite() { fraction.clamp(width, 1.0 - width) } else { 0.5 };
        let x = a + fraction_inside * (b - a);
        let at_x = value(x);
        if (0.0..=tolerance).contains(&at_x) {
            // The far end of the bracket may still be far away.
            return x;
        }
        // The point that is no longer an end of the bracket.
        let (mut c, mut at_c) = (a, at_a);
        if (at_x < 0.0) != (at_a < 0.0) {
            std::mem::swap(&mut c, &mut b);
            std::mem::swap(&mut at_c, &mut at_b);
        }
        (a, at_a) = (x, at_x);
        let (xi, phi) = ((a - b) / (c - b), (at_a - at_b) / (at_c - at_b));
        fraction = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            at_a / (at_b - at_a) * (at_c / (at_b - at_c))
                + (c - a) / (b - a) * (at_a / (at_c - at_a)) * (at_b / (at_c - at_b))
        } else {
            0.5
        };
    }
    if at_a < 0.0 { a } else { b }
}
