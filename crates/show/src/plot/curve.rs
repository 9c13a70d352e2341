//! Lines of as many points as a picture can show.

use super::axis::Axis;

/// Columns of a picture in which a line keeps its ends and extremes.
const COLUMNS: usize = 1200;

/// The points (time in s, value) of a quantity as (time in ms, place on the axis).
pub fn over_time(points: impl Iterator<Item = (f64, f64)>, y: &Axis) -> Vec<(f64, f64)> {
    let finite = points.filter(|(_, value)| value.is_finite());
    thin(finite.map(|(time_s, value)| (time_s * 1e3, y.place(value))).collect())
}

/// The first, lowest, highest and last point of every column; points come in order of x.
pub fn thin(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let (Some(&(from, _)), Some(&(to, _))) = (points.first(), points.last()) else { return points };
    if points.len() <= 4 * COLUMNS || to <= from {
        return points;
    }
    let column = |x: f64| ((x - from) / (to - from) * COLUMNS as f64) as usize;
    let mut kept = Vec::with_capacity(4 * COLUMNS);
    for group in points.chunk_by(|a, b| column(a.0) == column(b.0)) {
        let low = (0..group.len()).min_by(|&a, &b| group[a].1.total_cmp(&group[b].1)).unwrap_or(0);
        let high = (0..group.len()).max_by(|&a, &b| group[a].1.total_cmp(&group[b].1)).unwrap_or(0);
        let mut chosen = [0, low.min(high), low.max(high), group.len() - 1].to_vec();
        chosen.dedup();
        kept.extend(chosen.into_iter().map(|index| group[index]));
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_ends_and_spikes() {
        let mut points: Vec<(f64, f64)> = (0..100_000).map(|k| (f64::from(k), 1.0)).collect();
        points[54_321].1 = 7.0;
        points[54_325].1 = -7.0;
        let thinned = thin(points.clone());
        assert!(thinned.len() <= 4 * COLUMNS + 4);
        assert_eq!((thinned[0], thinned[thinned.len() - 1]), (points[0], points[99_999]));
        assert!(thinned.contains(&points[54_321]) && thinned.contains(&points[54_325]));
        assert!(thinned.is_sorted_by(|a, b| a.0 <= b.0));
    }
}
