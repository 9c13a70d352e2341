//! What a run records, and the times inside its steps at which it records: the uniform grid of the samples, and the points
//! of a check.

use super::schema::{Counts, Schema};
use super::{RequiredData, Sink};
use crate::scene::Scene;

/// Duration and sampling rate of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    pub end_s: f64,
    /// Samples per second on the grid; 0 without a grid.
    pub numeric_hz: f64,
    /// Whether long steps of a long run are sampled less densely.
    pub is_thinned: bool,
    /// Whether samples inside steps are read from the refined dense output. Otherwise each sample has a separate step;
    /// this applies to discs alone, whose restitution is compared more closely than the error of the dense output of a
    /// few 1e-5.
    pub is_refined: bool,
}

impl Span {
    /// A span without an end and without samples inside steps.
    pub const UNSAMPLED: Self = Span { end_s: f64::INFINITY, numeric_hz: 0.0, is_thinned: false, is_refined: false };

    /// Returns the duration and the sampling rate of a scene.
    pub fn from_scene(scene: &Scene, has_grid: bool) -> Self {
        // The object of a gripper is at rest in the grasp for most of a run.
        let is_thinned = scene.hand.fingers.len() > 1;
        let is_refined = !scene.hand.fingers.is_empty();
        let numeric_hz = if has_grid { scene.log.numeric_hz } else { 0.0 };
        Span { end_s: scene.duration_s, numeric_hz, is_thinned, is_refined }
    }
}

/// What a run records.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RecordingOptions {
    pub counts: Counts,
    pub span: Span,
    /// Whether the run ends when the object leaves the hand.
    pub ends_at_exit: bool,
    /// Normal force below which the criteria of a grasp count a contact as lost, N.
    pub threshold_n: Option<f64>,
    pub required_data: RequiredData,
}

impl RecordingOptions {
    /// Options of a run of a scene into a sink.
    pub fn of_run(scene: &Scene, sink: &dyn Sink) -> Self {
        let required_data = sink.required_data();
        let has_grasp = scene.finger_count() == 2 || scene.thresholds.loss_force_n > 0.0;
        Self {
            counts: Schema::from_scene(scene).counts(),
            span: Span::from_scene(scene, required_data.grid),
            ends_at_exit: true,
            threshold_n: has_grasp.then_some(scene.thresholds.loss_force_n),
            required_data,
        }
    }
}

/// Largest number of samples for which a run keeps its full grid.
const MAX_UNTHINNED_SAMPLES: f64 = 1000.0;
/// Upper bound of the grid points within one step of a longer run; a thinned step keeps at least half as many. Seconds
/// of transport, in which nothing happens and steps are long, do not need 10,000 samples each.
const MAX_POINTS_PER_STEP: u64 = 8;

/// The remaining grid points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    interval_s: f64,
    /// Index of the next point from the start of the run; the start itself is not a grid point.
    next: u64,
    /// Every `stride`-th point is used: a power of 2, so that the points of longer steps are a subset of those of
    /// shorter ones.
    stride: u64,
    /// Whether long steps are thinned.
    is_long: bool,
}

impl Grid {
    pub fn new(span: Span) -> Self {
        let is_long = span.is_thinned && span.end_s * span.numeric_hz > MAX_UNTHINNED_SAMPLES;
        Self { interval_s: 1.0 / span.numeric_hz, next: 1, stride: 1, is_long }
    }

    /// Grid without thinning; an interval of 0 has no points.
    fn with_interval(interval_s: f64) -> Self {
        let interval_s = if interval_s > 0.0 { interval_s } else { f64::INFINITY };
        Self { interval_s, next: 1, stride: 1, is_long: false }
    }

    /// Time of the next grid point.
    fn peek(&self) -> f64 {
        self.next.next_multiple_of(self.stride) as f64 * self.interval_s
    }

    /// Starts a step that ends at `end_s`.
    pub(crate) fn begin_step(&mut self, end_s: f64) {
        let points = ((end_s / self.interval_s) as u64).saturating_sub(self.next - 1);
        self.stride = if self.is_long && points >= MAX_POINTS_PER_STEP {
            1 << (2 * points / MAX_POINTS_PER_STEP).ilog2()
        } else {
            1
        };
    }

    /// Returns the next grid point and advances, if the point lies before `end_s`.
    pub(crate) fn next_before(&mut self, end_s: f64) -> Option<f64> {
        let t = self.peek();
        if t < end_s {
            self.next = self.next.next_multiple_of(self.stride) + 1;
            return Some(t);
        }
        if self.stride > 1 {
            // Skip the omitted points of the step; the index may be off by one from rounding.
            self.next = self.next.max((end_s / self.interval_s) as u64);
            self.next += u64::from((self.next as f64 * self.interval_s) < end_s);
        }
        None
    }

    /// Skips the next point if it is the end of a step, which has a sample anyway.
    pub(crate) fn pass_end(&mut self, end_s: f64) {
        self.next += u64::from(self.next as f64 * self.interval_s == end_s);
    }
}

/// Rounding error of a time, in intervals of its grid.
const ROUNDING: f64 = 1e-9;

/// A time inside a step at which the run records.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RecordingTime {
    pub time_s: f64,
    pub is_sample: bool,
    pub is_point: bool,
}

/// The remaining times at which a run records, in addition to the ends of its steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct RecordingTimes {
    samples: Grid,
    points: Grid,
}

impl RecordingTimes {
    /// Creates the times of the samples of a span, and of points at multiples of an interval; an interval of 0 gives no
    /// points.
    pub fn new(span: Span, point_interval_s: f64) -> Self {
        Self { samples: Grid::new(span), points: Grid::with_interval(point_interval_s) }
    }

    /// Starts a step that ends at `end_s`.
    pub fn begin_step(&mut self, end_s: f64) {
        self.samples.begin_step(end_s);
    }

    /// Returns the next time if it lies before `end_s`, and advances.
    pub fn next_before(&mut self, end_s: f64) -> Option<RecordingTime> {
        let time_s = self.samples.peek().min(self.points.peek());
        if time_s >= end_s {
            // Skips the samples that the step omits.
            self.samples.next_before(end_s);
            return None;
        }
        let [is_sample, is_point] = [&mut self.samples, &mut self.points]
            .map(|grid| grid.peek() == time_s && grid.next_before(end_s).is_some());
        Some(RecordingTime { time_s, is_sample, is_point })
    }

    /// Skips the times at the end of a step, because it has a sample anyway. Returns whether the end is a point.
    pub fn pass_end(&mut self, end_s: f64) -> bool {
        self.samples.pass_end(end_s);
        let is_point = (self.points.peek() - end_s).abs() < ROUNDING * self.points.interval_s;
        self.points.next += u64::from(is_point);
        is_point
    }
}

/// Whether a time is a grid point: exactly the product of an integer and the interval.
pub fn is_grid_point(t: f64, interval_s: f64) -> bool {
    (t / interval_s).round() * interval_s == t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_point_is_returned_once_and_ends_of_steps_are_passed() {
        let mut grid = Grid::new(Span { end_s: 2.0, numeric_hz: 4.0, is_thinned: true, is_refined: false });
        assert_eq!(grid.next_before(0.25), None);
        grid.pass_end(0.25);
        assert_eq!(
            (grid.next_before(0.8), grid.next_before(0.8), grid.next_before(0.8)),
            (Some(0.5), Some(0.75), None)
        );
        grid.pass_end(0.8);
        assert_eq!((grid.next_before(1.1), grid.next_before(1.1)), (Some(1.0), None));
    }

    #[test]
    fn points_are_returned_in_order_with_the_samples() {
        let span = Span { end_s: 2.0, numeric_hz: 4.0, is_thinned: false, is_refined: false };
        let mut times = RecordingTimes::new(span, 0.375);
        let mut before = |end_s: f64| {
            let times = std::iter::from_fn(|| times.next_before(end_s));
            times.map(|time| (time.time_s, time.is_sample, time.is_point)).collect::<Vec<_>>()
        };
        assert_eq!(before(0.5), [(0.25, true, false), (0.375, false, true)]);
        assert_eq!(before(0.8), [(0.5, true, false), (0.75, true, true)]);
        assert!(times.pass_end(1.125 + 1e-12), "the end of a step is a point within rounding");
        assert!(!times.pass_end(1.2));
        let mut without_points = RecordingTimes::new(Span { numeric_hz: 0.0, ..span }, 0.0);
        assert_eq!((without_points.next_before(1e9), without_points.pass_end(1e9)), (None, false));
    }

    /// Samples on the grid in a run whose steps end at `ends`, in units of the interval.
    fn points(end: f64, ends: &[f64]) -> Vec<f64> {
        let mut grid = Grid::new(Span { end_s: end, numeric_hz: 1.0, is_thinned: true, is_refined: false });
        let mut points = Vec::new();
        for &end in ends {
            grid.begin_step(end);
            points.extend(std::iter::from_fn(|| grid.next_before(end)));
            grid.pass_end(end);
            points.extend(is_grid_point(end, 1.0).then_some(end));
        }
        points
    }

    #[test]
    fn long_steps_of_long_runs_are_thinned() {
        let all: Vec<f64> = (1..=60).map(f64::from).collect();
        assert_eq!(points(1000.0, &[60.0]), all, "a run of 1000 points is not thinned");
        let found = points(1001.0, &[3.5, 10.0, 26.5, 27.0, 60.0]);
        let thinned = [12.0, 16.0, 20.0, 24.0, 27.0, 32.0, 40.0, 48.0, 56.0, 60.0];
        assert_eq!(found, [&all[..10], &thinned].concat());
        for length in 8..5000 {
            let count = points(1e6, &[f64::from(length) + 0.5]).len();
            assert!((4..8).contains(&count), "{length}: {count}");
        }
    }
}
