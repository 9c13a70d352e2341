//! Merge of parts into the results of a study.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::coverage::{find_gaps, find_overlaps};
use super::error::PartError;
use super::info::{open, verify_rows};
use crate::files::{self, ChecksumWriter, replace_file};
use crate::study::provenance::{Provenance, provenance_path, read_provenance};
use crate::study::sweep::{Shard, Study, Summary, columns, summary};
use crate::table::{self, Column, RowWriter, Table, Value};

/// Merged results.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MergeResult {
    /// Number of parts.
    pub parts: u64,
    /// Size of the results, bytes.
    pub bytes: u64,
    pub summary: Summary,
}

/// Merges parts, given as files or directories in any order, into the results of their study. `out` and its provenance
/// file have the same bytes as those of an undivided sweep. The parts may be of different shard counts, as long as they
/// contain every run exactly once.
///
/// `keep_running` is polled after each row group and stops the merge when it returns false. `on_progress` is called
/// with the number of rows written.
///
/// # Errors
/// Returns an error if a part is missing, damaged, duplicate or of another study; the output path is unusable or
/// contains other data; writing failed; or the merge was interrupted. In all cases `out` is unchanged.
pub fn merge(
    study: &Study,
    parts: &[PathBuf],
    out: &Path,
    keep_running: &dyn Fn() -> bool,
    on_progress: &mut dyn FnMut(u64),
) -> Result<MergeResult, PartError> {
    let format = check_output(study, out)?;
    let parts = complete_parts(study, parts)?;
    let mut state = MergeState { columns: columns(study), summary: empty_summary(&columns(study))?, rows: 0 };
    // Errors of the parts are returned separately from errors of the output file.
    let mut part_error = None;
    let mut bytes = 0;
    let written = replace_file(out, |file| {
        let mut file = ChecksumWriter::new(file);
        let mut writer = RowWriter::new(&mut file, format, &state.columns)?;
        for (path, shard) in &parts {
            let copied = state.copy(study, (path, *shard), &mut writer, keep_running, on_progress)?;
            if let Err(error) = copied {
                part_error = Some(error);
                return Err(io::ErrorKind::Other.into());
            }
        }
        writer.finish()?;
        bytes = file.bytes();
        // The provenance file is written first, so that results never exist without it.
        let text = Provenance::new(study, state.rows, file.crc()).to_json().map_err(io::Error::other)?;
        replace_file(&provenance_path(out), |file| file.write_all(text.as_bytes()))
    });
    if let Some(error) = part_error {
        return Err(error);
    }
    written.map_err(|error| PartError::Write { file: out.display().to_string(), reason: error.to_string() })?;
    Ok(MergeResult { parts: parts.len() as u64, bytes, summary: state.summary })
}

/// Checks that the results can be written to `out`, and returns their format.
fn check_output(study: &Study, out: &Path) -> Result<table::Format, PartError> {
    let file = || out.display().to_string();
    let invalid = |reason: String| PartError::InvalidPath { file: file(), reason };
    let format = table::format(out)
        .map_err(|_| invalid("the extension determines the format of a table: NAME.csv or NAME.parquet".to_string()))?;
    files::check_writable(out).map_err(invalid)?;
    let help = "give another --out, or delete it first";
    let already_exists =
        |file: String, reason: &str| PartError::AlreadyExists { file, reason: reason.to_string(), help };
    let provenance = read_provenance(out);
    if matches!(provenance, Some(Err(_))) {
        return Err(already_exists(provenance_path(out).display().to_string(), "it was not written by a sweep"));
    }
    if !fs::metadata(out).is_ok_and(|entry| entry.is_file() && entry.len() > 0) {
        return Ok(format);
    }
    match provenance {
        Some(Ok(provenance)) if !provenance.matches_file(out) => {
            Err(already_exists(file(), "it has been changed since a sweep wrote it"))
        }
        Some(Ok(provenance)) if provenance.fingerprint != study.fingerprint() => {
            Err(already_exists(file(), "it contains results of another study, model or version"))
        }
        Some(Ok(_)) => Ok(format),
        _ => Err(already_exists(file(), "it was not written by a sweep")),
    }
}

/// Opens the parts and returns them in the order of their runs; checks that they cover the study.
fn complete_parts(study: &Study, files: &[PathBuf]) -> Result<Vec<(PathBuf, Shard)>, PartError> {
    let (mut parts, mut foreign) = (Vec::new(), Vec::new());
    for path in part_files(files)? {
        let (info, _) = open(&path)?;
        match info.mismatch(study) {
            Some(reason) => foreign.push((path.display().to_string(), reason)),
            None => parts.push((path, info.shard)),
        }
    }
    if !foreign.is_empty() {
        return Err(PartError::Foreign { parts: foreign });
    }
    parts.sort_by(|(path_a, a), (path_b, b)| (a.first, a.last, path_a).cmp(&(b.first, b.last, path_b)));
    let named: Vec<(String, Shard)> = parts.iter().map(|(path, shard)| (path.display().to_string(), *shard)).collect();
    let overlaps = find_overlaps(&named);
    if !overlaps.is_empty() {
        return Err(PartError::Overlapping { overlaps });
    }
    let shards: Vec<Shard> = named.into_iter().map(|(_, shard)| shard).collect();
    let gaps = find_gaps(study.runs(), &shards);
    match gaps.is_empty() {
        true => Ok(parts),
        false => Err(PartError::Missing { gaps, runs: study.runs() }),
    }
}

/// Replaces directories by the Parquet files in them.
fn part_files(paths: &[PathBuf]) -> Result<Vec<PathBuf>, PartError> {
    let mut files = Vec::with_capacity(paths.len());
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let unreadable =
            |error: io::Error| PartError::Read { file: path.display().to_string(), reason: error.to_string() };
        let before = files.len();
        for entry in fs::read_dir(path).map_err(unreadable)? {
            let file = entry.map_err(unreadable)?.path();
            if matches!(table::format(&file), Ok(table::Format::Parquet)) {
                files.push(file);
            }
        }
        if files.len() == before {
            let reason = "the directory contains no Parquet file".to_string();
            return Err(PartError::NotAPart { file: path.display().to_string(), reason });
        }
    }
    Ok(files)
}

/// State of a merge.
struct MergeState {
    columns: Vec<Column>,
    summary: Summary,
    rows: u64,
}

impl MergeState {
    /// Copies the rows of a part. The outer error is an error of writing, the inner one of the part.
    fn copy(
        &mut self,
        study: &Study,
        (path, shard): (&Path, Shard),
        writer: &mut RowWriter<'_>,
        keep_running: &dyn Fn() -> bool,
        on_progress: &mut dyn FnMut(u64),
    ) -> io::Result<Result<(), PartError>> {
        let damaged = |reason: String| Ok(Err(PartError::Damaged { file: path.display().to_string(), reason }));
        let mut groups =
            match open(path).and_then(|(info, groups)| verify_rows(path, study, (&info, &groups)).map(|()| groups)) {
                Ok(groups) => groups,
                Err(error) => return Ok(Err(error)),
            };
        let mut next = shard.first;
        loop {
            if !keep_running() {
                return Ok(Err(PartError::Stopped { done: self.rows, total: study.runs() }));
            }
            let rows = match groups.next_group() {
                Ok(Some(rows)) => rows,
                Ok(None) => break,
                Err(error) => return damaged(error.to_string()),
            };
            if let Some((_, run)) =
                rows.iter().zip(next..).find(|(row, run)| row.first() != Some(&Value::Integer(*run as i64)))
            {
                return damaged(format!("run {run} is missing or misplaced"));
            }
            next += rows.len() as u64;
            let table = Table::new(self.columns.clone(), rows);
            match summary(&table) {
                Ok(summary) => self.summary.add(summary),
                Err(error) => return damaged(error.to_string()),
            }
            self.rows += table.rows.len() as u64;
            table.rows.into_iter().try_for_each(|row| writer.add(row))?;
            on_progress(self.rows);
        }
        match next == shard.last + 1 {
            true => Ok(Ok(())),
            false => damaged(format!("it ends before run {next}, but should end with run {}", shard.last)),
        }
    }
}

/// Summary of zero runs.
fn empty_summary(columns: &[Column]) -> Result<Summary, PartError> {
    let summary = summary(&Table::new(columns.to_vec(), Vec::new()));
    summary.map_err(|error| PartError::Write { file: "the results".to_string(), reason: error.to_string() })
}
