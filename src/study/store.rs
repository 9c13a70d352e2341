//! Results of a sweep on disk. Each finished run is appended to `OUT.partial.csv`, so that an
//! interruption loses no finished run. Finally all rows are written to OUT, in order.
//!
//! The provenance file `OUT.study.json` contains the exact text of the study. It determines whether a restarted command
//! may resume from existing results.

use std::ffi::OsString;
use std::fmt::Display;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use fs4::{FileExt, TryLockError};

use super::provenance::{Provenance, provenance_path, read_provenance};
use super::sweep::{Study, check_unsharded, columns, sorted_table};
use crate::files::{check_writable, checksum, replace_file};
use crate::log::is_same_file;
use crate::table::{self, Column, Table, Value};

/// First words of a file of unfinished results of a sweep.
const MAGIC: &str = "# phalanx sweep";

/// Unfinished results of a study, appended row by row.
pub struct Store {
    out: PathBuf,
    partial: PathBuf,
    file: File,
    columns: Vec<Column>,
    /// Rows so far, unordered.
    rows: Vec<Vec<Value>>,
}

/// Error while opening or writing the results of a study.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StoreError {
    /// The output path is unusable or contains other data.
    #[error("{0}")]
    Refused(String),
    /// Writing failed.
    #[error("{0}")]
    WriteFailed(String),
}

impl StoreError {
    fn refused(message: impl Display) -> Self {
        StoreError::Refused(message.to_string())
    }

    fn write_failed(message: impl Display) -> Self {
        StoreError::WriteFailed(message.to_string())
    }
}

/// State of the results on opening.
pub enum OpenedResults {
    /// All requested runs are finished.
    Complete(Table),
    /// Some or all requested runs are missing.
    Incomplete(Store),
}

/// Opens the results of a study; the first `max_runs` runs are requested.
///
/// # Errors
/// Returns an error if the output path is unusable, contains results of another study, or is being written by another
/// command.
pub fn open(study: &Study, out: &Path, max_runs: u64, restart: bool) -> Result<OpenedResults, StoreError> {
    table::format(out).map_err(StoreError::refused)?;
    check_unsharded(study, max_runs).map_err(StoreError::refused)?;
    check_writable(out).map_err(|reason| StoreError::refused(format!("cannot write {}: {reason}", out.display())))?;
    let requested = study.runs().min(max_runs);
    let is_complete = |table: &Table| !restart && table.rows.len() as u64 >= requested;
    if let Some(table) = read_finished(study, out).filter(is_complete) {
        return Ok(OpenedResults::Complete(table));
    }
    let [partial, _] = companion_files(out);
    refuse_foreign(study, out, &partial)?;
    let file = open_locked(out, &partial)?;
    let mut store = Store { out: out.to_path_buf(), partial, file, columns: columns(study), rows: Vec::new() };
    let resumed = store.resume(study, restart)?;
    if restart {
        return Ok(OpenedResults::Incomplete(store));
    }
    // Another command may have finished before the lock was taken.
    match read_finished(study, out) {
        Some(table) if is_complete(&table) => {
            let _ = fs::remove_file(&store.partial);
            return Ok(OpenedResults::Complete(table));
        }
        Some(table) => store.rows.extend(table.rows),
        None if out.exists() && !resumed => {
            let _ = fs::remove_file(&store.partial);
            return Err(StoreError::refused(format!(
                "{} contains results of another study, model or version; give another --out, or replace it with --restart",
                out.display()
            )));
        }
        None => {}
    }
    Ok(OpenedResults::Incomplete(store))
}

impl Store {
    /// Numbers of the finished runs.
    pub fn completed_runs(&self) -> impl Iterator<Item = u64> + '_ {
        self.rows.iter().filter_map(|row| match row.first() {
            Some(Value::Integer(run)) => u64::try_from(*run).ok(),
            _ => None,
        })
    }

    /// Rows of the finished runs, unordered.
    pub fn rows(&self) -> &[Vec<Value>] {
        &self.rows
    }

    /// Appends a row in a single write, so that a killed process can truncate only the last row.
    ///
    /// # Errors
    /// Returns an error if writing fails.
    pub fn append(&mut self, cells: Vec<Value>) -> io::Result<()> {
        self.file.write_all(table::format_csv_line(&cells).as_bytes())?;
        self.rows.push(cells);
        Ok(())
    }

    /// File of the unfinished results.
    pub fn partial_path(&self) -> &Path {
        &self.partial
    }

    /// Writes the complete results in order and removes the partial file.
    ///
    /// # Errors
    /// Returns an error if writing fails; the partial file still contains every finished run.
    pub fn finish(self, study: &Study) -> Result<Table, StoreError> {
        let table = sorted_table(study, self.rows);
        let incomplete = |error: &dyn Display| {
            StoreError::write_failed(format!(
                "{error}; every finished run is in {}; the same command resumes from there",
                self.partial.display()
            ))
        };
        table::write(&self.out, &table).map_err(|error| incomplete(&error))?;
        let (crc, _) = checksum(&self.out, u64::MAX).map_err(|error| incomplete(&error))?;
        let text =
            Provenance::new(study, table.rows.len() as u64, crc).to_json().map_err(|error| incomplete(&error))?;
        let name = provenance_path(&self.out);
        replace_file(&name, |out| out.write_all(text.as_bytes()))
            .map_err(|error| StoreError::write_failed(format!("cannot write {}: {error}", name.display())))?;
        fs::remove_file(&self.partial).map_err(|error| incomplete(&error))?;
        Ok(table)
    }

    /// Reads the rows of an earlier, interrupted command. Returns whether there was one; always true with `restart`.
    fn resume(&mut self, study: &Study, restart: bool) -> Result<bool, StoreError> {
        let mut bytes = Vec::new();
        self.file.read_to_end(&mut bytes).map_err(|error| self.write_error(&error))?;
        let header = header(study, &self.columns);
        let partial = self.partial.display();
        let out = self.out.display();
        let first_line = bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
        if !MAGIC.as_bytes().starts_with(&first_line[..first_line.len().min(MAGIC.len())]) {
            return Err(StoreError::refused(format!(
                "{partial} is the file for unfinished results, but contains other data; move it or give another --out"
            )));
        }
        // A truncated header has no rows after it.
        if restart || header.as_bytes().starts_with(&bytes) && bytes.len() < header.len() {
            self.file
                .set_len(0)
                .and_then(|()| self.file.seek(SeekFrom::Start(0)).map(drop))
                .map_err(|e| self.write_error(&e))?;
            self.file.write_all(header.as_bytes()).map_err(|error| self.write_error(&error))?;
            return Ok(restart);
        }
        let Some(lines) = bytes.strip_prefix(header.as_bytes()) else {
            return Err(StoreError::refused(format!(
                "{partial} contains unfinished results of another study, model or version, or this study has been changed since; \
                 --restart discards them, another --out keeps them ({out} is unchanged)"
            )));
        };
        let (rows, valid_bytes) = table::read_rows(lines, &self.columns);
        let end = (header.len() + valid_bytes) as u64;
        self.file
            .set_len(end)
            .and_then(|()| self.file.seek(SeekFrom::Start(end)).map(drop))
            .map_err(|e| self.write_error(&e))?;
        self.rows = rows;
        Ok(true)
    }

    fn write_error(&self, error: &io::Error) -> StoreError {
        StoreError::write_failed(format!("cannot write {}: {error}", self.partial.display()))
    }
}

/// First two lines of the partial file: the study and the columns.
fn header(study: &Study, columns: &[Column]) -> String {
    let names: Vec<Value> = columns.iter().map(|column| Value::from(column.name.as_str())).collect();
    format!("{MAGIC} {} of {}, unfinished\n{}", study.fingerprint(), study.runs(), table::format_csv_line(&names))
}

/// Rejects, even with `--restart`, replacing a file that no study has written or that has been changed since.
fn refuse_foreign(study: &Study, out: &Path, partial: &Path) -> Result<(), StoreError> {
    let provenance = read_provenance(out);
    let refused = |path: &Path, owner: &str| {
        Err(StoreError::refused(format!(
            "{} already exists and is not an unmodified result of a run{owner}, so it is not replaced; give another --out, or \
             delete it first",
            path.display()
        )))
    };
    if matches!(provenance, Some(Err(_))) {
        return refused(&provenance_path(out), "");
    }
    if !fs::metadata(out).is_ok_and(|entry| entry.is_file() && entry.len() > 0) {
        return Ok(());
    }
    let is_unchanged = matches!(&provenance, Some(Ok(provenance)) if provenance.matches_file(out));
    // A command killed between writing its last two files has left the results and the partial file.
    let is_own_unfinished = || partial.exists() && read_table(study, out).is_some();
    if is_unchanged || is_own_unfinished() { Ok(()) } else { refused(out, " of this study") }
}

/// Reads a table; `None` unless it has the columns of the study.
fn read_table(study: &Study, out: &Path) -> Option<Table> {
    let table = match table::format(out).ok()? {
        table::Format::Csv => table::read_csv(out, &columns(study)).ok()?,
        table::Format::Parquet => table::read(out).ok()?,
    };
    (table.columns == columns(study)).then_some(table)
}

/// Reads results that a run of this study has written and that have not been changed since.
fn read_finished(study: &Study, out: &Path) -> Option<Table> {
    let provenance = read_provenance(out)?.ok()?;
    if provenance.fingerprint != study.fingerprint() || !provenance.matches_file(out) {
        return None;
    }
    read_table(study, out)
}

/// Opens and locks the partial file, so that only one command writes to it.
fn open_locked(out: &Path, partial: &Path) -> Result<File, StoreError> {
    let cannot_open = |error: io::Error| {
        StoreError::refused(format!("cannot write {}: {error}; give a writable path", partial.display()))
    };
    loop {
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).create(true).truncate(false).open(partial).map_err(cannot_open)?;
        match FileExt::try_lock(&file) {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(StoreError::refused(format!(
                    "another command is writing {} (its rows are in {}); wait for it to finish, or give another --out",
                    out.display(),
                    partial.display()
                )));
            }
            Err(TryLockError::Error(error)) => return Err(cannot_open(error)),
        }
        // The command that held the lock may have removed the file before it was locked here.
        if is_same_file(&file, partial) {
            return Ok(file);
        }
    }
}

/// Files next to the results: the partial file and the provenance file.
pub fn companion_files(out: &Path) -> [PathBuf; 2] {
    let mut partial = OsString::from(out);
    partial.push(".partial.csv");
    [partial.into(), provenance_path(out)]
}
