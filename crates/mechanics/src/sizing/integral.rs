//! Means and maxima of smooth functions over evenly spaced samples.

use crate::numeric::elementary::powi;

/// Composite Simpson rule over an interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct Simpson {
    from: f64,
    width: f64,
    intervals: usize,
}

impl Simpson {
    /// `intervals` is rounded up to an even number, at least 2.
    pub fn on_interval(from: f64, to: f64, intervals: usize) -> Self {
        Self { from, width: to - from, intervals: intervals.max(2).next_multiple_of(2) }
    }

    #[inline]
    fn node(&self, i: usize) -> f64 {
        self.from + self.width * (i as f64 / self.intervals as f64)
    }

    /// Mean of a function over the interval.
    #[inline]
    pub fn mean(&self, value: impl Fn(f64) -> f64) -> f64 {
        let n = self.intervals;
        let mut sum = value(self.node(0)) + value(self.node(n));
        for i in 1..n {
            sum += if i % 2 == 1 { 4.0 } else { 2.0 } * value(self.node(i));
        }
        sum / (3 * n) as f64
    }
}

/// Largest value of a function over the nodes, refined by the parabola through the largest and its two neighbours.
#[inline]
pub(super) fn find_maximum(nodes: &Simpson, value: impl Fn(f64) -> f64) -> f64 {
    let (mut best, mut at) = (f64::NEG_INFINITY, 0);
    for i in 0..=nodes.intervals {
        let sample = value(nodes.node(i));
        if sample > best || sample.is_nan() {
            (best, at) = (sample, i);
        }
    }
    if at == 0 || at == nodes.intervals {
        return best;
    }
    let (before, after) = (value(nodes.node(at - 1)), value(nodes.node(at + 1)));
    let curvature = before - 2.0 * best + after;
    if curvature < 0.0 { best - powi(after - before, 2) / (8.0 * curvature) } else { best }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simpson_is_exact_for_cubics() {
        let nodes = Simpson::on_interval(-1.0, 3.0, 3);
        assert!((nodes.mean(|x| x * x * x + 2.0 * x) - (20.0 + 8.0) / 4.0).abs() < 1e-14);
    }

    #[test]
    fn the_maximum_between_nodes_is_found() {
        let nodes = Simpson::on_interval(0.0, 1.0, 400);
        assert!((find_maximum(&nodes, |x| 1.0 - (x - 0.3333).powi(2)) - 1.0).abs() < 1e-15);
        assert!((find_maximum(&nodes, |x| (7.0 * x).sin()) - 1.0).abs() < 1e-8);
        assert_eq!(find_maximum(&nodes, |x| x), 1.0);
        assert_eq!(find_maximum(&nodes, |x| -x), 0.0);
    }
}
