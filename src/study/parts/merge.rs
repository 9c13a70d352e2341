//! Parts to the results of the whole study.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::cover::{gaps, overlaps};
use super::error::PartError;
use super::info::{open, sound};
use crate::files::{self, Summed, replace};
use crate::study::beside::{Beside, beside, beside_name};
use crate::study::sweep::{Shard, Study, Summary, columns, summary};
use crate::table::{self, Column, RowWriter, Table, Value};

/// Results that were joined.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Merged {
    /// How many parts they are from.
    pub parts: u64,
    /// Bytes of the results.
    pub bytes: u64,
    pub found: Summary,
}

/// Joins parts, files or whole directories of them in any order, to the results of their study: `out` and what stands beside it have the very bytes that the
/// undisturbed sweep writes. Parts may be of different counts, if only together they have every run once.
///
/// `go_on` is asked from group to group of rows; `each` hears how many rows there are.
///
/// # Errors
/// Something is no part of this study, or damaged, missing or there twice; `out` is a place for no table, or has what no sweep of
/// this study has left there; the results cannot be written; or it was told to stop. `out` is as it was then.
pub fn merge(
    study: &Study,
    parts: &[PathBuf],
    out: &Path,
    go_on: &dyn Fn() -> bool,
    each: &mut dyn FnMut(u64),
) -> Result<Merged, PartError> {
    let format = place(study, out)?;
    let parts = in_order(study, parts)?;
    let mut joined = Joined { columns: columns(study), found: empty(&columns(study))?, rows: 0 };
    // What is wrong with the parts goes past the error of the file.
    let mut broken = None;
    let mut bytes = 0;
    let written = replace(out, |file| {
        let mut file = Summed::new(file);
        let mut writer = RowWriter::new(&mut file, format, &joined.columns)?;
        for (path, shard) in &parts {
            let copied = joined.copy(study, (path, *shard), &mut writer, go_on, each)?;
            if let Err(error) = copied {
                broken = Some(error);
                return Err(io::ErrorKind::Other.into());
            }
        }
        writer.finish()?;
        bytes = file.bytes();
        // Before the results themselves: whoever finds these finds what they are.
        let text = Beside::new(study, joined.rows, file.crc()).text().map_err(io::Error::other)?;
        replace(&beside_name(out), |file| file.write_all(text.as_bytes()))
    });
    if let Some(error) = broken {
        return Err(error);
    }
    written.map_err(|error| PartError::Write { file: out.display().to_string(), reason: error.to_string() })?;
    Ok(Merged { parts: parts.len() as u64, bytes, found: joined.found })
}

/// The format of the results, if they can be where they are wanted.
fn place(study: &Study, out: &Path) -> Result<table::Format, PartError> {
    let file = || out.display().to_string();
    let refused = |reason: String| PartError::Place { file: file(), reason };
    let format = table::format(out)
        .map_err(|_| refused("a table is CSV or Parquet by its name, NAME.csv or NAME.parquet".to_string()))?;
    files::place(out).map_err(refused)?;
    let help = "give another --out, or delete it first";
    let taken = |file: String, reason: &str| PartError::Taken { file, reason: reason.to_string(), help };
    let said = beside(out);
    if matches!(said, Some(Err(_))) {
        return Err(taken(beside_name(out).display().to_string(), "not as a sweep left it"));
    }
    if !fs::metadata(out).is_ok_and(|found| found.is_file() && found.len() > 0) {
        return Ok(format);
    }
    match said {
        Some(Ok(said)) if !said.is_of(out) => Err(taken(file(), "has been changed since a sweep wrote it")),
        Some(Ok(said)) if said.fingerprint != study.fingerprint() => {
            Err(taken(file(), "has the results of another study, model or version"))
        }
        Some(Ok(_)) => Ok(format),
        _ => Err(taken(file(), "no sweep has left it there")),
    }
}

/// Parts of this study that are all of it, in its order; each was opened and says so.
fn in_order(study: &Study, files: &[PathBuf]) -> Result<Vec<(PathBuf, Shard)>, PartError> {
    let (mut parts, mut foreign) = (Vec::new(), Vec::new());
    for path in all(files)? {
        let (info, _) = open(&path)?;
        match info.foreign(study) {
            Some(why) => foreign.push((path.display().to_string(), why)),
            None => parts.push((path, info.shard)),
        }
    }
    if !foreign.is_empty() {
        return Err(PartError::Foreign { parts: foreign });
    }
    parts.sort_by(|(a, one), (b, other)| (one.first, one.last, a).cmp(&(other.first, other.last, b)));
    let named: Vec<(String, Shard)> = parts.iter().map(|(path, shard)| (path.display().to_string(), *shard)).collect();
    let overlaps = overlaps(&named);
    if !overlaps.is_empty() {
        return Err(PartError::Overlapping { overlaps });
    }
    let shards: Vec<Shard> = named.into_iter().map(|(_, shard)| shard).collect();
    let gaps = gaps(study.runs(), &shards);
    match gaps.is_empty() {
        true => Ok(parts),
        false => Err(PartError::Missing { gaps, runs: study.runs() }),
    }
}

/// All files: of a directory those of Parquet that are in it.
fn all(given: &[PathBuf]) -> Result<Vec<PathBuf>, PartError> {
    let mut found = Vec::with_capacity(given.len());
    for path in given {
        if !path.is_dir() {
            found.push(path.clone());
            continue;
        }
        let unreadable =
            |error: io::Error| PartError::Read { file: path.display().to_string(), reason: error.to_string() };
        let before = found.len();
        for entry in fs::read_dir(path).map_err(unreadable)? {
            let file = entry.map_err(unreadable)?.path();
            if matches!(table::format(&file), Ok(table::Format::Parquet)) {
                found.push(file);
            }
        }
        if found.len() == before {
            let reason = "it is a directory without a file of Parquet in it".to_string();
            return Err(PartError::NotAPart { file: path.display().to_string(), reason });
        }
    }
    Ok(found)
}

/// What has been joined so far.
struct Joined {
    columns: Vec<Column>,
    found: Summary,
    rows: u64,
}

impl Joined {
    /// Copies the rows of a part. The outer error is one of writing, the inner one of the part.
    fn copy(
        &mut self,
        study: &Study,
        (path, shard): (&Path, Shard),
        writer: &mut RowWriter<'_>,
        go_on: &dyn Fn() -> bool,
        each: &mut dyn FnMut(u64),
    ) -> io::Result<Result<(), PartError>> {
        let damaged = |reason: String| Ok(Err(PartError::Damaged { file: path.display().to_string(), reason }));
        let mut groups =
            match open(path).and_then(|(info, groups)| sound(path, study, (&info, &groups)).map(|()| groups)) {
                Ok(groups) => groups,
                Err(error) => return Ok(Err(error)),
            };
        let mut next = shard.first;
        loop {
            if !go_on() {
                return Ok(Err(PartError::Stopped { done: self.rows, of: study.runs() }));
            }
            let rows = match groups.next_group() {
                Ok(Some(rows)) => rows,
                Ok(None) => break,
                Err(error) => return damaged(error.to_string()),
            };
            if let Some(wrong) =
                rows.iter().zip(next..).find(|(row, run)| row.first() != Some(&Value::Integer(*run as i64)))
            {
                return damaged(format!("run {} is not where it should be", wrong.1));
            }
            next += rows.len() as u64;
            let table = Table::new(self.columns.clone(), rows);
            match summary(&table) {
                Ok(found) => self.found.add(found),
                Err(error) => return damaged(error.to_string()),
            }
            self.rows += table.rows.len() as u64;
            table.rows.into_iter().try_for_each(|row| writer.add(row))?;
            each(self.rows);
        }
        match next == shard.last + 1 {
            true => Ok(Ok(())),
            false => damaged(format!("it ends before run {next}, and should end with run {}", shard.last)),
        }
    }
}

/// What came out of no runs.
fn empty(columns: &[Column]) -> Result<Summary, PartError> {
    let found = summary(&Table::new(columns.to_vec(), Vec::new()));
    found.map_err(|error| PartError::Write { file: "the results".to_string(), reason: error.to_string() })
}
