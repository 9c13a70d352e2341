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

use super::KeepRunning;
use super::results::{has_other_results, refused, write_failed, write_provenance};
use super::sweep::{
    MAX_SHARDED_RUNS, Row, RunStats, Shard, Study, Summary, columns, find_gaps, list_message, missing_message,
    run_range_text, run_while, shard_range, sorted_table, summary,
};
use crate::files::{FileKind, cannot_write, check_target, is_forced, is_special, replace_file};
use crate::scene::Keyword as _;
use crate::table::{self, Format, RowGroups, RowWriter, Value};
use phalanx_parallel::{ComputeError, Monitor};

/// Keys of the metadata: [`PartInfo`] as JSON, and the checksum of the rows.
const METADATA_KEYS: [&str; 2] = ["phalanx.part", "phalanx.checksum"];

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartInfo {
    version: String,
    study: String,
    model: String,
    /// Preset in place of the settings of the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    preset: Option<String>,
    checked: bool,
    /// Fingerprint of study, base scene, model, checks and version.
    fingerprint: String,
    #[serde(flatten)]
    shard: Shard,
    /// Number of runs of the study.
    runs: u64,
}

impl PartInfo {
    fn new(study: &Study, shard: Shard) -> Self {
        PartInfo {
            version: env!("CARGO_PKG_VERSION").to_string(),
            study: study.name.clone(),
            model: study.model.name().to_string(),
            preset: study.preset.map(|preset| preset.keyword().to_string()),
            checked: study.checked,
            fingerprint: study.fingerprint(),
            shard,
            runs: study.runs(),
        }
    }

    /// Returns why the part does not belong to the study; `None` if it does.
    fn mismatch(&self, study: &Study) -> Option<String> {
        let values = |info: &PartInfo| {
            [
                ("version of phalanx", info.version.clone()),
                ("study", format!("`{}`", info.study)),
                ("model", format!("--model {}", info.model)),
                (
                    "preset",
                    info.preset.as_ref().map_or("that of the scene".to_string(), |name| format!("--preset {name}")),
                ),
                ("sweep", if info.checked { "with --check" } else { "without --check" }.to_string()),
                ("text (study or base scene, by its fingerprint)", info.fingerprint.clone()),
            ]
        };
        let mut pairs = values(self).into_iter().zip(values(&PartInfo::new(study, self.shard)));
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
    fn open(path: &Path) -> Result<Self, ComputeError> {
        let help = "give files written by `phalanx sweep STUDY --shard K/N --out SHARD.parquet`";
        let not_a_part =
            |reason: &dyn Display| refused(format!("{} is not a shard of a sweep: {reason}; {help}", path.display()));
        let groups =
            RowGroups::open(path).map_err(|error| if path.exists() { not_a_part(&error) } else { refused(error) })?;
        let info = groups.metadata_value(METADATA_KEYS[0]).and_then(|text| serde_json::from_str(text).ok());
        let info: PartInfo =
            info.ok_or_else(|| not_a_part(&"it has no metadata about its study, which --shard writes"))?;
        let (shard, runs) = (info.shard, info.runs);
        let part = Part { path: path.to_path_buf(), info, groups };
        let is_consistent = runs <= MAX_SHARDED_RUNS
            && shard_range(runs, shard.number, shard.count) == Some(shard)
            && part.groups.row_count() == shard.runs();
        let inconsistent = || part.damaged(format!("its rows do not match shard {}/{}", shard.number, shard.count));
        if is_consistent { Ok(part) } else { Err(inconsistent()) }
    }

    fn damaged(&self, reason: impl Display) -> ComputeError {
        refused(format!("{} is damaged: {reason}; delete it and run the shard again", self.path.display()))
    }

    /// Reads all rows in groups, verifies them, adds them to the summary and passes them to `on_group`.
    fn read(
        mut self,
        study: &Study,
        total: &mut Summary,
        mut on_group: impl FnMut(&[Vec<Value>]) -> Result<(), ComputeError>,
    ) -> Result<(), ComputeError> {
        let mut table = sorted_table(study, []);
        if self.groups.columns() != table.columns || self.info.runs != study.runs() {
            return Err(self.damaged("it has other columns or runs than the study"));
        }
        let (mut next, mut hasher) = (self.info.shard.first, crc32fast::Hasher::new());
        while let Some(rows) = self.groups.next() {
            table.rows = rows.map_err(|error| self.damaged(error))?;
            let is_misplaced = |(row, run): &(&Vec<Value>, u64)| row.first() != Some(&Value::Integer(*run as i64));
            if let Some((_, run)) = table.rows.iter().zip(next..).find(is_misplaced) {
                return Err(self.damaged(format!("run {run} is missing or misplaced")));
            }
            next += table.rows.len() as u64;
            update_checksum(&mut hasher, &table.rows);
            total.add(summary(&table).map_err(|error| self.damaged(error))?);
            on_group(&table.rows)?;
        }
        if next != self.info.shard.last + 1 {
            return Err(self.damaged(format!("it ends before run {next}")));
        }
        let expected = self.groups.metadata_value(METADATA_KEYS[1]);
        if expected == Some(&format_checksum(hasher)) {
            Ok(())
        } else {
            Err(self.damaged("its checksum does not match"))
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

fn empty_summary(study: &Study) -> Result<Summary, ComputeError> {
    summary(&sorted_table(study, [])).map_err(refused)
}

#[derive(Clone, Debug, PartialEq)]
pub struct WrittenPart {
    pub part: PartInfo,
    pub summary: Summary,
    /// Statistics of the runs; `None` if the part already existed.
    pub stats: Option<RunStats>,
}

/// Runs a part of a study on `threads` threads (0: one per core) and writes it atomically. An existing part is kept
/// unless `restart` is set, so that repeating the call resumes a sweep. Concurrent calls for the same part write the
/// same bytes.
///
/// `keep_running` is polled during the runs; the runs stop when it returns false. `on_row` is called with every row, in
/// any order.
///
/// # Errors
/// Returns an error if the output path is unusable or contains other data, if writing fails, or if the runs are
/// interrupted.
pub fn write_part(
    study: &Study,
    shard: Shard,
    out: &Path,
    threads: usize,
    restart: bool,
    keep_running: KeepRunning<'_>,
    mut on_row: impl FnMut(&Row) + Send,
) -> Result<WrittenPart, ComputeError> {
    let part = PartInfo::new(study, shard);
    if !matches!(table::format(out), Ok(Format::Parquet)) || is_special(out) {
        let reason = "a shard is a Parquet file (NAME.parquet), because its metadata identify the study; `phalanx sweep \
                      merge` writes CSV from shards";
        return Err(refused(cannot_write(out, reason)));
    }
    check_target(out, FileKind::Table).map_err(refused)?;
    if let Some(summary) = existing_summary(study, &part, out, restart)? {
        return Ok(WrittenPart { part, summary, stats: None });
    }
    let mut rows = Vec::new();
    let stats = run_while(study, threads, shard.first..=shard.last, &HashSet::new(), keep_running, |row| {
        on_row(&row);
        rows.push(row.cells);
        true
    });
    if !stats.complete {
        return Err(ComputeError::Stopped { done: stats.runs as usize, total: shard.runs() as usize });
    }
    let table = sorted_table(study, rows);
    let mut hasher = crc32fast::Hasher::new();
    update_checksum(&mut hasher, &table.rows);
    let values = [serde_json::to_string(&part).unwrap_or_default(), format_checksum(hasher)];
    let metadata: Vec<(String, String)> = METADATA_KEYS.map(String::from).into_iter().zip(values).collect();
    let written = table::write_with_metadata(out, &table, &metadata).and_then(|()| summary(&table));
    let summary = written.map_err(|error| ComputeError::Failed(error.to_string()))?;
    Ok(WrittenPart { part, summary, stats: Some(stats) })
}

/// Returns the summary of this part if it is already written. `None` means that `out` may be written.
fn existing_summary(
    study: &Study,
    part: &PartInfo,
    out: &Path,
    restart: bool,
) -> Result<Option<Summary>, ComputeError> {
    if !fs::metadata(out).is_ok_and(|found| found.len() > 0) || is_forced() {
        return Ok(None);
    }
    let Ok(existing) = Part::open(out) else {
        let reason = "the existing file is not a shard of a sweep, so it is not replaced; give another --out, or replace it \
                      with --force";
        return Err(refused(cannot_write(out, reason)));
    };
    // Only a shard is replaced, also if it is damaged.
    if restart {
        return Ok(None);
    }
    let Shard { number, count, .. } = existing.info.shard;
    let reason = match existing.info.mismatch(study) {
        Some(reason) => format!("it is a shard of another sweep: {reason}"),
        None if existing.info.shard != part.shard => format!("it is shard {number}/{count} of this study"),
        None => {
            let mut total = empty_summary(study)?;
            return existing.read(study, &mut total, |_| Ok(())).map(|()| Some(total));
        }
    };
    Err(refused(format!(
        "{} already exists, but {reason}, so it is not replaced; give another --out, or replace it with --restart",
        out.display()
    )))
}

#[derive(Clone, Debug, PartialEq)]
pub struct MergeResult {
    pub parts: u64,
    /// Size of the results, bytes.
    pub bytes: u64,
    pub summary: Summary,
}

/// Merges parts into the results of their study. The parts are given as files or directories, in any order. `out` and
/// its file of the study have the same bytes as those of an undivided sweep. The parts may have different shard counts,
/// as long as they contain every run exactly once.
///
/// The monitor counts the rows; it can stop the merge after each row group.
///
/// # Errors
/// Returns an error if a part is missing, damaged, duplicate or of another study; if the output path is unusable or
/// contains other data; if writing fails; or if the merge is interrupted. In all cases `out` is unchanged.
pub fn merge(study: &Study, parts: &[PathBuf], out: &Path, monitor: &Monitor<'_>) -> Result<MergeResult, ComputeError> {
    let format = table::format(out).map_err(refused)?;
    check_target(out, FileKind::Table).map_err(refused)?;
    if has_other_results(study, out)? {
        return Err(refused(format!(
            "{} contains results of another study, model or version, so it is not replaced; give another --out, or replace \
             it with --force",
            out.display()
        )));
    }
    let parts = complete_parts(study, parts)?;
    let mut total = empty_summary(study)?;
    monitor.start(study.runs() as usize, "rows joined");
    let written = replace_file(out, |file| {
        let mut writer = RowWriter::new(file, format, &columns(study))?;
        for path in &parts {
            let copy = |part: Part| {
                part.read(study, &mut total, |rows| {
                    if !(monitor.keep_running())() {
                        return Err(monitor.stopped());
                    }
                    let added = rows.iter().try_for_each(|row| writer.add(row));
                    monitor.advance(rows.len(), "rows joined");
                    added.map_err(|error| write_failed(out, &error))
                })
            };
            Part::open(path).and_then(copy).map_err(io::Error::other)?;
        }
        writer.finish(&[])?;
        // The study is written first, so that results never exist without it.
        write_provenance(study, study.runs(), out)
    });
    written.map_err(|error| match error.downcast() {
        Ok(error) => error,
        Err(error) => write_failed(out, &error),
    })?;
    let bytes = fs::metadata(out).map_or(0, |found| found.len());
    Ok(MergeResult { parts: parts.len() as u64, bytes, summary: total })
}

/// Returns the files of the parts in the order of their runs; checks that they cover the study.
fn complete_parts(study: &Study, paths: &[PathBuf]) -> Result<Vec<PathBuf>, ComputeError> {
    let (mut parts, mut foreign) = (Vec::new(), Vec::new());
    for path in part_files(paths)? {
        let part = Part::open(&path)?;
        match part.info.mismatch(study) {
            Some(reason) => foreign.push(format!("{} is not a shard of this study: {reason}", path.display())),
            None => parts.push((part.info.shard, path)),
        }
    }
    if !foreign.is_empty() {
        return Err(refused(list_message("", foreign, "; use the same for all shards and the merge")));
    }
    parts.sort_by(|(a, path_a), (b, path_b)| (a.first, a.last, path_a).cmp(&(b.first, b.last, path_b)));
    let overlaps = find_overlaps(&parts);
    if !overlaps.is_empty() {
        return Err(refused(list_message("shards overlap: ", overlaps, "; remove one of each pair")));
    }
    let (shards, paths): (Vec<Shard>, Vec<PathBuf>) = parts.into_iter().unzip();
    let gaps = find_gaps(study.runs(), &shards);
    if gaps.is_empty() { Ok(paths) } else { Err(refused(missing_message(&gaps, study.runs()))) }
}

/// Replaces directories by the Parquet files in them.
pub(crate) fn part_files(paths: &[PathBuf]) -> Result<Vec<PathBuf>, ComputeError> {
    let mut files = Vec::with_capacity(paths.len());
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let entries = fs::read_dir(path).and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect());
        let entries: Vec<PathBuf> =
            entries.map_err(|error: io::Error| refused(format!("cannot read {}: {error}", path.display())))?;
        let before = files.len();
        files.extend(entries.into_iter().filter(|file| matches!(table::format(file), Ok(Format::Parquet))));
        if files.len() == before {
            let path = path.display();
            return Err(refused(format!("the directory {path} contains no Parquet file, so no shard")));
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
