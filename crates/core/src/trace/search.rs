//! Extremes within one step, and the samples that show them.

/// Steps whose force comes within this fraction of the peak so far are searched for a higher one.
pub(super) const SEARCH_FROM: f64 = 0.8;

/// Halvings of a step, which find a time within it to 1e-12 of its length.
pub(super) const BISECTIONS: u32 = 40;

/// Where a rate that starts positive and ends negative is zero.
pub(super) fn bisect(rate: &mut dyn FnMut(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if rate(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Place and size of the largest value that successive parabolas find of a smooth function on 0…1, its given ends included.
pub(super) fn parabola_peak(at_start: f64, at_end: f64, value: &mut dyn FnMut(f64) -> f64) -> (f64, f64) {
    let mut points = [(0.0, at_start), (0.5, value(0.5)), (1.0, at_end)];
    let higher = |a: (f64, f64), b: (f64, f64)| if b.1 > a.1 { b } else { a };
    let mut highest = points.into_iter().fold((0.0, f64::MIN), higher);
    for _ in 0..3 {
        let [(a, fa), (b, fb), (c, fc)] = points;
        let (p, q) = ((b - a) * (fb - fc), (b - c) * (fb - fa));
        let vertex = b - 0.5 * ((b - a) * p - (b - c) * q) / (p - q);
        if !(vertex > a && vertex < c) || (vertex - b).abs() < 1e-4 {
            break;
        }
        let at = value(vertex);
        highest = higher(highest, (vertex, at));
        points = if vertex < b { [(a, fa), (vertex, at), (b, fb)] } else { [(b, fb), (vertex, at), (c, fc)] };
        if at < fb {
            // The middle point was higher: keep it in the middle.
            points = if vertex < b { [(vertex, at), (b, fb), (c, fc)] } else { [(a, fa), (b, fb), (vertex, at)] };
        }
    }
    highest
}

/// Where within one step a site is deeper, or its force larger, than ever before: these places get samples of their own, so
/// that whoever has only the samples finds the same extremes as the summary of the run.
#[derive(Clone, Debug, Default)]
pub(super) struct Marks {
    /// Fractions of the step, 0…1 without its ends.
    inside: Vec<f64>,
    /// Whether there is such an extreme at the end of the step.
    pub at_end: bool,
}

impl Marks {
    pub fn clear(&mut self) {
        self.inside.clear();
        self.at_end = false;
    }

    /// Marks a fraction of the step; its start has been passed.
    pub fn push(&mut self, theta: f64) {
        if theta >= 1.0 {
            self.at_end = true;
        } else if theta > 0.0 {
            self.inside.push(theta);
        }
    }

    /// In order of time, each once.
    pub fn sort(&mut self) {
        self.inside.sort_by(f64::total_cmp);
        self.inside.dedup();
    }

    /// Takes out the first mark if it lies before `theta`.
    pub fn before(&mut self, theta: f64) -> Option<f64> {
        match self.inside.first() {
            Some(&first) if first < theta => Some(self.inside.remove(0)),
            _ => None,
        }
    }
}
