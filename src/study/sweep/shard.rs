//! Division of the runs of a study into parts for several machines. The runs of a part follow from its number alone, so
//! that the last part of a billion runs starts as fast as the first.

use serde::Serialize;

use super::{MAX_RUNS, Study};

/// One of `count` parts of a study: the runs from `first` to `last`, inclusive. A part without runs, which exists if
/// there are more parts than runs, has `last` < `first`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Shard {
    /// Number of the part, from 1.
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
    /// Number of runs in the part.
    pub fn runs(&self) -> u64 {
        if self.last < self.first { 0 } else { (self.last - self.first).saturating_add(1) }
    }
}

/// Error while dividing a study into parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShardError {
    #[error("there is no shard {number}/{count}: shards are numbered from 1/{0} to {0}/{0}", .count.max(&1))]
    Number { number: u64, count: u64 },
    #[error(
        "shard {number}/{count} has {runs} runs, but a part has at most {MAX_RUNS}, because it is stored in memory until it is written; give \
         at least {min_shard_count} shards"
    )]
    TooLarge { number: u64, count: u64, runs: u64, min_shard_count: u64 },
    #[error(
        "the study has {runs} runs, but an undivided sweep has at most {MAX_RUNS}, because they are sorted in memory; make it in \
         parts (--shard 1/{min_shard_count} to --shard {min_shard_count}/{min_shard_count}, or more of them) and join these with `phalanx sweep merge`, or \
         make only the first runs (--limit)"
    )]
    Whole { runs: u64, min_shard_count: u64 },
}

/// Returns part `number` of `count`. The parts differ by at most one run and together cover the study in order.
///
/// # Errors
/// Returns an error if there is no such part, or it has more than [`MAX_RUNS`] runs.
pub fn shard(study: &Study, number: u64, count: u64) -> Result<Shard, ShardError> {
    let shard = shard_range(study.runs(), number, count).ok_or(ShardError::Number { number, count })?;
    match shard.runs() {
        runs if runs > MAX_RUNS => {
            Err(ShardError::TooLarge { number, count, runs, min_shard_count: min_shard_count(study.runs()) })
        }
        _ => Ok(shard),
    }
}

/// Checks that the first `max_runs` runs of a study can be made undivided.
///
/// # Errors
/// Returns an error if there are more than [`MAX_RUNS`] runs.
pub fn check_unsharded(study: &Study, max_runs: u64) -> Result<(), ShardError> {
    let runs = study.runs().min(max_runs);
    if runs > MAX_RUNS {
        Err(ShardError::Whole { runs, min_shard_count: min_shard_count(study.runs()) })
    } else {
        Ok(())
    }
}

/// Returns part `number` of `count` of a study with this number of runs; `None` if there is no such part.
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
}
