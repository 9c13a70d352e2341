//! The even grid of times at which a run is sampled, whatever its steps.

use crate::scene::Scene;

/// How long a run is, and how densely it is sampled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub end_s: f64,
    pub numeric_hz: f64,
    /// Whether long steps of a long run are sampled less densely.
    pub thins: bool,
}

impl Span {
    /// As a scene says it.
    pub fn of(scene: &Scene) -> Self {
        // What a gripper carries is at rest in the hand for most of a run.
        let thins = scene.system.fingers.len() > 1;
        Span { end_s: scene.duration_s, numeric_hz: scene.log.numeric_hz, thins }
    }
}

/// Samples up to which a run has all of its grid.
const FEW: f64 = 1000.0;
/// In a longer run no step gets this many, and one that would gets at least half of them: seconds of carrying, in which steps are long
/// because nothing happens, are not worth 10,000 samples each.
const MOST_OF_A_STEP: u64 = 8;

/// The grid points that are still to come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    interval_s: f64,
    /// Counted from the start of the run; the start itself is no part of it.
    next: u64,
    /// Of these many points one is passed: a power of 2, so that longer steps have points of shorter ones.
    stride: u64,
    /// Whether it is thinned.
    is_long: bool,
}

impl Grid {
    pub fn new(span: Span) -> Self {
        let is_long = span.thins && span.end_s * span.numeric_hz > FEW;
        Self { interval_s: 1.0 / span.numeric_hz, next: 1, stride: 1, is_long }
    }

    /// Begins a step that lasts until `end_s`.
    pub fn begin_step(&mut self, end_s: f64) {
        let points = ((end_s / self.interval_s) as u64).saturating_sub(self.next - 1);
        self.stride =
            if self.is_long && points >= MOST_OF_A_STEP { 1 << (2 * points / MOST_OF_A_STEP).ilog2() } else { 1 };
    }

    /// Passes the next grid point, if it comes before `end_s`.
    pub fn before(&mut self, end_s: f64) -> Option<f64> {
        let next = self.next.next_multiple_of(self.stride);
        let t = next as f64 * self.interval_s;
        if t < end_s {
            self.next = next + 1;
            return Some(t);
        }
        if self.stride > 1 {
            // Those of the step that are left out; the count may be a last digit off.
            self.next = self.next.max((end_s / self.interval_s) as u64);
            self.next += u64::from((self.next as f64 * self.interval_s) < end_s);
        }
        None
    }

    /// Whether the end of a step of length `h` gets a sample of its own: it lies on the grid, which then is passed, or the
    /// step is shorter than the grid's interval.
    pub fn takes_end(&mut self, end_s: f64, h: f64) -> bool {
        let on_grid = self.next as f64 * self.interval_s == end_s;
        if on_grid {
            self.next += 1;
        }
        on_grid || h < self.interval_s
    }
}

/// Whether a time is one that a grid gives: the very product of a count and the interval.
pub(super) fn is_point(t: f64, interval_s: f64) -> bool {
    (t / interval_s).round() * interval_s == t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_passed_once_and_ends_that_lie_on_one_are_taken() {
        let mut grid = Grid::new(Span { end_s: 2.0, numeric_hz: 4.0, thins: true });
        assert_eq!(grid.before(0.25), None);
        assert!(grid.takes_end(0.25, 0.25));
        assert_eq!((grid.before(0.8), grid.before(0.8), grid.before(0.8)), (Some(0.5), Some(0.75), None));
        assert!(!grid.takes_end(0.8, 0.55));
        assert!(grid.takes_end(0.9, 0.1));
        assert_eq!((grid.before(1.1), grid.before(1.1)), (Some(1.0), None));
    }

    /// Points of a run, in units of its interval, whose steps end at these places.
    fn points(end: f64, ends: &[f64]) -> Vec<f64> {
        let mut grid = Grid::new(Span { end_s: end, numeric_hz: 1.0, thins: true });
        let (mut points, mut start) = (Vec::new(), 0.0);
        for &end in ends {
            grid.begin_step(end);
            points.extend(std::iter::from_fn(|| grid.before(end)));
            if grid.takes_end(end, end - start) {
                points.push(end);
            }
            start = end;
        }
        points
    }

    #[test]
    fn long_steps_of_long_runs_get_a_few_points() {
        let all: Vec<f64> = (1..=60).map(f64::from).collect();
        assert_eq!(points(1000.0, &[60.0]), all, "a run of a thousand has all of them");
        let few = points(1001.0, &[3.5, 10.0, 26.5, 27.0, 60.0]);
        let thinned = [12.0, 16.0, 20.0, 24.0, 27.0, 32.0, 40.0, 48.0, 56.0, 60.0];
        assert_eq!(few, [&all[..10], &thinned].concat());
        for length in 8..5000 {
            let found = points(1e6, &[f64::from(length) + 0.5]).len();
            assert!((4..8).contains(&found), "{length}: {found}");
        }
    }
}
