//! Search for extrema within one step.

/// Steps whose force exceeds this fraction of the largest force so far are searched for a larger one.
pub(super) const MIN_SEARCHED_FORCE_FRACTION: f64 = 0.8;

/// Number of bisections of a step; they locate a time to 1e-12 of its length.
pub(super) const BISECTIONS: u32 = 40;

/// Returns the zero in [0, 1] of a rate that starts positive and ends negative.
pub(super) fn bisect(rate: &mut dyn FnMut(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if rate(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Returns position and value of the largest value of a smooth function on [0, 1], found by successive parabolic
/// interpolation; the end values are given.
pub(super) fn parabola_peak(at_start: f64, at_end: f64, value: &mut dyn FnMut(f64) -> f64) -> (f64, f64) {
    let mut points = [(0.0, at_start), (0.5, value(0.5)), (1.0, at_end)];
    let greater_value = |a: (f64, f64), b: (f64, f64)| if b.1 > a.1 { b } else { a };
    let mut peak = points.into_iter().fold((0.0, f64::MIN), greater_value);
    for _ in 0..3 {
        let [(a, fa), (b, fb), (c, fc)] = points;
        let (p, q) = ((b - a) * (fb - fc), (b - c) * (fb - fa));
        let vertex = b - 0.5 * ((b - a) * p - (b - c) * q) / (p - q);
        if !(vertex > a && vertex < c) || (vertex - b).abs() < 1e-4 {
            break;
        }
        let at_vertex = value(vertex);
        peak = greater_value(peak, (vertex, at_vertex));
        points =
            if vertex < b { [(a, fa), (vertex, at_vertex), (b, fb)] } else { [(b, fb), (vertex, at_vertex), (c, fc)] };
        if at_vertex < fb {
            // Keep the larger of the two inner points as the middle point.
            points = if vertex < b {
                [(vertex, at_vertex), (b, fb), (c, fc)]
            } else {
                [(a, fa), (b, fb), (vertex, at_vertex)]
            };
        }
    }
    peak
}

/// Positions within one step at which a penetration or a contact force exceeds all earlier values. A sample is emitted
/// at each of them, so that the extrema of the samples equal those in the summary of the run.
#[derive(Clone, Debug, Default)]
pub(super) struct StepPeaks {
    /// Fractions of the step, in (0, 1).
    inside: Vec<f64>,
    /// Whether the end of the step is also such a position.
    pub at_end: bool,
}

impl StepPeaks {
    pub fn clear(&mut self) {
        self.inside.clear();
        self.at_end = false;
    }

    /// Adds a fraction of the step; the start of the step is ignored.
    pub fn push(&mut self, theta: f64) {
        if theta >= 1.0 {
            self.at_end = true;
        } else if theta > 0.0 {
            self.inside.push(theta);
        }
    }

    /// Sorts the positions and removes duplicates.
    pub fn sort(&mut self) {
        self.inside.sort_by(f64::total_cmp);
        self.inside.dedup();
    }

    /// Removes and returns the first position if it lies before `theta`.
    pub fn next_before(&mut self, theta: f64) -> Option<f64> {
        match self.inside.first() {
            Some(&first) if first < theta => Some(self.inside.remove(0)),
            _ => None,
        }
    }
}
