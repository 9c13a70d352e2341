//! Locates the first event within a step.

use std::cell::RefCell;

use super::gap_search::{GapSearch, Part, Point, ROOT_TOLERANCE, Unresolved, find_root};
use super::interior::Interior;
use super::layout::{Layout, VectorOf};
use super::state::{DENSE_TERMS, DensePositions};
use super::{
    CoordinateBounds, Dense, EventFunction, EventSet, GapBound, GapBounds, Hybrid, Method, RootSearch, State,
    WeightedQuantity,
};
use crate::numeric::array_from;
use crate::numeric::elementary::powi;

/// The earliest zero of an event function in a step.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    pub event_index: usize,
    /// Fraction of the step just beyond the zero.
    pub theta: f64,
    /// A later fraction at which the event function is known to be negative. If the function only dips below zero, it
    /// may be positive again at the end of the step.
    pub negative_at: f64,
}

/// What the search of a step has found.
#[derive(Clone, Copy, Debug)]
pub enum Found {
    Nothing,
    Crossing(Crossing),
    /// A singularity. The step is shortened.
    Obstacle,
    /// A crossing that the bounds of the gaps cannot exclude. The step is shortened.
    Unresolved,
}

/// Working memory of the search of a step, reused for the next step.
#[derive(Clone, Debug)]
pub struct SearchMemory<L: Layout> {
    /// Bounds over the whole step, and over a part of it.
    bounds: GapBounds,
    motion: CoordinateBounds<L>,
    part: RefCell<Part<L>>,
    positions: [VectorOf<L>; DENSE_TERMS],
    dense: Dense<L>,
    state: RefCell<[VectorOf<L>; 2]>,
    samples: SampleMemory,
}

/// Memory for the functions that are sampled.
#[derive(Clone, Debug)]
struct SampleMemory {
    may_cross: Vec<bool>,
    is_gap: Vec<bool>,
    at_half: Vec<f64>,
    at_thirds: [Vec<f64>; 2],
    /// Functions that may be negative inside the step, and their values there.
    may_dip: Vec<bool>,
    at_samples: [Vec<f64>; SAMPLES_PER_STEP - 2],
}

impl<L: Layout> SearchMemory<L> {
    /// Creates the memory for `count` event functions.
    pub fn new(layout: L, count: usize) -> Self {
        let (bounds, values) = (GapBounds::new(count), vec![f64::NAN; count]);
        let samples = SampleMemory {
            may_cross: vec![false; count],
            is_gap: vec![false; count],
            at_thirds: [values.clone(), values.clone()],
            may_dip: vec![false; count],
            at_samples: std::array::from_fn(|_| values.clone()),
            at_half: values,
        };
        let (motion, zero) = (CoordinateBounds::at_rest(layout), || layout.vector(0.0));
        Self {
            part: RefCell::new(Part { bounds: bounds.clone(), motion: motion.clone() }),
            bounds,
            motion,
            positions: std::array::from_fn(|_| zero()),
            dense: Dense::new(layout),
            state: RefCell::new([zero(), zero()]),
            samples,
        }
    }
}

/// An event function at a fraction of the last attempt of a method.
pub(crate) fn function_inside<Y: Hybrid, K: Method<Y::Layout>>(
    (system, mode, method): (&Y, &Y::Mode, &K),
    index: usize,
    theta: f64,
    memory: &mut SearchMemory<Y::Layout>,
) -> EventFunction {
    Interior::new((system, mode, method), &mut memory.dense, &memory.state).function(index, theta)
}

/// Searches a step of size `h`, the last attempt of the method, for its first zero of an event function and for a
/// singularity. The event functions at both ends are given.
///
/// Gaps and the clearance are searched with bounds of their rates, so that no link passes through an object, however
/// thin it is or however short the contact. Other functions are checked at the end. They are also sampled inside the
/// step if they may be negative there, according to their rates at the ends or to their curvature.
#[inline(always)]
pub fn search_step<Y: Hybrid, K: Method<Y::Layout>>(
    (system, mode, method): (&Y, &Y::Mode, &K),
    [start, end]: [&EventSet<Y::Layout>; 2],
    ([from, to], h): ([&State<Y::Layout>; 2], f64),
    memory: &mut SearchMemory<Y::Layout>,
) -> Found {
    let SearchMemory { bounds, motion, part, positions, dense, state, samples } = memory;
    let interior = Interior::new((system, mode, method), dense, state);
    let is_bounded = |index: &usize| {
        let [start, end] = [start, end].map(|events| &events.functions[*index]);
        let may_cross = start.value.is_nan() || end.value.is_nan() || start.value.min(end.value).is_finite();
        start.root_search == RootSearch::Bounded && may_cross
    };
    let mut first = None;
    if end.clearance != f64::INFINITY || (0..system.event_count()).any(|index| is_bounded(&index)) {
        let terms = method.dense_positions(positions);
        let d = array_from(|i| positions[i].as_ref());
        let positions = DensePositions { start: from.q.as_ref(), end: to.q.as_ref(), d, terms, step_s: h };
        positions.bounds([0.0, 1.0], system.coordinate_count(), motion);
        system.gap_bounds(motion, (&to.q, &to.v), end.clearance, bounds);
        let search = GapSearch::new(&interior, part);
        if !search.stays_clear(bounds.clearance_reach) {
            return Found::Obstacle;
        }
        for index in (0..system.event_count()).filter(is_bounded) {
            let ends = [(0.0, start), (1.0, end)].map(|(theta, events)| {
                let EventFunction { value, rate, .. } = events.functions[index];
                Point { theta, value, rate: h * rate }
            });
            if bounds.gaps[index].excludes_zero(ends, 0.0) {
                continue;
            }
            let bound = (bounds.gaps[index], system.event_tolerance(index, mode));
            match first_zero(&search, index, ends, bound, first) {
                Ok(crossing) => first = crossing,
                Err(Unresolved) => return Found::Unresolved,
            }
        }
    }
    match first_sampled_crossing(&interior, ([start, end], h), first, samples) {
        Some(crossing) => Found::Crossing(crossing),
        None => Found::Nothing,
    }
}

/// Returns the first zero crossing of the functions that are not searched with bounds, or `first` if it is earlier.
fn first_sampled_crossing<Y: Hybrid, K: Method<Y::Layout>>(
    interior: &Interior<Y, K>,
    (events, h): ([&EventSet<Y::Layout>; 2], f64),
    mut first: Option<Crossing>,
    memory: &mut SampleMemory,
) -> Option<Crossing> {
    let SampleMemory { may_cross, is_gap, at_half, at_thirds, may_dip: dips, at_samples } = memory;
    let [start, end] = events.map(|events| &events.functions[..]);
    for (index, may_cross) in may_cross.iter_mut().enumerate() {
        let is_sampled = start[index].root_search != RootSearch::Bounded;
        *may_cross = is_sampled && (end[index].value < 0.0 || may_dip(events, index, h));
    }
    if !may_cross.contains(&true) {
        return first;
    }
    let search_of = |index: usize| select_search(&start[index], &end[index]);
    let (mut has_half, mut has_thirds) = (false, false);
    let mut at_half = |index: usize| {
        if !std::mem::replace(&mut has_half, true) {
            for (index, is_gap) in is_gap.iter_mut().enumerate() {
                *is_gap = may_cross[index] && search_of(index) == RootSearch::Gap;
            }
            interior.values(0.5, is_gap, at_half);
        }
        at_half[index]
    };
    let mut at_thirds = |index: usize| {
        if !std::mem::replace(&mut has_thirds, true) {
            (0..2).for_each(|k| interior.values(THIRDS[k], may_cross, &mut at_thirds[k]));
        }
        [at_thirds[0][index], at_thirds[1][index]]
    };
    let separates = |index: usize| end[index].is_separated && !start[index].is_separated;
    for (index, dips) in dips.iter_mut().enumerate() {
        *dips = may_cross[index]
            && match search_of(index) {
                RootSearch::EndOnly | RootSearch::Bounded | RootSearch::Gap => false,
                // The force of a separating contact has a kink, which thirds do not reveal.
                RootSearch::Interior if separates(index) => true,
                RootSearch::Interior | RootSearch::Smooth | RootSearch::FadingForce => {
                    end[index].value < 0.0 || may_dip_inside(start[index].value, end[index].value, at_thirds(index))
                }
            };
    }
    // All functions are sampled at the same states.
    let mut has_sample = [false; SAMPLES_PER_STEP - 2];
    let mut at_sample = |index: usize, sample: usize| {
        if !std::mem::replace(&mut has_sample[sample - 1], true) {
            interior.values(sample_theta(sample), dips, &mut at_samples[sample - 1]);
        }
        at_samples[sample - 1][index]
    };
    for index in (0..may_cross.len()).filter(|index| may_cross[*index]) {
        let value = |theta: f64| interior.function(index, theta).value;
        let tolerance = || interior.system.event_tolerance(index, interior.mode);
        let ends = [(0.0, start[index].value), (1.0, end[index].value)];
        let is_negative_at_end = end[index].value < 0.0;
        let bracket = match search_of(index) {
            RootSearch::EndOnly | RootSearch::Bounded => is_negative_at_end.then_some(ends),
            RootSearch::Interior | RootSearch::Smooth | RootSearch::FadingForce if dips[index] => {
                let separation =
                    separates(index).then(|| find_separation(&|theta| interior.function(index, theta).is_separated));
                let values = (ends.map(|end| end.1), tolerance());
                first_dip(values, separation, &mut |sample| at_sample(index, sample), &value)
            }
            RootSearch::Interior | RootSearch::Smooth | RootSearch::FadingForce => None,
            RootSearch::Gap if at_half(index) < 0.0 => Some([ends[0], (0.5, at_half(index))]),
            RootSearch::Gap if is_negative_at_end => Some([(0.5, at_half(index)), ends[1]]),
            RootSearch::Gap if start[index].rate < 0.0 && end[index].rate > 0.0 => {
                let lowest = find_minimum(&|theta| interior.function(index, theta).rate);
                let lowest = (lowest, value(lowest));
                (lowest.1 < 0.0).then_some([ends[0], lowest])
            }
            RootSearch::Gap => None,
        };
        let Some([low, high]) = bracket else { continue };
        // This event function is still positive at the earliest crossing so far, so its own crossing is later.
        if first.is_some_and(|f| f.theta < high.0 && value(f.theta * (1.0 - SAME_CROSSING)) >= 0.0) {
            continue;
        }
        let theta = find_root(&value, [low, high], ROOT_TOLERANCE * tolerance());
        if first.is_none_or(|f| theta < f.theta) {
            first = Some(Crossing { event_index: index, theta, negative_at: high.0 });
        }
    }
    first
}

/// The first zero crossing of a gap, or `first` if it is earlier. `bound` is that of the gap over the step, with the depth
/// below which a dip does not count.
#[inline(always)]
fn first_zero<Y: Hybrid, K: Method<Y::Layout>>(
    search: &GapSearch<Y, K>,
    index: usize,
    [start, mut end]: [Point; 2],
    (bound, tolerance): (GapBound, f64),
    first: Option<Crossing>,
) -> Result<Option<Crossing>, Unresolved> {
    if bound.excludes_zero([start, end], tolerance) {
        return Ok(first);
    }
    if let Some(first) = first {
        // Simultaneous crossings keep the first index.
        end = search.point(index, first.theta * (1.0 - SAME_CROSSING))?;
    }
    if end.value >= 0.0 && search.rests(index, [start, end], tolerance)? {
        return Ok(first);
    }
    let zero = search.first_zero(index, [start, end], bound, tolerance)?;
    Ok(zero.map(|zero| Crossing { event_index: index, theta: zero.theta, negative_at: zero.negative_at }).or(first))
}

/// Whether an event function that is positive at both ends could be negative in between. A gap could if it closed at
/// twice the larger of its end rates throughout the step; other values must be sampled inside.
fn may_dip<L: Layout>(events: [&EventSet<L>; 2], index: usize, h: f64) -> bool {
    let [start, end] = events.map(|events| &events.functions[index]);
    let lowest_end = start.value.min(end.value);
    match select_search(start, end) {
        RootSearch::EndOnly | RootSearch::Bounded => false,
        RootSearch::Interior | RootSearch::Smooth => lowest_end.is_finite(),
        RootSearch::FadingForce => lowest_end.is_finite() && loses_depth(events, index),
        RootSearch::Gap => start.value.is_finite() && lowest_end < 2.0 * h * start.rate.abs().max(end.rate.abs()),
    }
}

/// Root-search policy within a step: inside the step if either end requires it.
fn select_search(start: &EventFunction, end: &EventFunction) -> RootSearch {
    if matches!(start.root_search, RootSearch::Interior | RootSearch::FadingForce) {
        start.root_search
    } else {
        end.root_search
    }
}

/// Whether a contact loses half of its depth in a step. Shorter steps resolve the contact without sampling.
fn loses_depth<L: Layout>(events: [&EventSet<L>; 2], index: usize) -> bool {
    match events.map(|events| events.weight(index)) {
        [Some(WeightedQuantity::Depth { depth: before, .. }), Some(WeightedQuantity::Depth { depth: after, .. })] => {
            *after < 0.5 * before
        }
        _ => true,
    }
}

/// Number of samples of a value without a rate within a step, ends included.
const SAMPLES_PER_STEP: usize = 9;

/// Crossings that differ by less than this fraction of their position in the step count as simultaneous.
const SAME_CROSSING: f64 = 1e-9;

const THIRDS: [f64; 2] = [1.0 / 3.0, 2.0 / 3.0];

/// Whether a value deviates so much from a straight line, at the thirds of the step, that it might be negative
/// elsewhere.
fn may_dip_inside(start: f64, end: f64, thirds: [f64; 2]) -> bool {
    let straight = |theta: f64| start + theta * (end - start);
    let curvature = (thirds[0] - straight(THIRDS[0])).abs().max((thirds[1] - straight(THIRDS[1])).abs());
    let minimum = start.min(end).min(thirds[0]).min(thirds[1]);
    // A value that is not finite may hide a crossing.
    minimum < 4.0 * curvature || !(minimum - curvature).is_finite()
}

/// Maximum number of samples just before the surfaces separate. The damping vanishes with the depth, so the force of
/// the spring may return arbitrarily close to the separation.
const MAX_SEPARATION_SAMPLES: i32 = 12;
/// Ratio of the remaining times to the separation at successive samples.
const SEPARATION_RATIO: f64 = 0.25;

/// Fraction of the step at a sample; the first and the last sample are its ends.
fn sample_theta(sample: usize) -> f64 {
    sample as f64 / (SAMPLES_PER_STEP - 1) as f64
}

/// Returns a bracket of the first zero crossing of a value that may be negative only between its ends, with the values at its
/// ends. Dips of less than `tolerance` below zero need not be found. `separation` is the fraction at which the surfaces separate;
/// `sample` gives the value at a sample inside the step.
fn first_dip(
    ([start, end], tolerance): ([f64; 2], f64),
    separation: Option<f64>,
    sample: &mut dyn FnMut(usize) -> f64,
    value: &dyn Fn(f64) -> f64,
) -> Option<[(f64, f64); 2]> {
    let mut samples = [end; SAMPLES_PER_STEP];
    samples[0] = start;
    // Samples after the first negative one are not read.
    let first_negative = (1..SAMPLES_PER_STEP).find(|i| {
        if *i < SAMPLES_PER_STEP - 1 {
            samples[*i] = sample(*i);
        }
        samples[*i] < 0.0
    });
    let point = |i: usize| (sample_theta(i), samples[i]);
    // A dip between two samples, before the first negative one. The lowest sample may also be one of the ends.
    for i in 0..first_negative.unwrap_or(SAMPLES_PER_STEP) {
        let (before, after) = (i.saturating_sub(1), (i + 1).min(SAMPLES_PER_STEP - 1));
        let middle = i.clamp(1, SAMPLES_PER_STEP - 2);
        let curvature = samples[middle - 1].max(samples[middle + 1]) - samples[i];
        if samples[i] <= samples[before] && samples[i] <= samples[after] && samples[i] < 4.0 * curvature {
            let inner = (before < i && i < after).then(|| point(i));
            if let Some(negative) = find_negative(value, [point(before), point(after)], inner, tolerance) {
                return Some([point(before), negative]);
            }
        }
    }
    let sampled = first_negative.map(|i| [point(i - 1), point(i)]);
    sampled.or_else(|| {
        let end = separation?;
        let mut before = (0.0, start);
        (1..MAX_SEPARATION_SAMPLES).find_map(|sample| {
            let theta = end * (1.0 - powi(SEPARATION_RATIO, sample));
            let at = (theta, value(theta));
            let bracket = (at.1 < 0.0).then_some([before, at]);
            before = at;
            bracket
        })
    })
}

/// Fraction of the step at which the surfaces separate, if they overlap at its start and are separated at its end.
fn find_separation(is_separated: &dyn Fn(f64) -> bool) -> f64 {
    let (mut low, mut high): (f64, f64) = (0.0, 1.0);
    // At the very start of the step, the bracket would shrink for ever.
    while high - low > 4.0 * f64::EPSILON * high.max(SAME_CROSSING) {
        let middle = 0.5 * (low + high);
        if is_separated(middle) { high = middle } else { low = middle }
    }
    low
}

/// A point with a negative value between two points, found on the way to the single minimum of the value. `inner` is a point
/// between them whose value is known. Vertices of parabolas and sections by the golden ratio take turns; the search ends where
/// the lines through neighbouring points show that there is no such point, or only dips of less than `tolerance` below zero.
fn find_negative(
    value: &dyn Fn(f64) -> f64,
    [mut low, mut high]: [(f64, f64); 2],
    inner: Option<(f64, f64)>,
    tolerance: f64,
) -> Option<(f64, f64)> {
    const GOLDEN_SECTION: f64 = 0.381_966_011_250_105_1;
    /// Smallest distance of a new point from its neighbours, as a fraction of the interval.
    const MIN_DISTANCE: f64 = 1e-4;
    let at = |theta: f64| (theta, value(theta));
    // Without an inner point, the lower end is the lowest sample: the slope there tells most.
    let beside_end = MIN_DISTANCE * (high.0 - low.0);
    let mut inner = inner.unwrap_or_else(|| at(if low.1 < high.1 { low.0 + beside_end } else { high.0 - beside_end }));
    for iteration in 0..40 {
        if inner.1 < 0.0 {
            return Some(inner);
        }
        let width = high.0 - low.0;
        let larger = if inner.0 - low.0 > high.0 - inner.0 { low.0 } else { high.0 };
        let section = inner.0 + GOLDEN_SECTION * (larger - inner.0);
        let vertex = vertex([low, inner, high]).clamp(low.0 + MIN_DISTANCE * width, high.0 - MIN_DISTANCE * width);
        let is_apart = (vertex - inner.0).abs() >= MIN_DISTANCE * width;
        let beside = inner.0 + (MIN_DISTANCE * width).copysign(larger - inner.0);
        let theta = match iteration % 2 == 0 && vertex.is_finite() {
            true if is_apart => vertex,
            true => beside,
            false => section,
        };
        let other = at(theta);
        if other.1 < 0.0 {
            return Some(other);
        }
        let [a, b] = if other.0 < inner.0 { [other, inner] } else { [inner, other] };
        let least = a.1.min(b.1);
        // Where the value is convex, it is not below this bound. Twice the distance allows for a change of its curvature.
        if least - 2.0 * (least - lower_bound([low, a, b, high])) > -tolerance {
            return None;
        }
        if a.1 < b.1 { (inner, high) = (a, b) } else { (low, inner) = (a, b) }
    }
    None
}

/// Position of the vertex of the parabola through three points.
fn vertex([low, inner, high]: [(f64, f64); 3]) -> f64 {
    let [left, right] = [inner.0 - low.0, high.0 - inner.0];
    let slopes = [(inner.1 - low.1) / left, (high.1 - inner.1) / right];
    inner.0 - 0.5 * (slopes[0] * right + slopes[1] * left) / (slopes[1] - slopes[0])
}

/// A lower bound of a convex value between the first and the last of four points: it lies above the lines through two
/// neighbouring points beyond these.
fn lower_bound([low, a, b, high]: [(f64, f64); 4]) -> f64 {
    let slope = |from: (f64, f64), to: (f64, f64)| (to.1 - from.1) / (to.0 - from.0);
    let [before, inner, after] = [slope(low, a), slope(a, b), slope(b, high)];
    let left = a.1 - inner.max(0.0) * (a.0 - low.0);
    let right = b.1 + inner.min(0.0) * (high.0 - b.0);
    let middle = (a.1 + before.min(0.0) * (b.0 - a.0)).max(b.1 - after.max(0.0) * (b.0 - a.0));
    left.min(middle).min(right)
}

/// Whether a clearance may have become negative within a step of size `h`: whether the cubic through its values and
/// rates at both ends is negative between them.
///
/// This detects a linkage that reaches a fold of its loop. The real linkage snaps through, but the numerical solution
/// bounces off: the rate jumps from closing to opening, and the cubic falls below zero.
pub(crate) fn may_have_passed(start: (f64, f64), end: (f64, f64), h: f64) -> bool {
    const SAMPLES: usize = 16;
    let ((y0, r0), (y1, r1)) = (start, end);
    r0 < 0.0
        && r1 > 0.0
        && (1..SAMPLES).any(|i| {
            let x = i as f64 / SAMPLES as f64;
            let (up, down) = (x * x, (1.0 - x) * (1.0 - x));
            down * ((1.0 + 2.0 * x) * y0 + x * h * r0) + up * ((3.0 - 2.0 * x) * y1 - (1.0 - x) * h * r1) < 0.0
        })
}

/// Fraction of the step at which a rate changes from negative to positive.
fn find_minimum(rate: &dyn Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if rate(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Fixed;
    use crate::{Attempt, EventSet, Linearised, Rates, StepStart, System};

    type One = Fixed<1, 0>;

    /// A point that moves past markers at a constant rate, with a single mode.
    struct Markers([f64; 3]);

    impl System for Markers {
        type Layout = One;
        type Mode = ();

        fn layout(&self) -> One {
            Fixed
        }

        fn rates(&self, _: f64, _: &[f64; 1], _: &[f64; 1], (): &(), rates: &mut Rates<One>) {
            rates.a = [0.0];
        }

        fn linearise(&self, _: f64, _: &[f64; 1], _: &[f64; 1], (): &(), linearised: &mut Linearised<One>) {
            linearised.clear();
        }
    }

    impl Hybrid for Markers {
        fn event_count(&self) -> usize {
            3
        }

        fn next_discontinuity(&self, _: f64) -> f64 {
            f64::INFINITY
        }

        fn eval_events(&self, q: &[f64; 1], v: &[f64; 1], (): &(), events: &mut EventSet<One>) {
            (0..3).for_each(|index| events.functions[index] = self.eval_event(q, v, &(), index));
        }

        fn clearance(&self, _: &[f64; 1], _: &[f64; 1], (): &()) -> f64 {
            f64::INFINITY
        }

        fn eval_event(&self, q: &[f64; 1], _: &[f64; 1], (): &(), index: usize) -> EventFunction {
            EventFunction { value: self.0[index] - q[0], ..EventFunction::INACTIVE }
        }

        fn event_tolerance(&self, _: usize, (): &()) -> f64 {
            0.0
        }

        fn pass_event(&self, _: usize, _: &[f64; 1], _: &[f64; 1], (): &mut ()) {}

        fn pass_step(&self, _: &[EventFunction], (): &mut ()) -> bool {
            false
        }

        fn clamp_law(&self, _: usize, (): &mut ()) {}

        fn mode_at(&self, _: f64, _: &[f64; 1], _: &[f64; 1]) {}

        fn restart_step(&self, _: usize, _: &[f64; 1], _: &[f64; 1], (): &()) -> Option<f64> {
            None
        }

        fn describe_obstacle(&self, _: &[f64; 1]) -> String {
            String::new()
        }
    }

    /// The exact motion of the point, from 0 to 1.
    #[derive(Clone)]
    struct ConstantRate;

    impl Method<One> for ConstantRate {
        fn new(_: One) -> Self {
            Self
        }

        fn error_order(&self) -> f64 {
            1.0
        }

        fn restart(&mut self) {}

        fn accept_step(&mut self) {}

        fn follow(&mut self, _: &Self) {}

        fn attempt<Y: System<Layout = One>>(&mut self, _: &StepStart<Y>, _: f64, _: &mut Attempt<One>) {}

        fn dense(&self, _: Option<&Linearised<One>>, dense: &mut Dense<One>) {
            (dense.h, dense.start.v, dense.end.q, dense.end.v) = (1.0, [1.0], [1.0], [1.0]);
        }

        fn dense_positions(&self, d: &mut [[f64; 1]; DENSE_TERMS]) -> usize {
            *d = [[0.0]; DENSE_TERMS];
            DENSE_TERMS
        }
    }

    #[test]
    fn finds_the_first_of_several_crossings_in_any_order_of_event_functions() {
        let state = |q: f64| State { q: [q], v: [1.0], z: [] };
        let (start, end) = (state(0.0), state(1.0));
        for (markers, event_index, theta) in
            [([0.3, 0.6, 2.0], 0, 0.3), ([0.6, 0.3, 0.9], 1, 0.3), ([0.9, 0.6, 0.3], 2, 0.3), ([2.0, 0.7, 0.7], 1, 0.7)]
        {
            let system = Markers(markers);
            let [before, after] = [&start, &end].map(|state| {
                let mut events = EventSet::new(Fixed, 3);
                system.eval_events(&state.q, &state.v, &(), &mut events);
                events
            });
            let (ends, mut memory) = (([&start, &end], 1.0), SearchMemory::new(Fixed, 3));
            let Found::Crossing(first) =
                search_step((&system, &(), &ConstantRate), [&before, &after], ends, &mut memory)
            else {
                panic!("{markers:?}: no crossing");
            };
            assert_eq!(first.event_index, event_index, "{markers:?}");
            assert!((first.theta - theta).abs() < 1e-12, "{markers:?}: {first:?}");
        }
    }

    #[test]
    fn find_root_handles_smooth_and_discontinuous_functions() {
        let smooth = root_of(&|x| 0.3 - x * x, 0.0);
        assert!((smooth - 0.3f64.sqrt()).abs() < 1e-9, "{smooth}");
        let jump = root_of(&|x| if x < 0.7 { 5.0 } else { -1.0 }, 0.0);
        assert!((jump - 0.7).abs() < 1e-9 && jump >= 0.7, "{jump}");
    }

    #[test]
    fn finds_dips_between_samples() {
        for position in [0.03, 0.31, 0.5, 0.77, 0.97] {
            let narrow_dip = |x: f64| (x - position) * (x - position) - 1e-5;
            let [low, high] = dip_of(&narrow_dip, None).expect("a dip");
            assert!(
                narrow_dip(low) >= 0.0 && narrow_dip(high) < 0.0 && high > position - 4e-3 && low < position,
                "{position}: {low} {high}"
            );
            let above = |x: f64| narrow_dip(x) + 2e-5;
            assert!(dip_of(&above, None).is_none(), "{position}");
        }
        assert_eq!(dip_of(&|x| 1.0 - 2.0 * x, None), Some([0.5, 0.625]));
    }

    /// The first dip of a function over a step.
    fn dip_of(value: &dyn Fn(f64) -> f64, separation: Option<f64>) -> Option<[f64; 2]> {
        let ends = ([value(0.0), value(1.0)], 0.0);
        let bracket = first_dip(ends, separation, &mut |sample| value(sample_theta(sample)), value);
        bracket.map(|ends| {
            assert!(ends.iter().all(|&(theta, at)| at == value(theta)), "{ends:?}");
            ends.map(|(theta, _)| theta)
        })
    }

    /// A root of a function over a step.
    fn root_of(value: &dyn Fn(f64) -> f64, tolerance: f64) -> f64 {
        find_root(value, [0.0, 1.0].map(|theta| (theta, value(theta))), tolerance)
    }

    #[test]
    fn the_search_of_a_dip_ends_where_the_value_stays_positive() {
        let evaluations = std::cell::Cell::new(0);
        let search = |least: f64| {
            let value = |x: f64| {
                evaluations.set(evaluations.get() + 1);
                least + (x - 0.4) * (x - 0.4)
            };
            find_negative(&value, [0.25, 0.5].map(|x| (x, least + (x - 0.4) * (x - 0.4))), None, 0.0)
                .map(|point| point.0)
        };
        assert_eq!(search(0.1), None);
        assert!(evaluations.get() <= 3, "{} evaluations", evaluations.get());
        // The smaller the distance from 0, the later it is clear.
        for least in [1e-4, 1e-6, 1e-8] {
            assert_eq!(search(least), None, "{least}");
            assert!(search(-least).is_some_and(|x| (x - 0.4) * (x - 0.4) < least), "{least}");
        }
    }

    /// A value that rises from just above zero, as after an event: without a tolerance, the search could go on to its start.
    #[test]
    fn the_search_of_a_dip_ends_at_dips_within_the_tolerance() {
        let evaluations = std::cell::Cell::new(0);
        let value = |x: f64| {
            evaluations.set(evaluations.get() + 1);
            1e-8 + x + x * x
        };
        let ends = [0.0, 0.125].map(|x| (x, 1e-8 + x + x * x));
        assert_eq!(find_negative(&value, ends, None, 1e-8), None);
        assert!(evaluations.get() <= 4, "{} evaluations", evaluations.get());
    }

    /// A linear spring with a damper that fades with the square of the depth: the force returns in the last 1e-5 of the
    /// step.
    #[test]
    fn finds_forces_that_return_just_before_separation() {
        let separates_at = 0.7;
        let force = |x: f64| {
            let delta = (separates_at - x).max(0.0);
            delta - 1e5 * delta * delta
        };
        let value = |x: f64| 1e-9 - force(x);
        let separation = find_separation(&|x| x > separates_at);
        assert!((separation - separates_at).abs() < 1e-12);
        let [low, high] = dip_of(&value, Some(separation)).expect("a return");
        assert!(value(low) >= 0.0 && value(high) < 0.0 && high > separates_at - 1e-5);
    }

    #[test]
    fn surfaces_may_separate_at_the_very_start() {
        assert!(find_separation(&|x| x > 0.0) < 1e-20);
    }

    #[test]
    fn find_root_brackets_smooth_roots_and_jumps() {
        for (root, value) in [
            (0.5_f64.sqrt(), (|x| 0.5 - x * x) as fn(f64) -> f64),
            (1e-9, |x| (1e-9 - x) * (2.0 + x)),
            (0.1, |x| if x < 0.1 { 1.0 } else { -1e6 }),
            (0.9, |x| (0.9 - x) * (0.9 - x) * (0.9 - x)),
        ] {
            let evaluations = std::cell::Cell::new(0);
            let counted = |x: f64| {
                evaluations.set(evaluations.get() + 1);
                value(x)
            };
            let found = root_of(&counted, 0.0);
            assert!((found - root).abs() <= 1e-4 * root && value(found) <= 0.0, "{root}: {found:e}");
            assert!(evaluations.get() <= 60, "{root}: {} evaluations", evaluations.get());
        }
        assert!((root_of(&|x| 0.5 - x * x, 0.0) - 0.5_f64.sqrt()).abs() < 1e-15);
    }

    /// With a tolerance, a root is a point with a value between 0 and the tolerance. A value that begins within the tolerance
    /// and rises has its root behind the maximum.
    #[test]
    fn find_root_ends_within_the_tolerance() {
        let falling = |x: f64| (-3.0 * x).exp() - 0.5;
        let found = root_of(&falling, 1e-3);
        assert!((0.0..=1e-3).contains(&falling(found)), "{found}");
        let rising_first = |x: f64| (x + 1e-6) * (0.9 - x);
        assert!((root_of(&rising_first, 1e-3) - 0.9).abs() < 1e-12);
    }

    #[test]
    fn find_root_returns_an_exact_root() {
        assert_eq!(root_of(&|x| 0.75 - x, 0.0), 0.75);
    }

    #[test]
    fn a_value_that_may_dip_is_detected_by_its_curvature() {
        let may_dip = |value: fn(f64) -> f64| may_dip_inside(value(0.0), value(1.0), THIRDS.map(value));
        assert!(!may_dip(|x| 1.0 + x), "straight");
        assert!(!may_dip(|x| 1.0 + 0.1 * x * (1.0 - x)), "slightly curved");
        assert!(may_dip(|x| 1.0 - 4.4 * x * (1.0 - x)), "negative at the midpoint");
        assert!(may_dip(|x| 1.0 + 15.0 * x * (x - 0.5) * (x - 1.0)), "antisymmetric about the midpoint");
        assert!(may_dip(|x| if x > 0.5 { f64::NAN } else { 1.0 }), "NaN");
    }
}
