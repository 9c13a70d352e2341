//! Execution and writing of a part.

use std::collections::HashSet;
use std::fs;
use std::path::Path;

use super::error::PartError;
use super::info::{PartInfo, open, verify_rows};
use crate::files;
use crate::study::sweep::{Row, RunStats, Shard, Study, Summary, run_range, sorted_table, summary};
use crate::table::{self, Format, RowGroupReader, Table, TableError};

/// Options for running a part of a study.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PartOptions {
    /// Number of threads; 0 for one per core.
    pub threads: usize,
    /// Whether to replace an existing part, of any study.
    pub restart: bool,
}

/// A finished part.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenPart {
    pub part: PartInfo,
    pub summary: Summary,
    /// Statistics of the runs; `None` if the part already existed.
    pub stats: Option<RunStats>,
}

/// Runs a part of a study and writes it atomically. An existing part is kept, so that repeating the call resumes a
/// sweep. Concurrent calls for the same part write the same bytes.
///
/// `keep_running` is polled during the runs and stops them when it returns false. `on_row` is called with every row, in
/// any order.
///
/// # Errors
/// Returns an error if the output path is unusable or contains other data, writing failed, or the runs were
/// interrupted.
pub fn write_part(
    study: &Study,
    shard: Shard,
    out: &Path,
    options: PartOptions,
    keep_running: &(dyn Fn() -> bool + Sync),
    mut on_row: impl FnMut(&Row) + Send,
) -> Result<WrittenPart, PartError> {
    let part = PartInfo::new(study, shard);
    check_path(out)?;
    if let Some(summary) = existing_summary(study, &part, out, options.restart)? {
        return Ok(WrittenPart { part, summary, stats: None });
    }
    let mut rows = Vec::new();
    let stats = run_range(study, options.threads, shard.first..=shard.last, &HashSet::new(), keep_running, |row| {
        on_row(&row);
        rows.push(row.cells);
        true
    });
    if !stats.complete {
        return Err(PartError::Stopped { done: stats.runs, total: shard.runs() });
    }
    let table = sorted_table(study, rows);
    let file = || out.display().to_string();
    let write_error = |error: TableError| match error {
        TableError::Write { file, reason } => PartError::Write { file, reason },
        error => PartError::Write { file: file(), reason: error.to_string() },
    };
    let summary = summary(&table).map_err(write_error)?;
    table::write_with_metadata(out, &table, &part.to_metadata()).map_err(write_error)?;
    Ok(WrittenPart { part, summary, stats: Some(stats) })
}

/// Checks that a part can be written to this path.
fn check_path(out: &Path) -> Result<(), PartError> {
    let invalid = |reason: String| Err(PartError::InvalidPath { file: out.display().to_string(), reason });
    match table::format(out) {
        Ok(Format::Parquet) => {}
        _ => {
            return invalid(
                "a shard is a Parquet file (NAME.parquet), because its metadata identify the study; `phalanx sweep merge` \
                 writes CSV from shards"
                    .to_string(),
            );
        }
    }
    if files::is_special(out) {
        return invalid("the path is not a regular file; give the name of a file".to_string());
    }
    files::check_writable(out).or_else(invalid)
}

/// Returns the summary of this part if it is already written. `None` means that `out` may be written: it is missing or
/// empty, or it is a part and `restart` is set.
fn existing_summary(study: &Study, part: &PartInfo, out: &Path, restart: bool) -> Result<Option<Summary>, PartError> {
    if !fs::metadata(out).is_ok_and(|metadata| metadata.len() > 0) {
        return Ok(None);
    }
    let already_exists =
        |reason: String, help| PartError::AlreadyExists { file: out.display().to_string(), reason, help };
    let (info, groups) = match open(out) {
        Ok(opened) => opened,
        Err(PartError::NotAPart { reason, .. }) => {
            let reason = format!("it is not a shard of a sweep ({reason})");
            return Err(already_exists(reason, "give another --out, or delete it first"));
        }
        Err(PartError::Damaged { .. }) if restart => return Ok(None),
        Err(error) => return Err(error),
    };
    if restart {
        return Ok(None);
    }
    let help = "give another --out, or replace it with --restart";
    if let Some(reason) = info.mismatch(study) {
        return Err(already_exists(format!("it is a shard of another sweep: {reason}"), help));
    }
    if info.shard != part.shard {
        let Shard { number, count, .. } = info.shard;
        return Err(already_exists(format!("it is shard {number}/{count} of this study"), help));
    }
    verify_rows(out, study, (&info, &groups))?;
    summarize(out, groups).map(Some)
}

/// Summary of the runs of a part.
fn summarize(path: &Path, mut groups: RowGroupReader) -> Result<Summary, PartError> {
    let columns = groups.columns().to_vec();
    let damaged =
        |error: TableError| PartError::Damaged { file: path.display().to_string(), reason: error.to_string() };
    let summary_of = |rows| summary(&Table::new(columns.clone(), rows)).map_err(damaged);
    let mut total = summary_of(Vec::new())?;
    while let Some(rows) = groups.next_group().map_err(damaged)? {
        total.add(summary_of(rows)?);
    }
    Ok(total)
}
