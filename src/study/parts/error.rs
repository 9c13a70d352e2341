//! What can be wrong with a part, or with all of them together.

use std::fmt::Display;

use super::cover::{Gap, Overlap};
use crate::study::sweep::ShardError;

/// Of a long list as many are named.
const NAMED: usize = 20;

/// Why a part, or the results of a whole study, cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PartError {
    #[error(transparent)]
    Shard(#[from] ShardError),
    /// A place where no file can be.
    #[error("cannot write {file}: {reason}")]
    Place { file: String, reason: String },
    /// Writing broke off.
    #[error("cannot write {file}: {reason}")]
    Write { file: String, reason: String },
    #[error("cannot read {file}: {reason}")]
    Read { file: String, reason: String },
    #[error(
        "{file} is not a part of a sweep: {reason}; a part is what `phalanx sweep STUDY --shard K/N --out PART.parquet` writes"
    )]
    NotAPart { file: String, reason: String },
    #[error("{file} is damaged: {reason}; delete it and make that part again")]
    Damaged { file: String, reason: String },
    /// Something is where a part is to be.
    #[error("{file} is there already, and {reason}, so it is left alone; {help}")]
    Taken { file: String, reason: String, help: &'static str },
    #[error("{}", foreign(.parts))]
    Foreign {
        /// File and reason of each.
        parts: Vec<(String, String)>,
    },
    #[error("{}", overlapping(.overlaps))]
    Overlapping { overlaps: Vec<Overlap> },
    #[error("{}", missing(.gaps, *.runs))]
    Missing {
        gaps: Vec<Gap>,
        /// Of the whole study.
        runs: u64,
    },
    /// It was told to stop.
    #[error("stopped after {done} of {of} runs; no file was written")]
    Stopped { done: u64, of: u64 },
}

fn foreign(parts: &[(String, String)]) -> String {
    let which = parts.iter().map(|(file, reason)| format!("{file} is no part of this study: {reason}"));
    named("", which, "")
}

fn overlapping(overlaps: &[Overlap]) -> String {
    let line = |Overlap { file, other, first, last }: &Overlap| {
        format!("{file} and {other} both have {}", runs(*first, *last))
    };
    named("parts overlap: ", overlaps.iter().map(line), "; leave out one of each two")
}

fn missing(gaps: &[Gap], all: u64) -> String {
    let line = |gap: &Gap| format!("{} ({})", runs(gap.first, gap.last), shards(gap));
    let count: u64 = gaps.iter().map(|gap| gap.last - gap.first + 1).sum();
    named(&format!("{count} of {all} runs are in no part: "), gaps.iter().map(line), "")
}

fn runs(first: u64, last: u64) -> String {
    if first == last { format!("run {first}") } else { format!("runs {first} to {last}") }
}

/// The parts that a gap lacks, as arguments.
fn shards(Gap { from, to, of, .. }: &Gap) -> String {
    match to - from {
        0 => format!("--shard {from}/{of}"),
        1 => format!("--shard {from}/{of} and {to}/{of}"),
        _ => format!("--shard {from}/{of} to {to}/{of}"),
    }
}

/// The first of a list, and how many more there are.
fn named<T: Display>(before: &str, mut list: impl ExactSizeIterator<Item = T>, after: &str) -> String {
    let first: Vec<String> = list.by_ref().take(NAMED).map(|one| one.to_string()).collect();
    let more = list.len();
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    format!("{before}{}{more}{after}", first.join("; "))
}
