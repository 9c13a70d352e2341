//! Parts of a study, for more than one machine: which runs each has. Found from its number alone, so that the last part of a
//! billion runs begins as soon as the first.

use serde::Serialize;

use super::{MOST_RUNS, Study};

/// One of `of` parts of a study: the runs from `first` to `last`, both among them. A part without runs, as there are where a
/// study has fewer runs than parts, ends before it begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Shard {
    /// Counted from 1.
    #[serde(rename = "shard")]
    pub number: u64,
    pub of: u64,
    #[serde(rename = "first_run")]
    pub first: u64,
    #[serde(rename = "last_run")]
    pub last: u64,
}

impl Shard {
    /// How many runs it has.
    pub fn runs(&self) -> u64 {
        if self.last < self.first { 0 } else { (self.last - self.first).saturating_add(1) }
    }
}

/// Why there is no such part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShardError {
    #[error("there is no shard {number}/{of}: shards are numbered from 1 to how many there are, 1/{0} to {0}/{0}", .of.max(&1))]
    Number { number: u64, of: u64 },
    #[error(
        "shard {number}/{of} has {runs} runs, but one part has at most {MOST_RUNS}: it is held in memory until it is written; \
         take more shards, at least {least} of them"
    )]
    TooLarge { number: u64, of: u64, runs: u64, least: u64 },
    #[error(
        "the study has {runs} runs, but a sweep in one piece has at most {MOST_RUNS}: they are sorted in memory; make it in \
         parts (--shard 1/{least} to --shard {least}/{least}, or more of them) and join these with `phalanx sweep merge`, or \
         make only the first runs (--limit)"
    )]
    Whole { runs: u64, least: u64 },
}

/// The part `number` of `of`: no two differ by more than one run, and together they are the study, in order.
///
/// # Errors
/// There is no such part, or it has more than [`MOST_RUNS`] runs.
pub fn shard(study: &Study, number: u64, of: u64) -> Result<Shard, ShardError> {
    let shard = range(study.runs(), number, of).ok_or(ShardError::Number { number, of })?;
    match shard.runs() {
        runs if runs > MOST_RUNS => Err(ShardError::TooLarge { number, of, runs, least: least(study.runs()) }),
        _ => Ok(shard),
    }
}

/// Refuses to make more runs of a study in one piece than are held in memory; `most`: how many are wanted at most.
///
/// # Errors
/// These are more than [`MOST_RUNS`].
pub fn in_one_piece(study: &Study, most: u64) -> Result<(), ShardError> {
    let runs = study.runs().min(most);
    if runs > MOST_RUNS { Err(ShardError::Whole { runs, least: least(study.runs()) }) } else { Ok(()) }
}

/// The runs of a part of so many runs; `None` if it has no such part.
pub fn range(runs: u64, number: u64, of: u64) -> Option<Shard> {
    if number == 0 || number > of {
        return None;
    }
    // Below 2^128: both are below 2^64. What comes out is at most `runs`.
    let before = |shards: u64| (u128::from(runs) * u128::from(shards) / u128::from(of)) as u64;
    Some(Shard { number, of, first: before(number - 1) + 1, last: before(number) })
}

/// The least number of parts that are not too large.
fn least(runs: u64) -> u64 {
    runs.div_ceil(MOST_RUNS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_follow_each_other_and_are_of_one_size() {
        for runs in [0, 1, 2, 7, 384, 1_000_003, 1_000_000_000_000] {
            for of in [1, 2, 3, 7, 1000, 4093] {
                let mut next = 1;
                let mut sizes = Vec::new();
                for number in 1..=of {
                    let shard = range(runs, number, of).expect("there is one");
                    assert_eq!(shard.first, next, "{runs} {number}/{of}");
                    next = shard.last + 1;
                    sizes.push(shard.runs());
                }
                assert_eq!(next, runs + 1);
                assert!(sizes.iter().max().expect("some") - sizes.iter().min().expect("some") <= 1, "{runs} / {of}");
            }
        }
        assert_eq!(range(u64::MAX - 1, u64::MAX, u64::MAX).map(|shard| shard.last), Some(u64::MAX - 1));
        assert_eq!([range(10, 0, 3), range(10, 4, 3), range(10, 0, 0)], [None; 3]);
    }

    #[test]
    fn the_least_number_of_parts_is_enough_and_one_less_is_not() {
        for runs in [1_000_001, 5_000_000, 999_999_999_999] {
            let of = least(runs);
            let most = |of: u64| (1..=of).filter_map(|number| range(runs, number, of)).map(|s| s.runs()).max();
            assert!(most(of) <= Some(MOST_RUNS) && most(of - 1) > Some(MOST_RUNS), "{runs}: {of}");
        }
    }
}
