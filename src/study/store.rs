//! Runs of a sweep or a search on the disk: rows are added to `OUT.partial.csv` as they are found, so that nothing that ended it
//! loses a finished run; at the end all of them are written as OUT, in order.
//!
//! Beside OUT stands `OUT.study.json`: which study the results are of, with its exact text. It says whether a command that is
//! started again may go on from what is there.

use std::ffi::OsString;
use std::fmt::Display;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use fs4::{FileExt, TryLockError};

use super::beside::{Beside, beside, beside_name};
use super::sweep::{Study, columns, in_one_piece, sorted};
use crate::files::{checksum, place, replace};
use crate::log::is_at;
use crate::table::{self, Column, Table, Value};

/// How the file of unfinished results begins, of a search too.
const MAGIC: &str = "# phalanx sweep";

/// Results that grow.
pub struct Store {
    out: PathBuf,
    partial: PathBuf,
    file: File,
    columns: Vec<Column>,
    /// Rows there are, by no order.
    rows: Vec<Vec<Value>>,
}

/// Why there are no results, in words.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StoreError {
    /// The place is one where none can be, or has something else.
    #[error("{0}")]
    Refused(String),
    /// They could not be written.
    #[error("{0}")]
    Broken(String),
}

impl StoreError {
    fn refused(message: impl Display) -> Self {
        StoreError::Refused(message.to_string())
    }

    fn broken(message: impl Display) -> Self {
        StoreError::Broken(message.to_string())
    }
}

/// What is there of the runs.
pub enum Found {
    /// All that is wanted.
    Complete(Table),
    /// Some of it, or nothing yet.
    Begun(Store),
}

/// Opens the results of a study, of which the first `most` runs are wanted.
///
/// # Errors
/// A place where results cannot be, results of another study, or another command that writes them.
pub fn open(study: &Study, out: &Path, most: u64, restart: bool) -> Result<Found, StoreError> {
    table::format(out).map_err(StoreError::refused)?;
    in_one_piece(study, most).map_err(StoreError::refused)?;
    place(out).map_err(|why| StoreError::refused(format!("cannot write {}: {why}", out.display())))?;
    let wanted = study.runs().min(most);
    let complete = |table: &Table| !restart && table.rows.len() as u64 >= wanted;
    if let Some(table) = finished(study, out).filter(complete) {
        return Ok(Found::Complete(table));
    }
    let [partial, _] = companions(out);
    refuse_foreign(study, out, &partial)?;
    let file = claim(out, &partial)?;
    let mut store = Store { out: out.to_path_buf(), partial, file, columns: columns(study), rows: Vec::new() };
    let begun = store.resume(study, restart)?;
    if restart {
        return Ok(Found::Begun(store));
    }
    // Another command may have finished while this one waited for nothing.
    match finished(study, out) {
        Some(table) if complete(&table) => {
            let _ = fs::remove_file(&store.partial);
            return Ok(Found::Complete(table));
        }
        Some(table) => store.rows.extend(table.rows),
        None if out.exists() && !begun => {
            let _ = fs::remove_file(&store.partial);
            return Err(StoreError::refused(format!(
                "{} has the results of another study, model or version; give another --out, or replace it with --restart",
                out.display()
            )));
        }
        None => {}
    }
    Ok(Found::Begun(store))
}

impl Store {
    /// Runs that are done.
    pub fn done(&self) -> impl Iterator<Item = u64> + '_ {
        self.rows.iter().filter_map(|row| match row.first() {
            Some(Value::Integer(run)) => u64::try_from(*run).ok(),
            _ => None,
        })
    }

    /// The rows there are, by no order.
    pub fn rows(&self) -> &[Vec<Value>] {
        &self.rows
    }

    /// Adds a row: on the disk in one write, so that what ends the process leaves it whole or torn, but never in between others.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn add(&mut self, cells: Vec<Value>) -> io::Result<()> {
        self.file.write_all(table::line(&cells).as_bytes())?;
        self.rows.push(cells);
        Ok(())
    }

    /// Where rows are until all are there.
    pub fn partial(&self) -> &Path {
        &self.partial
    }

    /// Writes the results, in order and whole, and removes the file that grew.
    ///
    /// # Errors
    /// They cannot be written; every finished run is still in the file that grew.
    pub fn finish(self, study: &Study) -> Result<Table, StoreError> {
        let table = sorted(study, self.rows);
        let kept = |error: &dyn Display| {
            StoreError::broken(format!(
                "{error}; every finished run is in {}: the same command goes on from there",
                self.partial.display()
            ))
        };
        table::write(&self.out, &table).map_err(|error| kept(&error))?;
        let (crc, _) = checksum(&self.out, u64::MAX).map_err(|error| kept(&error))?;
        let text = Beside::new(study, table.rows.len() as u64, crc).text().map_err(|error| kept(&error))?;
        let name = beside_name(&self.out);
        replace(&name, |out| out.write_all(text.as_bytes()))
            .map_err(|error| StoreError::broken(format!("cannot write {}: {error}", name.display())))?;
        fs::remove_file(&self.partial).map_err(|error| kept(&error))?;
        Ok(table)
    }

    /// Takes the rows of an earlier run of this study; says whether there was one.
    fn resume(&mut self, study: &Study, restart: bool) -> Result<bool, StoreError> {
        let mut bytes = Vec::new();
        self.file.read_to_end(&mut bytes).map_err(|error| self.failed(&error))?;
        let head = head(study, &self.columns);
        let partial = self.partial.display();
        let out = self.out.display();
        let first = bytes.split(|byte| *byte == b'\n').next().unwrap_or_default();
        if !MAGIC.as_bytes().starts_with(&first[..first.len().min(MAGIC.len())]) {
            return Err(StoreError::refused(format!(
                "{partial} is needed for unfinished results, but is something else; move it away or give another --out"
            )));
        }
        // A head that is torn has no rows behind it.
        if restart || head.as_bytes().starts_with(&bytes) && bytes.len() < head.len() {
            self.file
                .set_len(0)
                .and_then(|()| self.file.seek(SeekFrom::Start(0)).map(drop))
                .map_err(|e| self.failed(&e))?;
            self.file.write_all(head.as_bytes()).map_err(|error| self.failed(&error))?;
            return Ok(restart);
        }
        let Some(lines) = bytes.strip_prefix(head.as_bytes()) else {
            return Err(StoreError::refused(format!(
                "{partial} holds unfinished results of another study, model or version, or this study has been changed since; \
                 --restart begins anew and gives them up, another --out leaves them alone ({out} is as it was)"
            )));
        };
        let (rows, good) = table::read_rows(lines, &self.columns);
        let end = (head.len() + good) as u64;
        self.file
            .set_len(end)
            .and_then(|()| self.file.seek(SeekFrom::Start(end)).map(drop))
            .map_err(|e| self.failed(&e))?;
        self.rows = rows;
        Ok(true)
    }

    fn failed(&self, error: &io::Error) -> StoreError {
        StoreError::broken(format!("cannot write {}: {error}", self.partial.display()))
    }
}

/// The first two lines of unfinished results: which study, and the columns.
fn head(study: &Study, columns: &[Column]) -> String {
    let names: Vec<Value> = columns.iter().map(|column| Value::from(column.name.as_str())).collect();
    format!("{MAGIC} {} of {}, unfinished\n{}", study.fingerprint(), study.runs(), table::line(&names))
}

/// Refuses to replace, also for `--restart`, what no run of a study has written, and what has been changed since.
fn refuse_foreign(study: &Study, out: &Path, partial: &Path) -> Result<(), StoreError> {
    let beside = beside(out);
    let refused = |path: &Path, whose: &str| {
        Err(StoreError::refused(format!(
            "{} is there already, and not as a run {whose}left it, so it is left alone; give another --out, or delete it \
             first",
            path.display()
        )))
    };
    if matches!(beside, Some(Err(_))) {
        return refused(&beside_name(out), "");
    }
    if !fs::metadata(out).is_ok_and(|found| found.is_file() && found.len() > 0) {
        return Ok(());
    }
    let left = matches!(&beside, Some(Ok(beside)) if beside.is_of(out));
    // A command that was killed between its last two files has left the rows too.
    let killed = || partial.exists() && rows(study, out).is_some();
    if left || killed() { Ok(()) } else { refused(out, "of this study ") }
}

/// A table that has the columns of a study.
fn rows(study: &Study, out: &Path) -> Option<Table> {
    let table = match table::format(out).ok()? {
        table::Format::Csv => table::read_csv(out, &columns(study)).ok()?,
        table::Format::Parquet => table::read(out).ok()?,
    };
    (table.columns == columns(study)).then_some(table)
}

/// Results that a run of this study has written and nobody has touched since.
fn finished(study: &Study, out: &Path) -> Option<Table> {
    let beside = beside(out)?.ok()?;
    if beside.fingerprint != study.fingerprint() || !beside.is_of(out) {
        return None;
    }
    rows(study, out)
}

/// Opens the file that grows and locks it, so that no two commands write one.
fn claim(out: &Path, partial: &Path) -> Result<File, StoreError> {
    let failed = |error: io::Error| {
        StoreError::refused(format!("cannot write {}: {error}; give a place where you may write", partial.display()))
    };
    loop {
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).create(true).truncate(false).open(partial).map_err(failed)?;
        match FileExt::try_lock(&file) {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(StoreError::refused(format!(
                    "another command is writing {} (its rows are in {}); wait for it, or give another --out",
                    out.display(),
                    partial.display()
                )));
            }
            Err(TryLockError::Error(error)) => return Err(failed(error)),
        }
        // The command that held it may have removed it between the two.
        if is_at(&file, partial) {
            return Ok(file);
        }
    }
}

/// The files beside results: rows until all are there, and the study.
pub fn companions(out: &Path) -> [PathBuf; 2] {
    let mut partial = OsString::from(out);
    partial.push(".partial.csv");
    [partial.into(), beside_name(out)]
}
