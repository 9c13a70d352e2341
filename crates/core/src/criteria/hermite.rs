//! Cubic Hermite interpolation between two samples, and crossings of a level.

/// The cubic Hermite interpolant of one coordinate over one step.
#[derive(Clone, Copy, Debug)]
pub struct Hermite {
    start_s: f64,
    length_s: f64,
    /// Coefficients of 1, x, x², x³ with x = (t − start)/length in [0, 1].
    coefficients: [f64; 4],
}

/// Tolerance of crossing times, s.
pub(crate) const CROSSING_TOLERANCE_S: f64 = 1e-9;

impl Hermite {
    /// Creates the interpolant through (t0, q0) with rate v0 and (t1, q1) with rate v1; t1 > t0.
    pub fn new((t0, q0, v0): (f64, f64, f64), (t1, q1, v1): (f64, f64, f64)) -> Self {
        let length_s = t1 - t0;
        let (m0, m1) = (v0 * length_s, v1 * length_s);
        let rise = q1 - q0;
        Hermite { start_s: t0, length_s, coefficients: [q0, m0, 3.0 * rise - 2.0 * m0 - m1, m0 + m1 - 2.0 * rise] }
    }

    /// Returns the value at a time.
    pub fn value(&self, time_s: f64) -> f64 {
        self.evaluate((time_s - self.start_s) / self.length_s)
    }

    fn evaluate(&self, x: f64) -> f64 {
        let [a, b, c, d] = self.coefficients;
        a + x * (b + x * (c + x * d))
    }

    /// Appends all times within the step at which the cubic crosses `level`, to [`CROSSING_TOLERANCE_S`] or, in shorter
    /// steps, to the resolution of `f64`.
    ///
    /// The turning points split the step into monotone intervals, so bisection finds every crossing.
    pub fn crossings(&self, level: f64, times_s: &mut Vec<f64>) {
        let (turning_points, count) = self.turning_points();
        let mut from = 0.0;
        for &to in turning_points[..count].iter().chain(std::iter::once(&1.0)) {
            if let Some(x) = self.bisect(level, from, to) {
                times_s.push(self.start_s + x * self.length_s);
            }
            from = to;
        }
    }

    /// Returns the roots of the derivative b + 2c x + 3d x² in (0, 1) in ascending order, and their number.
    fn turning_points(&self) -> ([f64; 2], usize) {
        let [_, b, c, d] = self.coefficients;
        let mut roots = [f64::NAN; 2];
        let discriminant = c * c - 3.0 * b * d;
        if discriminant >= 0.0 {
            // Avoids differences of nearly equal numbers; d = 0 gives one root at infinity.
            let q = -(c + discriminant.sqrt().copysign(c));
            roots = [q / (3.0 * d), b / q];
        }
        let mut inside = [0.0; 2];
        let mut count = 0;
        for root in roots {
            if root > 0.0 && root < 1.0 {
                inside[count] = root;
                count += 1;
            }
        }
        inside[..count].sort_by(f64::total_cmp);
        (inside, count)
    }

    fn bisect(&self, level: f64, mut from: f64, mut to: f64) -> Option<f64> {
        let below_at_start = self.evaluate(from) < level;
        if below_at_start == (self.evaluate(to) < level) {
            return None;
        }
        let tolerance = (0.25 * CROSSING_TOLERANCE_S / self.length_s).max(f64::EPSILON);
        while to - from > tolerance {
            let middle = 0.5 * (from + to);
            if middle <= from || middle >= to {
                break;
            }
            if (self.evaluate(middle) < level) == below_at_start {
                from = middle;
            } else {
                to = middle;
            }
        }
        Some(0.5 * (from + to))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// q = (t − 1)(t − 2)(t − 3) and its rate; the interpolant must reproduce a cubic.
    fn cubic(t: f64) -> (f64, f64, f64) {
        let q = (t - 1.0) * (t - 2.0) * (t - 3.0);
        let v = (t - 2.0) * (t - 3.0) + (t - 1.0) * (t - 3.0) + (t - 1.0) * (t - 2.0);
        (t, q, v)
    }

    #[test]
    fn reproduces_a_cubic_and_finds_its_three_roots() {
        let hermite = Hermite::new(cubic(0.5), cubic(3.5));
        for t in [0.5, 0.9, 1.7, 2.2, 3.5] {
            assert!((hermite.value(t) - cubic(t).1).abs() < 1e-13);
        }
        let mut roots = Vec::new();
        hermite.crossings(0.0, &mut roots);
        assert_eq!(roots.len(), 3);
        for (root, expected) in roots.iter().zip([1.0, 2.0, 3.0]) {
            assert!((root - expected).abs() < CROSSING_TOLERANCE_S, "{root}");
        }
    }

    #[test]
    fn a_level_that_is_not_reached_has_no_crossing() {
        let mut roots = Vec::new();
        Hermite::new((0.0, 1.0, 0.0), (1.0, 1.0, 0.0)).crossings(0.5, &mut roots);
        Hermite::new((0.0, 1.0, 0.0), (1.0, 2.0, 0.0)).crossings(2.5, &mut roots);
        assert!(roots.is_empty());
    }

    #[test]
    fn a_minimum_between_samples_is_found() {
        // From 1 down and back to 1 within the step; the minimum 1 − 2/4 is in the middle.
        let mut roots = Vec::new();
        Hermite::new((0.0, 1.0, -2.0), (1.0, 1.0, 2.0)).crossings(0.75, &mut roots);
        assert_eq!(roots.len(), 2);
        assert!((roots[0] - (0.5 - 0.125f64.sqrt())).abs() < 1e-9);
        assert!((roots[1] - (0.5 + 0.125f64.sqrt())).abs() < 1e-9);
    }
}
