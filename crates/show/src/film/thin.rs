//! Which samples stay where there are too many.

use std::collections::BTreeSet;

/// Samples that a page holds of a run, at most.
///
/// Two runs of a finger are then 1.6 MB.
pub const MOST_SAMPLES: usize = 2000;

/// Samples kept before and after an event.
const AROUND: usize = 3;

/// Indices of the samples to keep, in order: all of them up to `most`, else at most `most`.
///
/// `times` and each of `curves` have one value a sample, times in order. Kept are the first and the last sample, the
/// smallest and the largest value of every curve, and [`AROUND`] samples on both sides of the events, which may take half
/// of the room together (of more events, some evenly spaced ones). The rest goes evenly to the others, by their number and
/// not by time, so that an impact that was sampled finely stays so; of each stretch the sample with the largest `weight`
/// is kept, so that a peak of an impact does not vanish.
pub fn kept(times: &[f64], events: &[f64], curves: &[Vec<f64>], weight: &[f64], most: usize) -> Vec<usize> {
    let count = times.len();
    if count <= most {
        return (0..count).collect();
    }
    let mut keep = BTreeSet::from([0, count - 1]);
    for curve in curves {
        let finite = || (0..count).filter(|&i| curve[i].is_finite());
        keep.extend(finite().min_by(|&a, &b| curve[a].total_cmp(&curve[b])));
        keep.extend(finite().max_by(|&a, &b| curve[a].total_cmp(&curve[b])));
    }
    let room = (most / 2).saturating_sub(keep.len()) / (2 * AROUND);
    let stride = events.len().div_ceil(room.max(1)).max(1);
    for &event in events.iter().step_by(stride) {
        let after = times.partition_point(|&time| time < event);
        keep.extend(after.saturating_sub(AROUND)..(after + AROUND).min(count));
    }
    let stretches = most.saturating_sub(keep.len()).max(1);
    for stretch in 0..stretches {
        let from = stretch * count / stretches;
        let to = (stretch + 1) * count / stretches;
        // The first of equals: `max_by` would take the last.
        keep.extend((from..to).rev().max_by(|&a, &b| weight[a].total_cmp(&weight[b])));
    }
    keep.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_run_stays_whole() {
        assert_eq!(kept(&[0.0, 1.0, 2.0], &[1.0], &[], &[0.0; 3], 3), [0, 1, 2]);
    }

    #[test]
    fn ends_extremes_peaks_and_events_stay() {
        let times: Vec<f64> = (0..10_000).map(f64::from).collect();
        let mut curve = vec![0.0; 10_000];
        (curve[1234], curve[4321]) = (7.0, -7.0);
        let mut weight = vec![0.0; 10_000];
        for at in (50..10_000).step_by(100) {
            weight[at] = at as f64;
        }
        let keep = kept(&times, &[777.5, 9000.0], &[curve, vec![f64::INFINITY; 10_000]], &weight, 500);
        assert!(keep.len() <= 500 && keep.len() > 400, "{}", keep.len());
        assert!(keep.is_sorted_by(|a, b| a < b));
        for wanted in [0, 9999, 1234, 4321, 775, 776, 777, 778, 779, 780, 8997, 9000, 9002] {
            assert!(keep.contains(&wanted), "{wanted}");
        }
        assert!((50..10_000).step_by(100).all(|peak| keep.contains(&peak)));
        let widest = keep.windows(2).map(|pair| pair[1] - pair[0]).max();
        assert!(widest < Some(60), "{widest:?}");
    }

    #[test]
    fn many_events_do_not_take_all_room() {
        let times: Vec<f64> = (0..20_000).map(f64::from).collect();
        let keep = kept(&times, &times, &[], &vec![0.0; 20_000], 600);
        assert!(keep.len() <= 600 && keep.len() > 500, "{}", keep.len());
        let widest = keep.windows(2).map(|pair| pair[1] - pair[0]).max();
        assert!(widest < Some(150), "{widest:?}");
    }
}
