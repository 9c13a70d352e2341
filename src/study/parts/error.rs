//! Errors while writing or merging parts.

use std::fmt::Display;

use super::coverage::{Gap, Overlap};
use crate::study::sweep::ShardError;

/// Maximum number of entries of a list in a message.
const MAX_LISTED: usize = 20;

/// Error while writing or merging parts.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PartError {
    #[error(transparent)]
    Shard(#[from] ShardError),
    /// The output path is unusable.
    #[error("cannot write {file}: {reason}")]
    InvalidPath { file: String, reason: String },
    /// Writing failed.
    #[error("cannot write {file}: {reason}")]
    Write { file: String, reason: String },
    #[error("cannot read {file}: {reason}")]
    Read { file: String, reason: String },
    #[error(
        "{file} is not a shard of a sweep: {reason}; give files written by `phalanx sweep STUDY --shard K/N --out SHARD.parquet`"
    )]
    NotAPart { file: String, reason: String },
    #[error("{file} is damaged: {reason}; delete it and run the shard again")]
    Damaged { file: String, reason: String },
    /// The output path contains something else.
    #[error("{file} already exists, but {reason}, so it is not replaced; {help}")]
    AlreadyExists { file: String, reason: String, help: &'static str },
    #[error("{}", foreign_message(.parts))]
    Foreign {
        /// File and reason of each part.
        parts: Vec<(String, String)>,
    },
    #[error("{}", overlap_message(.overlaps))]
    Overlapping { overlaps: Vec<Overlap> },
    #[error("{}", missing_message(.gaps, *.runs))]
    Missing {
        gaps: Vec<Gap>,
        /// Number of runs of the study.
        runs: u64,
    },
    /// The operation was interrupted.
    #[error("stopped after {done} of {total} runs; no file was written")]
    Stopped { done: u64, total: u64 },
}

fn foreign_message(parts: &[(String, String)]) -> String {
    let entries = parts.iter().map(|(file, reason)| format!("{file} is not a shard of this study: {reason}"));
    list_message("", entries, "")
}

fn overlap_message(overlaps: &[Overlap]) -> String {
    let line = |Overlap { file, other_file, first, last }: &Overlap| {
        format!("{file} and {other_file} both contain {}", run_range(*first, *last))
    };
    list_message("shards overlap: ", overlaps.iter().map(line), "; remove one of each pair")
}

fn missing_message(gaps: &[Gap], total: u64) -> String {
    let line = |gap: &Gap| format!("{} ({})", run_range(gap.first, gap.last), shard_arguments(gap));
    let count: u64 = gaps.iter().map(|gap| gap.last - gap.first + 1).sum();
    list_message(&format!("{count} of {total} runs are in no shard: "), gaps.iter().map(line), "")
}

fn run_range(first: u64, last: u64) -> String {
    if first == last { format!("run {first}") } else { format!("runs {first} to {last}") }
}

/// Arguments that make the parts of a gap.
fn shard_arguments(Gap { first_shard, last_shard, shard_count, .. }: &Gap) -> String {
    match last_shard - first_shard {
        0 => format!("--shard {first_shard}/{shard_count}"),
        1 => format!("--shard {first_shard}/{shard_count} and {last_shard}/{shard_count}"),
        _ => format!("--shard {first_shard}/{shard_count} to {last_shard}/{shard_count}"),
    }
}

/// Joins the first entries of a list and states the number of the others.
fn list_message<T: Display>(prefix: &str, mut list: impl ExactSizeIterator<Item = T>, suffix: &str) -> String {
    let first: Vec<String> = list.by_ref().take(MAX_LISTED).map(|entry| entry.to_string()).collect();
    let more = list.len();
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    format!("{prefix}{}{more}{suffix}", first.join("; "))
}
