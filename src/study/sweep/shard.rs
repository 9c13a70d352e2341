//! Division of the runs of a study into parts for several machines. The runs of a part follow from its number alone, so
//! that the last part of a billion runs starts as fast as the first.

use serde::{Deserialize, Serialize};

use super::{MAX_RUNS, Study};

/// Maximum number of entries of a list in a message.
const MAX_LISTED: usize = 20;

/// One of `count` parts of a study: the runs from `first` to `last`, inclusive. If there are more parts than runs, some
/// parts are empty; they have `last` < `first`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Number of the part, counted from 1.
    #[serde(rename = "shard")]
    pub number: u64,
    #[serde(rename = "of")]
    pub count: u64,
    #[serde(rename = "first_run")]
    pub first: u64,
    #[serde(rename = "last_run")]
    pub last: u64,
}

impl Shard {
    pub fn runs(&self) -> u64 {
        if self.last < self.first { 0 } else { (self.last - self.first).saturating_add(1) }
    }
}

/// Returns part `number` of `count`; it has at most [`MAX_RUNS`] runs. The sizes of the parts differ by at most one
/// run. Together, the parts cover the study in order.
pub fn shard(study: &Study, number: u64, count: u64) -> Result<Shard, String> {
    let Some(shard) = shard_range(study.runs(), number, count) else {
        let last = count.max(1);
        return Err(format!("there is no shard {number}/{count}: shards are numbered from 1/{last} to {last}/{last}"));
    };
    match shard.runs() {
        0..=MAX_RUNS => Ok(shard),
        runs => Err(format!(
            "shard {number}/{count} has {runs} runs, but a part has at most {MAX_RUNS}, because it is stored in memory until \
             it is written; give at least {} shards",
            min_shard_count(study.runs())
        )),
    }
}

/// Checks that the first `max_runs` runs of a study can be performed undivided, that is, that there are at most
/// [`MAX_RUNS`].
pub fn check_unsharded(study: &Study, max_runs: u64) -> Result<(), String> {
    let (runs, count) = (study.runs().min(max_runs), min_shard_count(study.runs()));
    if runs <= MAX_RUNS {
        return Ok(());
    }
    Err(format!(
        "the study has {runs} runs, but an undivided sweep has at most {MAX_RUNS}, because they are sorted in memory; make it in \
         parts (--shard 1/{count} to --shard {count}/{count}, or more of them) and join these with `phalanx sweep merge`, or make \
         only the first runs (--limit)"
    ))
}

/// Returns part `number` of `count` of a study with `runs` runs; `None` if there is no such part.
pub fn shard_range(runs: u64, number: u64, count: u64) -> Option<Shard> {
    if number == 0 || number > count {
        return None;
    }
    // The product of two u64 fits in u128; the quotient is at most `runs`.
    let runs_before = |shards: u64| (u128::from(runs) * u128::from(shards) / u128::from(count)) as u64;
    Some(Shard { number, count, first: runs_before(number - 1) + 1, last: runs_before(number) })
}

/// Smallest number of parts such that no part exceeds [`MAX_RUNS`].
fn min_shard_count(runs: u64) -> u64 {
    runs.div_ceil(MAX_RUNS)
}

/// Finds runs that are in no part. A gap is the first and the last of consecutive shards that contain exactly its runs.
/// The parts are sorted by their first run.
pub(in crate::study) fn find_gaps(runs: u64, parts: &[Shard]) -> Vec<[Shard; 2]> {
    let mut gaps = Vec::new();
    let mut next = 1;
    let end = Shard { number: 0, count: 0, first: runs + 1, last: runs + 1 };
    for shard in parts.iter().filter(|shard| shard.runs() > 0).chain([&end]) {
        if shard.first > next {
            gaps.push(describe_gap(runs, next, shard.first - 1, parts));
        }
        next = next.max(shard.last + 1);
    }
    gaps
}

/// Describes a gap by shards of the number of shards of a part, of the smallest number, or of one shard for each run.
fn describe_gap(runs: u64, first: u64, last: u64, parts: &[Shard]) -> [Shard; 2] {
    // The shard of a run is the first whose last run ⌊runs·number/count⌋ is not before it.
    let shard_of_run = |run: u64, count: u64| {
        let number = (u128::from(run) * u128::from(count)).div_ceil(u128::from(runs));
        shard_range(runs, u64::try_from(number).ok()?, count)
    };
    let exact = |count: u64| {
        let (from, to) = (shard_of_run(first, count)?, shard_of_run(last, count)?);
        (from.first == first && to.last == last).then_some([from, to])
    };
    let mut counts: Vec<u64> = parts.iter().map(|part| part.count).collect();
    counts.sort_unstable();
    counts.dedup();
    let gap = counts.into_iter().chain(1..=10_000).chain([runs]).find_map(exact);
    gap.expect("each run is a shard of as many shards as runs")
}

/// Message that lists missing runs with the arguments that make their parts.
pub(in crate::study) fn missing_message(gaps: &[[Shard; 2]], total: u64) -> String {
    let line = |[from, to]: &[Shard; 2]| {
        let more = match to.number - from.number {
            0 => String::new(),
            1 => format!(" and {}/{}", to.number, to.count),
            _ => format!(" to {}/{}", to.number, to.count),
        };
        format!("{} (--shard {}/{}{more})", run_range_text(from.first, to.last), from.number, from.count)
    };
    let count: u64 = gaps.iter().map(|[from, to]| to.last - from.first + 1).sum();
    list_message(
        &format!("{count} of {total} runs are in no shard: "),
        gaps.iter().map(line).collect(),
        "; run these and merge again",
    )
}

pub(in crate::study) fn run_range_text(first: u64, last: u64) -> String {
    if first == last { format!("run {first}") } else { format!("runs {first} to {last}") }
}

/// Joins the first entries of a list and states the number of the others.
pub(in crate::study) fn list_message(prefix: &str, mut list: Vec<String>, suffix: &str) -> String {
    let more = list.len().saturating_sub(MAX_LISTED);
    list.truncate(MAX_LISTED);
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    format!("{prefix}{}{more}{suffix}", list.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_consecutive_and_of_equal_size() {
        for runs in [0, 1, 2, 7, 384, 1_000_003, 1_000_000_000_000] {
            for count in [1, 2, 3, 7, 1000, 4093] {
                let mut next = 1;
                let mut sizes = Vec::new();
                for number in 1..=count {
                    let shard = shard_range(runs, number, count).expect("a valid part");
                    assert_eq!(shard.first, next, "{runs} {number}/{count}");
                    next = shard.last + 1;
                    sizes.push(shard.runs());
                }
                assert_eq!(next, runs + 1);
                assert!(
                    sizes.iter().max().expect("sizes") - sizes.iter().min().expect("sizes") <= 1,
                    "{runs} / {count}"
                );
            }
        }
        assert_eq!(shard_range(u64::MAX - 1, u64::MAX, u64::MAX).map(|shard| shard.last), Some(u64::MAX - 1));
        assert_eq!([shard_range(10, 0, 3), shard_range(10, 4, 3), shard_range(10, 0, 0)], [None; 3]);
    }

    #[test]
    fn min_shard_count_is_minimal() {
        for runs in [1_000_001, 5_000_000, 999_999_999_999] {
            let count = min_shard_count(runs);
            let largest =
                |count: u64| (1..=count).filter_map(|number| shard_range(runs, number, count)).map(|s| s.runs()).max();
            assert!(largest(count) <= Some(MAX_RUNS) && largest(count - 1) > Some(MAX_RUNS), "{runs}: {count}");
        }
    }

    fn shards(runs: u64, parts: &[(u64, u64)]) -> Vec<Shard> {
        let part = |&(number, count): &(u64, u64)| shard_range(runs, number, count).expect("a valid part");
        let mut shards: Vec<Shard> = parts.iter().map(part).collect();
        shards.sort_by_key(|shard| (shard.first, shard.last));
        shards
    }

    #[test]
    fn shards_of_gaps_contain_exactly_the_missing_runs() {
        for runs in [1, 2, 10, 97, 1000] {
            for (a, b) in [(1, 1), (2, 3), (7, 11), (13, 4), (200, 3)] {
                for missing in 1..=a {
                    // All parts but one, and a part of a division into another number of parts.
                    let present = (1..=a).filter(|number| *number != missing).map(|number| (number, a));
                    let parts = shards(runs, &present.chain([(1, b)]).collect::<Vec<_>>());
                    let mut missing_runs = 0;
                    let is_covered = |run: u64| parts.iter().any(|shard| (shard.first..=shard.last).contains(&run));
                    for [from, to] in find_gaps(runs, &parts) {
                        assert_eq!(shard_range(runs, from.number, from.count), Some(from), "{runs} {a} {b}");
                        assert_eq!(shard_range(runs, to.number, from.count), Some(to), "{runs} {a} {b}");
                        assert!(!(from.first..=to.last).any(is_covered), "{runs} {a} {b} {from:?} {to:?}");
                        missing_runs += to.last - from.first + 1;
                    }
                    assert_eq!(missing_runs, (1..=runs).filter(|run| !is_covered(*run)).count() as u64);
                }
            }
        }
    }
}
