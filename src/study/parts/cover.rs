//! Whether parts are the whole of a study: nothing missing, nothing twice.

use crate::study::sweep::{Shard, range};

/// Runs that are in no part, and the parts that have them: those from `from` to `to` of `of`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap {
    pub first: u64,
    pub last: u64,
    pub from: u64,
    pub to: u64,
    pub of: u64,
}

/// Runs that are in two parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Overlap {
    pub file: String,
    pub other: String,
    pub first: u64,
    pub last: u64,
}

/// Runs that two parts have, of parts in the order of their first runs.
pub(super) fn overlaps(parts: &[(String, Shard)]) -> Vec<Overlap> {
    let mut found = Vec::new();
    // The one that reaches furthest so far.
    let mut before: Option<&(String, Shard)> = None;
    for part in parts.iter().filter(|(_, shard)| shard.runs() > 0) {
        let (file, shard) = part;
        if let Some((other, far)) = before
            && shard.first <= far.last
        {
            let last = shard.last.min(far.last);
            found.push(Overlap { file: other.clone(), other: file.clone(), first: shard.first, last });
        }
        if before.is_none_or(|(_, far)| shard.last > far.last) {
            before = Some(part);
        }
    }
    found
}

/// What is missing of so many runs, of parts in the order of their first runs.
pub(super) fn gaps(runs: u64, parts: &[Shard]) -> Vec<Gap> {
    let mut counts: Vec<u64> = parts.iter().map(|shard| shard.of).collect();
    counts.sort_unstable();
    counts.dedup();
    let mut found = Vec::new();
    let mut next = 1;
    for shard in parts.iter().filter(|shard| shard.runs() > 0) {
        if shard.first > next {
            found.push(gap(runs, next, shard.first - 1, &counts));
        }
        next = next.max(shard.last + 1);
    }
    if next <= runs {
        found.push(gap(runs, next, runs, &counts));
    }
    found
}

/// A gap, with parts of one of these counts that have its runs and no others. Between parts of different counts their least
/// common multiple does it; as many parts as runs always do.
fn gap(runs: u64, first: u64, last: u64, counts: &[u64]) -> Gap {
    let multiples =
        counts.iter().enumerate().flat_map(|(at, a)| counts[at + 1..].iter().filter_map(|b| multiple(*a, *b)));
    let fitting = counts.iter().copied().chain(multiples).find_map(|of| exact(runs, first, last, of));
    fitting.unwrap_or(Gap { first, last, from: first, to: last, of: runs })
}

/// Parts of `of` that have these runs and no others.
fn exact(runs: u64, first: u64, last: u64, of: u64) -> Option<Gap> {
    let (from, to) = (holding(runs, first, of), holding(runs, last, of));
    let fits = range(runs, from, of)?.first == first && range(runs, to, of)?.last == last;
    fits.then_some(Gap { first, last, from, to, of })
}

/// The part of `of` that has a run: the least whose last run is not before it.
fn holding(runs: u64, run: u64, of: u64) -> u64 {
    // last(number) = ⌊runs·number/of⌋ ≥ run where number ≥ run·of/runs.
    let number = (u128::from(run) * u128::from(of)).div_ceil(u128::from(runs.max(1)));
    u64::try_from(number).unwrap_or(u64::MAX)
}

/// The least common multiple, if it is a number.
fn multiple(a: u64, b: u64) -> Option<u64> {
    let (mut x, mut y) = (a, b);
    while y > 0 {
        (x, y) = (y, x % y);
    }
    (a / x.max(1)).checked_mul(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(runs: u64, parts: &[(u64, u64)]) -> Vec<Shard> {
        let mut found: Vec<Shard> =
            parts.iter().map(|&(number, of)| range(runs, number, of).expect("a part")).collect();
        found.sort_by_key(|shard| (shard.first, shard.last));
        found
    }

    #[test]
    fn what_is_missing_is_named_by_the_parts_that_have_it() {
        assert_eq!(gaps(100, &of(100, &[(1, 3), (2, 3), (3, 3)])), []);
        let one = Gap { first: 34, last: 66, from: 2, to: 2, of: 3 };
        assert_eq!(gaps(100, &of(100, &[(3, 3), (1, 3)])), [one]);
        assert_eq!(
            gaps(100, &of(100, &[(9, 10)])),
            [
                Gap { first: 1, last: 80, from: 1, to: 8, of: 10 },
                Gap { first: 91, last: 100, from: 10, to: 10, of: 10 }
            ]
        );
        // From the end of a third to the middle: one of sixths.
        let between = gaps(100, &of(100, &[(1, 3), (2, 2)]));
        assert_eq!(between, [Gap { first: 34, last: 50, from: 3, to: 3, of: 6 }]);
        // Parts without runs, of more parts than runs, lack nothing.
        let all: Vec<(u64, u64)> = (1..=7).map(|number| (number, 7)).collect();
        assert_eq!(gaps(3, &of(3, &all)), []);
        assert_eq!(gaps(3, &[]), [Gap { first: 1, last: 3, from: 1, to: 3, of: 3 }]);
    }

    #[test]
    fn the_parts_that_are_named_have_the_missing_runs_and_no_others() {
        for runs in [1, 2, 10, 97, 1000] {
            for (a, b) in [(1, 1), (2, 3), (7, 11), (13, 4), (200, 3)] {
                for missing in 1..=a {
                    let there: Vec<(u64, u64)> = (1..=a).filter(|at| *at != missing).map(|at| (at, a)).collect();
                    let mut parts = of(runs, &there);
                    // Of the other count too, as far as it goes beside these.
                    parts.extend(of(runs, &[(1, b)]));
                    parts.sort_by_key(|shard| (shard.first, shard.last));
                    let mut lacking = 0;
                    for gap in gaps(runs, &parts) {
                        let (from, to) = (range(runs, gap.from, gap.of), range(runs, gap.to, gap.of));
                        assert_eq!(from.map(|shard| shard.first), Some(gap.first), "{runs} {a} {b} {gap:?}");
                        assert_eq!(to.map(|shard| shard.last), Some(gap.last), "{runs} {a} {b} {gap:?}");
                        lacking += gap.last - gap.first + 1;
                    }
                    let has = |run: u64| parts.iter().any(|shard| (shard.first..=shard.last).contains(&run));
                    assert_eq!(lacking, (1..=runs).filter(|run| !has(*run)).count() as u64);
                }
            }
        }
    }

    #[test]
    fn what_is_there_twice_is_found_wherever_it_is() {
        let parts = |list: &[(u64, u64)]| -> Vec<(String, Shard)> {
            of(100, list).into_iter().map(|shard| (format!("{}/{}", shard.number, shard.of), shard)).collect()
        };
        assert_eq!(overlaps(&parts(&[(1, 2), (2, 2)])), []);
        let found = overlaps(&parts(&[(1, 1), (3, 10), (7, 10)]));
        let both: Vec<(&str, u64, u64)> =
            found.iter().map(|overlap| (overlap.other.as_str(), overlap.first, overlap.last)).collect();
        assert_eq!(both, [("3/10", 21, 30), ("7/10", 61, 70)]);
        assert!(found.iter().all(|overlap| overlap.file == "1/1"));
    }
}
