//! Selects the samples to retain if there are too many.

use std::collections::BTreeSet;

/// Maximum number of samples of a run in a page. With this number, two runs of a finger take 1.6 MB.
pub const MAX_SAMPLES: usize = 2000;

/// Number of samples retained before and after an event.
const SAMPLES_AROUND_EVENT: usize = 3;

/// Returns the sorted indices of the samples to retain: all samples, or `max_count` of them at most.
///
/// `times` and each of `curves` have one value per sample; times ascend. Retained are the first and the last sample,
/// the minimum and the maximum of every curve, and [`SAMPLES_AROUND_EVENT`] samples on both sides of events, up to half
/// of `max_count` in total (an evenly spaced subset of the events if there are more). The remaining places are
/// distributed evenly over the samples by index, not by time, so that a finely sampled impact remains finely sampled.
/// In each interval of indices the sample with the largest `weight` is retained, which preserves the peak of an impact.
pub(crate) fn select_samples(
    times: &[f64],
    events: &[f64],
    curves: &[Vec<f64>],
    weight: &[f64],
    max_count: usize,
) -> Vec<usize> {
    let count = times.len();
    if count <= max_count {
        return (0..count).collect();
    }
    let mut selected = BTreeSet::from([0, count - 1]);
    for curve in curves {
        let finite = || (0..count).filter(|&i| curve[i].is_finite());
        selected.extend(finite().min_by(|&a, &b| curve[a].total_cmp(&curve[b])));
        selected.extend(finite().max_by(|&a, &b| curve[a].total_cmp(&curve[b])));
    }
    let event_capacity = (max_count / 2).saturating_sub(selected.len()) / (2 * SAMPLES_AROUND_EVENT);
    let stride = events.len().div_ceil(event_capacity.max(1)).max(1);
    for &event in events.iter().step_by(stride) {
        let after = times.partition_point(|&time| time < event);
        selected.extend(after.saturating_sub(SAMPLES_AROUND_EVENT)..(after + SAMPLES_AROUND_EVENT).min(count));
    }
    let interval_count = max_count.saturating_sub(selected.len()).max(1);
    for interval in 0..interval_count {
        let from = interval * count / interval_count;
        let to = (interval + 1) * count / interval_count;
        // `max_by` returns the last of equal elements; `rev` makes it the first.
        selected.extend((from..to).rev().max_by(|&a, &b| weight[a].total_cmp(&weight[b])));
    }
    selected.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn retains_all_samples_of_a_short_run() {
        assert_eq!(select_samples(&[0.0, 1.0, 2.0], &[1.0], &[], &[0.0; 3], 3), [0, 1, 2]);
    }

    #[test]
    fn retains_ends_extremes_peaks_and_events() {
        let times: Vec<f64> = (0..10_000).map(f64::from).collect();
        let mut curve = vec![0.0; 10_000];
        (curve[1234], curve[4321]) = (7.0, -7.0);
        let mut weight = vec![0.0; 10_000];
        for sample_index in (50..10_000).step_by(100) {
            weight[sample_index] = sample_index as f64;
        }
        let selected = select_samples(&times, &[777.5, 9000.0], &[curve, vec![f64::INFINITY; 10_000]], &weight, 500);
        assert!(selected.len() <= 500 && selected.len() > 400, "{}", selected.len());
        assert!(selected.is_sorted_by(|a, b| a < b));
        for index in [0, 9999, 1234, 4321, 775, 776, 777, 778, 779, 780, 8997, 9000, 9002] {
            assert!(selected.contains(&index), "{index}");
        }
        assert!((50..10_000).step_by(100).all(|peak| selected.contains(&peak)));
        let widest = selected.windows(2).map(|pair| pair[1] - pair[0]).max();
        assert!(widest < Some(60), "{widest:?}");
    }

    #[test]
    fn many_events_do_not_use_all_places() {
        let times: Vec<f64> = (0..20_000).map(f64::from).collect();
        let selected = select_samples(&times, &times, &[], &vec![0.0; 20_000], 600);
        assert!(selected.len() <= 600 && selected.len() > 500, "{}", selected.len());
        let widest = selected.windows(2).map(|pair| pair[1] - pair[0]).max();
        assert!(widest < Some(150), "{widest:?}");
    }
}
