//! The even grid of times at which a run is sampled, whatever its steps.

/// How long a run is, and how densely it is sampled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub end_s: f64,
    pub numeric_hz: f64,
}

/// The grid points that are still to come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    interval_s: f64,
    /// Counted from the start of the run; the start itself is no part of it.
    next: u64,
}

impl Grid {
    pub fn new(numeric_hz: f64) -> Self {
        Self { interval_s: 1.0 / numeric_hz, next: 1 }
    }

    /// Passes the next grid point, if it comes before `end_s`.
    pub fn before(&mut self, end_s: f64) -> Option<f64> {
        let t = self.next as f64 * self.interval_s;
        (t < end_s).then(|| {
            self.next += 1;
            t
        })
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
        let mut grid = Grid::new(4.0);
        assert_eq!(grid.before(0.25), None);
        assert!(grid.takes_end(0.25, 0.25));
        assert_eq!((grid.before(0.8), grid.before(0.8), grid.before(0.8)), (Some(0.5), Some(0.75), None));
        assert!(!grid.takes_end(0.8, 0.55));
        assert!(grid.takes_end(0.9, 0.1));
        assert_eq!((grid.before(1.1), grid.before(1.1)), (Some(1.0), None));
    }
}
