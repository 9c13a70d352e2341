//! Decimation of curves to the resolution of a picture.

use super::axis::Axis;

/// Number of columns in which a decimated line retains its ends and extremes.
const COLUMNS: usize = 1200;

/// Converts the points (time in s, value) of a quantity to (time in ms, coordinate on the axis) and decimates them.
pub fn time_series(points: impl Iterator<Item = (f64, f64)>, y: &Axis) -> Vec<(f64, f64)> {
    let finite = points.filter(|(_, value)| value.is_finite());
    decimate(finite.map(|(time_s, value)| (time_s * 1e3, y.coordinate(value))).collect())
}

/// Retains the first, lowest, highest and last point of every column; `points` must be sorted by x.
pub fn decimate(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let (Some(&(from, _)), Some(&(to, _))) = (points.first(), points.last()) else { return points };
    if points.len() <= 4 * COLUMNS || to <= from {
        return points;
    }
    let column = |x: f64| ((x - from) / (to - from) * COLUMNS as f64) as usize;
    let mut decimated = Vec::with_capacity(4 * COLUMNS);
    for group in points.chunk_by(|a, b| column(a.0) == column(b.0)) {
        let low = (0..group.len()).min_by(|&a, &b| group[a].1.total_cmp(&group[b].1)).unwrap_or(0);
        let high = (0..group.len()).max_by(|&a, &b| group[a].1.total_cmp(&group[b].1)).unwrap_or(0);
        let mut chosen = [0, low.min(high), low.max(high), group.len() - 1].to_vec();
        chosen.dedup();
        decimated.extend(chosen.into_iter().map(|index| group[index]));
    }
    decimated
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimation_retains_ends_and_spikes() {
        let mut points: Vec<(f64, f64)> = (0..100_000).map(|k| (f64::from(k), 1.0)).collect();
        points[54_321].1 = 7.0;
        points[54_325].1 = -7.0;
        let decimated_points = decimate(points.clone());
        assert!(decimated_points.len() <= 4 * COLUMNS + 4);
        assert_eq!((decimated_points[0], decimated_points[decimated_points.len() - 1]), (points[0], points[99_999]));
        assert!(decimated_points.contains(&points[54_321]) && decimated_points.contains(&points[54_325]));
        assert!(decimated_points.is_sorted_by(|a, b| a.0 <= b.0));
    }
}
