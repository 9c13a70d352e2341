//! Coverage of a study by parts: missing and duplicate runs.

use crate::study::sweep::{Shard, shard_range};

/// Runs that are in no part. Shards `first_shard` to `last_shard` of `shard_count` contain exactly these runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap {
    pub first: u64,
    pub last: u64,
    pub first_shard: u64,
    pub last_shard: u64,
    pub shard_count: u64,
}

/// Runs that are in two parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Overlap {
    pub file: String,
    pub other_file: String,
    pub first: u64,
    pub last: u64,
}

/// Finds runs that are in two parts. The parts are sorted by their first run.
pub(super) fn find_overlaps(parts: &[(String, Shard)]) -> Vec<Overlap> {
    let mut overlaps = Vec::new();
    // The part with the largest last run so far.
    let mut furthest: Option<&(String, Shard)> = None;
    for part in parts.iter().filter(|(_, shard)| shard.runs() > 0) {
        let (file, shard) = part;
        if let Some((previous, previous_shard)) = furthest
            && shard.first <= previous_shard.last
        {
            let last = shard.last.min(previous_shard.last);
            overlaps.push(Overlap { file: previous.clone(), other_file: file.clone(), first: shard.first, last });
        }
        if furthest.is_none_or(|(_, previous_shard)| shard.last > previous_shard.last) {
            furthest = Some(part);
        }
    }
    overlaps
}

/// Finds runs that are in no part. The parts are sorted by their first run.
pub(super) fn find_gaps(runs: u64, parts: &[Shard]) -> Vec<Gap> {
    let mut counts: Vec<u64> = parts.iter().map(|shard| shard.count).collect();
    counts.sort_unstable();
    counts.dedup();
    let mut gaps = Vec::new();
    let mut next = 1;
    for shard in parts.iter().filter(|shard| shard.runs() > 0) {
        if shard.first > next {
            gaps.push(make_gap(runs, next, shard.first - 1, &counts));
        }
        next = next.max(shard.last + 1);
    }
    if next <= runs {
        gaps.push(make_gap(runs, next, runs, &counts));
    }
    gaps
}

/// Describes a gap by shards that contain exactly its runs. The number of shards is one of `counts`, the least common
/// multiple of two of them, or the number of runs.
fn make_gap(runs: u64, first: u64, last: u64, counts: &[u64]) -> Gap {
    let multiples = counts
        .iter()
        .enumerate()
        .flat_map(|(index, a)| counts[index + 1..].iter().filter_map(|b| least_common_multiple(*a, *b)));
    let exact = counts.iter().copied().chain(multiples).find_map(|count| exact_shards(runs, first, last, count));
    exact.unwrap_or(Gap { first, last, first_shard: first, last_shard: last, shard_count: runs })
}

/// Finds shards of `count` that contain exactly these runs.
fn exact_shards(runs: u64, first: u64, last: u64, count: u64) -> Option<Gap> {
    let (first_shard, last_shard) = (shard_of_run(runs, first, count), shard_of_run(runs, last, count));
    let is_exact =
        shard_range(runs, first_shard, count)?.first == first && shard_range(runs, last_shard, count)?.last == last;
    is_exact.then_some(Gap { first, last, first_shard, last_shard, shard_count: count })
}

/// Number of the shard of `count` that contains a run: the first whose last run is not before it.
fn shard_of_run(runs: u64, run: u64, count: u64) -> u64 {
    // last(number) = ⌊runs·number/count⌋ ≥ run if number ≥ run·count/runs.
    let number = (u128::from(run) * u128::from(count)).div_ceil(u128::from(runs.max(1)));
    u64::try_from(number).unwrap_or(u64::MAX)
}

/// Least common multiple; `None` if it overflows.
fn least_common_multiple(a: u64, b: u64) -> Option<u64> {
    let (mut x, mut y) = (a, b);
    while y > 0 {
        (x, y) = (y, x % y);
    }
    (a / x.max(1)).checked_mul(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shards(runs: u64, parts: &[(u64, u64)]) -> Vec<Shard> {
        let mut shards: Vec<Shard> =
            parts.iter().map(|&(number, count)| shard_range(runs, number, count).expect("a valid part")).collect();
        shards.sort_by_key(|shard| (shard.first, shard.last));
        shards
    }

    #[test]
    fn gaps_are_described_by_shards() {
        assert_eq!(find_gaps(100, &shards(100, &[(1, 3), (2, 3), (3, 3)])), []);
        let second_third = Gap { first: 34, last: 66, first_shard: 2, last_shard: 2, shard_count: 3 };
        assert_eq!(find_gaps(100, &shards(100, &[(3, 3), (1, 3)])), [second_third]);
        assert_eq!(
            find_gaps(100, &shards(100, &[(9, 10)])),
            [
                Gap { first: 1, last: 80, first_shard: 1, last_shard: 8, shard_count: 10 },
                Gap { first: 91, last: 100, first_shard: 10, last_shard: 10, shard_count: 10 }
            ]
        );
        // The gap from a third to a half is the third sixth.
        let between = find_gaps(100, &shards(100, &[(1, 3), (2, 2)]));
        assert_eq!(between, [Gap { first: 34, last: 50, first_shard: 3, last_shard: 3, shard_count: 6 }]);
        // More parts than runs: the parts without runs leave no gap.
        let all: Vec<(u64, u64)> = (1..=7).map(|number| (number, 7)).collect();
        assert_eq!(find_gaps(3, &shards(3, &all)), []);
        assert_eq!(find_gaps(3, &[]), [Gap { first: 1, last: 3, first_shard: 1, last_shard: 3, shard_count: 3 }]);
    }

    #[test]
    fn shards_of_gaps_contain_exactly_the_missing_runs() {
        for runs in [1, 2, 10, 97, 1000] {
            for (a, b) in [(1, 1), (2, 3), (7, 11), (13, 4), (200, 3)] {
                for missing in 1..=a {
                    let present: Vec<(u64, u64)> =
                        (1..=a).filter(|number| *number != missing).map(|number| (number, a)).collect();
                    let mut parts = shards(runs, &present);
                    // Add a part of a division into another number of parts.
                    parts.extend(shards(runs, &[(1, b)]));
                    parts.sort_by_key(|shard| (shard.first, shard.last));
                    let mut missing_runs = 0;
                    for gap in find_gaps(runs, &parts) {
                        let (first, last) = (
                            shard_range(runs, gap.first_shard, gap.shard_count),
                            shard_range(runs, gap.last_shard, gap.shard_count),
                        );
                        assert_eq!(first.map(|shard| shard.first), Some(gap.first), "{runs} {a} {b} {gap:?}");
                        assert_eq!(last.map(|shard| shard.last), Some(gap.last), "{runs} {a} {b} {gap:?}");
                        missing_runs += gap.last - gap.first + 1;
                    }
                    let is_covered = |run: u64| parts.iter().any(|shard| (shard.first..=shard.last).contains(&run));
                    assert_eq!(missing_runs, (1..=runs).filter(|run| !is_covered(*run)).count() as u64);
                }
            }
        }
    }

    #[test]
    fn finds_all_overlaps() {
        let parts = |list: &[(u64, u64)]| -> Vec<(String, Shard)> {
            shards(100, list).into_iter().map(|shard| (format!("{}/{}", shard.number, shard.count), shard)).collect()
        };
        assert_eq!(find_overlaps(&parts(&[(1, 2), (2, 2)])), []);
        let overlaps = find_overlaps(&parts(&[(1, 1), (3, 10), (7, 10)]));
        let duplicates: Vec<(&str, u64, u64)> =
            overlaps.iter().map(|overlap| (overlap.other_file.as_str(), overlap.first, overlap.last)).collect();
        assert_eq!(duplicates, [("3/10", 21, 30), ("7/10", 61, 70)]);
        assert!(overlaps.iter().all(|overlap| overlap.file == "1/1"));
    }
}
