//! Sweeps distributed over several machines: parts of a study in separate files, and their merge.
//!
//! A job array, a cluster or a shell loop can make parts with the command or with [`write_part`]. A part is one Parquet
//! file that is written atomically and whose metadata identify the study and the runs. An existing part is therefore
//! finished, and resuming a sweep means making the missing parts. [`merge`] concatenates the row groups of the parts with
//! one group in memory; the result has the same bytes as an undivided sweep.
//!
//! Parts are Parquet files only: CSV has no metadata, and two files cannot be written atomically.

use std::collections::HashSet;
use std::fmt::Display;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::results::{ResultsError, has_other_results, write_provenance};
use super::sweep::{
    MAX_SHARDED_RUNS, Row, RunStats, Shard, Study, Summary, columns, find_gaps, list_message, missing_message,
    run_range, run_range_text, shard_range, sorted_table, summary,
};
use crate::files::{FileKind, cannot_write, check_target, is_forced, is_special, replace_file};
use crate::table::{self, Format, RowGroups, RowWriter, Table, Value};

/// Keys of the metadata: [`PartInfo`] as JSON, and the checksum of the rows.
const METADATA_KEYS: [&str; 2] = ["phalanx.part", "phalanx.checksum"];

/// Metadata of a part.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartInfo {
    /// Version of the program that wrote the part.
    pub version: String,
    /// Name of the study.
    pub study: String,
    pub model: String,
    /// Whether every run was checked.
    pub checked: bool,
    /// Fingerprint of study, base scene, model, checks and version.
    pub fingerprint: String,
    #[serde(flatten)]
    pub shard: Shard,
    /// Number of runs of the study.
    pub runs: u64,
}

impl PartInfo {
    /// Metadata of a new part of a study.
    pub fn new(study: &Study, shard: Shard) -> Self {
        PartInfo {
            version: env!("CARGO_PKG_VERSION").to_string(),
            study: study.name.clone(),
            model: study.model.name().to_string(),
            checked: study.checked,
            fingerprint: study.fingerprint(),
            shard,
            runs: study.runs(),
        }
    }

    /// Returns why the part does not belong to the study; `None` if it does.
    fn mismatch(&self, study: &Study) -> Option<String> {
        let expected = PartInfo::new(study, self.shard);
        let check = |info: &PartInfo| if info.checked { "with --check" } else { "without --check" }.to_string();
        let values = |info: &PartInfo| {
            [
                ("version of phalanx", info.version.clone()),
                ("study", format!("`{}`", info.study)),
                ("model", format!("--model {}", info.model)),
                ("sweep", check(info)),
                ("text (study or base scene, by its fingerprint)", info.fingerprint.clone()),
            ]
        };
        let mut pairs = values(self).into_iter().zip(values(&expected));
        let ((name, found), (_, expected)) = pairs.find(|(found, expected)| found != expected)?;
        Some(format!("its {name} is {found}, but here it is {expected}"))
    }
}

/// An existing part whose rows have not been read.
struct Part {
    path: PathBuf,
    info: PartInfo,
    groups: RowGroups,
}

impl Part {
    /// Opens a part and reads its metadata.
    fn open(path: &Path) -> Result<Self, ResultsError> {
        let help = "give files written by `phalanx sweep STUDY --shard K/N --out SHARD.parquet`";
        let not_a_part = |reason: &dyn Display| {
            ResultsError::Refused(format!("{} is not a shard of a sweep: {reason}; {help}", path.display()))
        };
        let groups = RowGroups::open(path).map_err(|error| match path.exists() {
            true => not_a_part(&error),
            false => ResultsError::Refused(error.to_string()),
        })?;
        let info = groups.metadata_value(METADATA_KEYS[0]).and_then(|text| serde_json::from_str(text).ok());
        let info: PartInfo =
            info.ok_or_else(|| not_a_part(&"it has no metadata about its study, which --shard writes"))?;
        let part = Part { path: path.to_path_buf(), info, groups };
        let Shard { number, count, .. } = part.info.shard;
        let is_consistent = part.info.runs <= MAX_SHARDED_RUNS
            && shard_range(part.info.runs, number, count) == Some(part.info.shard)
            && part.groups.row_count() == part.info.shard.runs();
        if is_consistent {
            Ok(part)
        } else {
            Err(part.damaged(format!("its rows do not match shard {number}/{count}")))
        }
    }

    fn damaged(&self, reason: impl Display) -> ResultsError {
        let path = self.path.display();
        ResultsError::Refused(format!("{path} is damaged: {reason}; delete it and run the shard again"))
    }

    /// Reads all rows in groups, verifies them and passes them to `on_group`. Returns their summary.
    fn read(
        mut self,
        study: &Study,
        mut on_group: impl FnMut(&[Vec<Value>]) -> Result<(), ResultsError>,
    ) -> Result<Summary, ResultsError> {
        let columns = columns(study);
        if self.groups.columns() != columns || self.info.runs != study.runs() {
            return Err(self.damaged("it has other columns or runs than the study"));
        }
        let expected_checksum = self.groups.metadata_value(METADATA_KEYS[1]).unwrap_or_default().to_string();
        let (mut next, mut hasher) = (self.info.shard.first, crc32fast::Hasher::new());
        let mut total = summary(&Table::new(columns.clone(), Vec::new())).map_err(|error| self.damaged(error))?;
        while let Some(rows) = self.groups.next() {
            let rows = rows.map_err(|error| self.damaged(error))?;
            let is_misplaced = |(row, run): &(&Vec<Value>, u64)| row.first() != Some(&Value::Integer(*run as i64));
            if let Some((_, run)) = rows.iter().zip(next..).find(is_misplaced) {
                return Err(self.damaged(format!("run {run} is missing or misplaced")));
            }
            next += rows.len() as u64;
            update_checksum(&mut hasher, &rows);
            let table = Table::new(columns.clone(), rows);
            total.add(summary(&table).map_err(|error| self.damaged(error))?);
            on_group(&table.rows)?;
        }
        match (next == self.info.shard.last + 1, format_checksum(hasher) == expected_checksum) {
            (true, true) => Ok(total),
            (true, false) => Err(self.damaged("its checksum does not match")),
            _ => Err(self.damaged(format!("it ends before run {next}"))),
        }
    }
}

/// Adds rows to a checksum (CRC-32) of their values.
fn update_checksum(hasher: &mut crc32fast::Hasher, rows: &[Vec<Value>]) {
    for value in rows.iter().flatten() {
        match value {
            Value::Integer(integer) => hasher.update(&integer.to_le_bytes()),
            Value::Number(number) => hasher.update(&number.to_bits().to_le_bytes()),
            Value::Flag(flag) => hasher.update(&[u8::from(*flag)]),
            Value::Text(text) => hasher.update(text.as_bytes()),
            Value::Missing => hasher.update(b"missing"),
        }
    }
}

fn format_checksum(hasher: crc32fast::Hasher) -> String {
    format!("{:08x}", hasher.finalize())
}

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
) -> Result<WrittenPart, ResultsError> {
    let part = PartInfo::new(study, shard);
    if !matches!(table::format(out), Ok(Format::Parquet)) || is_special(out) {
        let reason = "a shard is a Parquet file (NAME.parquet), because its metadata identify the study; `phalanx sweep \
                      merge` writes CSV from shards";
        return Err(ResultsError::Refused(cannot_write(out, reason)));
    }
    check_target(out, FileKind::Table).map_err(ResultsError::Refused)?;
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
        return Err(ResultsError::Stopped { done: stats.runs, total: shard.runs() });
    }
    let table = sorted_table(study, rows);
    let mut hasher = crc32fast::Hasher::new();
    update_checksum(&mut hasher, &table.rows);
    let values = [serde_json::to_string(&part).unwrap_or_default(), format_checksum(hasher)];
    let metadata: Vec<(String, String)> = METADATA_KEYS.map(String::from).into_iter().zip(values).collect();
    let summary =
        summary(&table).and_then(|summary| table::write_with_metadata(out, &table, &metadata).map(|()| summary));
    let summary = summary.map_err(|error| ResultsError::WriteFailed(error.to_string()))?;
    Ok(WrittenPart { part, summary, stats: Some(stats) })
}

/// Returns the summary of this part if it is already written. `None` means that `out` may be written.
fn existing_summary(
    study: &Study,
    part: &PartInfo,
    out: &Path,
    restart: bool,
) -> Result<Option<Summary>, ResultsError> {
    if !fs::metadata(out).is_ok_and(|found| found.len() > 0) || is_forced() {
        return Ok(None);
    }
    let existing = match Part::open(out) {
        // Only a shard is replaced, also if it is damaged.
        Ok(_) if restart => return Ok(None),
        Ok(existing) => existing,
        Err(_) => {
            return Err(ResultsError::Refused(cannot_write(
                out,
                "the existing file is not a shard of a sweep, so it is not replaced; give another --out, or replace it with \
                 --force",
            )));
        }
    };
    let PartInfo { shard: Shard { number, count, .. }, .. } = existing.info;
    let reason = match existing.info.mismatch(study) {
        Some(reason) => format!("it is a shard of another sweep: {reason}"),
        None if existing.info.shard != part.shard => format!("it is shard {number}/{count} of this study"),
        None => return existing.read(study, |_| Ok(())).map(Some),
    };
    Err(ResultsError::Refused(format!(
        "{} already exists, but {reason}, so it is not replaced; give another --out, or replace it with --restart",
        out.display()
    )))
}

/// Merged results.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MergeResult {
    /// Number of parts.
    pub parts: u64,
    /// Size of the results, bytes.
    pub bytes: u64,
    pub summary: Summary,
}

/// Merges parts, given as files or directories in any order, into the results of their study. `out` and its file of the
/// study have the same bytes as those of an undivided sweep. The parts may be of different shard counts, as long as they
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
) -> Result<MergeResult, ResultsError> {
    let format = table::format(out).map_err(|error| ResultsError::Refused(error.to_string()))?;
    check_target(out, FileKind::Table).map_err(ResultsError::Refused)?;
    if has_other_results(study, out)? {
        return Err(ResultsError::Refused(format!(
            "{} contains results of another study, model or version, so it is not replaced; give another --out, or replace \
             it with --force",
            out.display()
        )));
    }
    let parts = complete_parts(study, parts)?;
    let (count, mut total, mut done) = (parts.len() as u64, None, 0);
    // Errors of the parts are returned separately from errors of the output file.
    let mut failure = None;
    let written = replace_file(out, |file| {
        let mut writer = RowWriter::new(file, format, &columns(study))?;
        for part in parts {
            let copied = Part::open(&part).and_then(|part| {
                part.read(study, |rows| {
                    if !keep_running() {
                        return Err(ResultsError::Stopped { done, total: study.runs() });
                    }
                    let added = rows.iter().try_for_each(|row| writer.add(row));
                    done += rows.len() as u64;
                    on_progress(done);
                    added.map_err(|error| ResultsError::write_failed(out, &error))
                })
            });
            match (copied, &mut total) {
                (Ok(summary), None) => total = Some(summary),
                (Ok(summary), Some(total)) => total.add(summary),
                (Err(error), _) => {
                    failure = Some(error);
                    return Err(io::ErrorKind::Other.into());
                }
            }
        }
        writer.finish(&[])?;
        // The study is written first, so that results never exist without it.
        write_provenance(study, done, out)
    });
    match (failure, written, total) {
        (None, Ok(()), Some(summary)) => {
            let bytes = fs::metadata(out).map_or(0, |found| found.len());
            Ok(MergeResult { parts: count, bytes, summary })
        }
        (Some(failure), ..) => Err(failure),
        (None, written, _) => {
            let error = written.err().unwrap_or_else(|| io::Error::other("there are no parts"));
            Err(ResultsError::write_failed(out, &error))
        }
    }
}

/// Returns the files of the parts in the order of their runs; checks that they cover the study.
fn complete_parts(study: &Study, paths: &[PathBuf]) -> Result<Vec<PathBuf>, ResultsError> {
    let (mut parts, mut foreign) = (Vec::new(), Vec::new());
    for path in part_files(paths)? {
        let part = Part::open(&path)?;
        match part.info.mismatch(study) {
            Some(reason) => foreign.push(format!("{} is not a shard of this study: {reason}", path.display())),
            None => parts.push((part.info.shard, path)),
        }
    }
    if !foreign.is_empty() {
        return Err(ResultsError::Refused(list_message("", foreign, "; use the same for all shards and the merge")));
    }
    parts.sort_by(|(a, path_a), (b, path_b)| (a.first, a.last, path_a).cmp(&(b.first, b.last, path_b)));
    let overlaps = find_overlaps(&parts);
    if !overlaps.is_empty() {
        return Err(ResultsError::Refused(list_message("shards overlap: ", overlaps, "; remove one of each pair")));
    }
    let (shards, paths): (Vec<Shard>, Vec<PathBuf>) = parts.into_iter().unzip();
    let gaps = find_gaps(study.runs(), &shards);
    if gaps.is_empty() { Ok(paths) } else { Err(ResultsError::Refused(missing_message(&gaps, study.runs()))) }
}

/// Replaces directories by the Parquet files in them.
///
/// # Errors
/// Returns an error if a directory cannot be read, or contains no Parquet file.
pub(crate) fn part_files(paths: &[PathBuf]) -> Result<Vec<PathBuf>, ResultsError> {
    let mut files = Vec::with_capacity(paths.len());
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let entries = fs::read_dir(path).and_then(Iterator::collect::<io::Result<Vec<_>>>);
        let entries = entries
            .map_err(|error| ResultsError::Refused(format!("cannot read {}: {error}", path.display())))?
            .into_iter()
            .map(|entry| entry.path())
            .filter(|file| matches!(table::format(file), Ok(Format::Parquet)));
        let before = files.len();
        files.extend(entries);
        if files.len() == before {
            let path = path.display();
            return Err(ResultsError::Refused(format!("the directory {path} contains no Parquet file, so no shard")));
        }
    }
    Ok(files)
}

/// Describes runs that are in two parts. The parts are sorted by their first run.
fn find_overlaps(parts: &[(Shard, PathBuf)]) -> Vec<String> {
    let mut overlaps = Vec::new();
    // The part with the largest last run so far.
    let mut furthest: Option<&(Shard, PathBuf)> = None;
    for part in parts.iter().filter(|(shard, _)| shard.runs() > 0) {
        if let Some((previous, path)) = furthest.filter(|(previous, _)| part.0.first <= previous.last) {
            let runs = run_range_text(part.0.first, part.0.last.min(previous.last));
            overlaps.push(format!("{} and {} both contain {runs}", path.display(), part.1.display()));
        }
        if furthest.is_none_or(|(previous, _)| part.0.last > previous.last) {
            furthest = Some(part);
        }
    }
    overlaps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_all_overlaps() {
        let parts = |list: &[(u64, u64)]| -> Vec<(Shard, PathBuf)> {
            let name = |shard: &Shard| PathBuf::from(format!("{}-of-{}", shard.number, shard.count));
            let shards = list.iter().map(|&(number, count)| shard_range(100, number, count).expect("a valid part"));
            shards.map(|shard| (shard, name(&shard))).collect()
        };
        assert_eq!(find_overlaps(&parts(&[(1, 2), (2, 2)])), [""; 0]);
        assert_eq!(
            find_overlaps(&parts(&[(1, 1), (3, 10), (7, 10)])),
            ["1-of-1 and 3-of-10 both contain runs 21 to 30", "1-of-1 and 7-of-10 both contain runs 61 to 70"]
        );
    }
}
