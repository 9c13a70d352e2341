//! Extremes within one step.

/// Steps whose force comes within this fraction of the peak so far are searched for a higher one.
pub(super) const SEARCH_FROM: f64 = 0.8;

/// Where a rate that starts positive and ends negative is zero.
pub(super) fn bisect(mut rate: impl FnMut(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if rate(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Largest value that successive parabolas find of a smooth function on 0…1, its given ends included.
pub(super) fn parabola_peak(at_start: f64, at_end: f64, mut value: impl FnMut(f64) -> f64) -> f64 {
    let mut points = [(0.0, at_start), (0.5, value(0.5)), (1.0, at_end)];
    let mut highest = points.iter().map(|p| p.1).fold(f64::MIN, f64::max);
    for _ in 0..3 {
        let [(a, fa), (b, fb), (c, fc)] = points;
        let (p, q) = ((b - a) * (fb - fc), (b - c) * (fb - fa));
        let vertex = b - 0.5 * ((b - a) * p - (b - c) * q) / (p - q);
        if !(vertex > a && vertex < c) || (vertex - b).abs() < 1e-4 {
            break;
        }
        let at = value(vertex);
        highest = highest.max(at);
        points = if vertex < b { [(a, fa), (vertex, at), (b, fb)] } else { [(b, fb), (vertex, at), (c, fc)] };
        if at < fb {
            // The middle point was higher: keep it in the middle.
            points = if vertex < b { [(vertex, at), (b, fb), (c, fc)] } else { [(a, fa), (b, fb), (vertex, at)] };
        }
    }
    highest
}
