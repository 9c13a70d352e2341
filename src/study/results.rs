//! Results of a sweep on disk. Each finished run is appended to `OUT.partial.csv`, so that an interruption loses no
//! finished run. Finally all rows are written to OUT, in order.
//!
//! `OUT.study.json` contains the exact text of the study. Its fingerprint tells a repeated command whether the results
//! are its own; a CSV table has no place for it.

use std::collections::HashSet;
use std::ffi::OsString;
use std::fmt::Display;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use fs4::{FileExt, TryLockError};

use super::sweep::{Study, check_unsharded, columns, sorted_table};
use crate::files::{FileKind, cannot_write, check_target, is_forced, replace_file};
use crate::log::is_same_file;
use crate::scene::Keyword as _;
use crate::table::{self, Table, Value};
use phalanx_parallel::ComputeError;

/// First words of a file of unfinished results.
const MAGIC: &str = "# phalanx sweep";

/// Error of a path that is unusable or contains other data, or of a part that does not fit.
pub(super) fn refused(reason: impl Display) -> ComputeError {
    ComputeError::Unsuitable(reason.to_string())
}

pub(super) fn write_failed(path: &Path, error: &io::Error) -> ComputeError {
    ComputeError::Failed(cannot_write(path, error))
}

/// Writes `OUT.study.json` for results with this number of rows: the study with its exact text.
pub(super) fn write_provenance(study: &Study, rows: u64, out: &Path) -> io::Result<()> {
    let [_, path] = companion_files(out);
    let mut provenance = serde_json::json!({
        "phalanx": env!("CARGO_PKG_VERSION"),
        "study": study.name,
        "model": study.model.name(),
        "fingerprint": study.fingerprint(),
        "rows": rows,
        "study_toml": study.source,
        "scene_toml": study.base,
    });
    if let Some(preset) = study.preset {
        provenance["preset"] = preset.keyword().into();
    }
    replace_file(&path, |file| writeln!(file, "{provenance:#}"))
}

/// Whether `OUT.study.json` names this study.
fn is_of_study(study: &Study, out: &Path) -> Result<bool, ComputeError> {
    let [_, path] = companion_files(out);
    let fingerprint = fs::read(&path).and_then(|bytes| {
        let provenance: serde_json::Value = serde_json::from_slice(&bytes)?;
        let not_ours = || io::Error::other("a sweep did not write it");
        provenance["fingerprint"].as_str().map(str::to_string).ok_or_else(not_ours)
    });
    match fingerprint {
        Ok(fingerprint) => Ok(fingerprint == study.fingerprint()),
        Err(error) if error.kind() == ErrorKind::NotFound || is_forced() => Ok(false),
        Err(error) => Err(refused(format!(
            "cannot read {}: {error}; it describes results of a sweep: give another --out, delete it, or replace it with --force",
            path.display()
        ))),
    }
}

/// Files next to the results: the unfinished results and the study.
pub(crate) fn companion_files(out: &Path) -> [PathBuf; 2] {
    [".partial.csv", ".study.json"].map(|suffix| {
        let mut name = OsString::from(out);
        name.push(suffix);
        name.into()
    })
}

/// Whether a path contains results of another study.
pub(super) fn has_other_results(study: &Study, out: &Path) -> Result<bool, ComputeError> {
    let exists = fs::metadata(out).is_ok_and(|found| found.is_file() && found.len() > 0);
    Ok(!is_of_study(study, out)? && exists && !is_forced())
}

pub enum OpenedResults {
    /// All requested runs are finished.
    Complete(Table),
    /// Some or all requested runs are missing.
    Incomplete(Store),
}

/// Unfinished results of a study, to which rows are appended one by one.
pub struct Store {
    out: PathBuf,
    partial: PathBuf,
    file: File,
    /// Rows so far, unordered.
    rows: Vec<Vec<Value>>,
}

fn run_numbers(rows: &[Vec<Value>]) -> impl Iterator<Item = u64> {
    rows.iter().filter_map(|row| u64::try_from(row.first()?.as_integer()?).ok())
}

/// Opens the results of the first `max_runs` runs of a study.
///
/// # Errors
/// Returns an error if the output path is unusable, contains results of another study, or is being written by another
/// command.
pub fn open(study: &Study, out: &Path, max_runs: u64, restart: bool) -> Result<OpenedResults, ComputeError> {
    table::format(out).map_err(refused)?;
    check_unsharded(study, max_runs).map_err(refused)?;
    check_target(out, FileKind::Table).map_err(refused)?;
    let requested = study.runs().min(max_runs);
    // Rows may have been removed or repeated, so their number does not tell.
    let is_complete = |table: &Table| {
        let runs: HashSet<u64> = run_numbers(&table.rows).filter(|run| (1..=requested).contains(run)).collect();
        runs.len() as u64 == requested
    };
    // Discarded results may be damaged, but OUT.study.json must be of a sweep.
    if is_of_study(study, out)?
        && !restart
        && let Some(table) = read_finished(study, out)?.filter(is_complete)
    {
        return Ok(OpenedResults::Complete(table));
    }
    let [partial, _] = companion_files(out);
    let file = open_locked(out, &partial)?;
    let mut store = Store { out: out.to_path_buf(), partial, file, rows: Vec::new() };
    let is_resumed = store.resume(study, restart)?;
    if restart {
        return Ok(OpenedResults::Incomplete(store));
    }
    // Another command may have finished before the lock was taken.
    match read_finished(study, out)? {
        Some(table) if is_complete(&table) => {
            let _ = fs::remove_file(&store.partial);
            return Ok(OpenedResults::Complete(table));
        }
        Some(table) => store.rows.extend(table.rows),
        None if !is_resumed && has_other_results(study, out)? => {
            let _ = fs::remove_file(&store.partial);
            return Err(refused(format!(
                "{} contains results of another study, model or version; give another --out, or replace it with --restart",
                out.display()
            )));
        }
        None => {}
    }
    Ok(OpenedResults::Incomplete(store))
}

/// Reads the finished results of this study; `None` if there are none, or the table has other columns.
fn read_finished(study: &Study, out: &Path) -> Result<Option<Table>, ComputeError> {
    if !is_of_study(study, out)? || !out.exists() {
        return Ok(None);
    }
    let columns = columns(study);
    let table = match table::format(out) {
        Ok(table::Format::Csv) => table::read_csv(out, &columns),
        _ => table::read(out),
    };
    match table {
        Ok(table) => Ok((table.columns == columns).then_some(table)),
        Err(_) if is_forced() => Ok(None),
        Err(error) => Err(refused(format!("{error}; or replace the results with --restart"))),
    }
}

/// Opens and locks the file of unfinished results, so that only one command writes to it.
fn open_locked(out: &Path, partial: &Path) -> Result<File, ComputeError> {
    let cannot_open = |error: io::Error| refused(format!("{}; give a writable path", cannot_write(partial, error)));
    loop {
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).create(true).truncate(false).open(partial).map_err(cannot_open)?;
        FileExt::try_lock(&file).map_err(|error| match error {
            TryLockError::WouldBlock => refused(format!(
                "another command is writing {} (its rows are in {}); wait for it to finish, or give another --out",
                out.display(),
                partial.display()
            )),
            TryLockError::Error(error) => cannot_open(error),
        })?;
        // The command that held the lock may have removed the file before it was locked here.
        if is_same_file(&file, partial) {
            return Ok(file);
        }
    }
}

impl Store {
    pub fn completed_runs(&self) -> impl Iterator<Item = u64> + '_ {
        run_numbers(&self.rows)
    }

    /// Appends a row in a single write, so that a killed process can truncate only the last row.
    pub fn append(&mut self, cells: Vec<Value>) -> io::Result<()> {
        self.file.write_all(table::format_csv_line(&cells).as_bytes())?;
        self.rows.push(cells);
        Ok(())
    }

    pub fn partial_path(&self) -> &Path {
        &self.partial
    }

    /// Writes the complete results in order, and removes the file of unfinished results.
    ///
    /// # Errors
    /// Returns an error if writing fails. The file of unfinished results then still contains every finished run.
    pub fn finish(self, study: &Study) -> Result<Table, ComputeError> {
        let Store { out, partial, rows, .. } = self;
        let table = sorted_table(study, rows);
        let finish = || write_provenance(study, table.rows.len() as u64, &out).and_then(|()| fs::remove_file(&partial));
        let written = table::write(&out, &table).map_err(|error| error.to_string());
        let written = written.and_then(|()| finish().map_err(|error| error.to_string()));
        written.map_err(|error| {
            let partial = partial.display();
            let hint = format!("every finished run is in {partial}; the same command resumes from there");
            ComputeError::Failed(format!("{error}; {hint}"))
        })?;
        Ok(table)
    }

    /// Reads the rows of an earlier, interrupted command. Returns whether there was one; always true with `restart`.
    fn resume(&mut self, study: &Study, restart: bool) -> Result<bool, ComputeError> {
        let failed = |error: io::Error| write_failed(&self.partial, &error);
        let columns = columns(study);
        let names: Vec<Value> = columns.iter().map(|column| Value::from(column.name.as_str())).collect();
        let (fingerprint, runs) = (study.fingerprint(), study.runs());
        let header = format!("{MAGIC} {fingerprint} of {runs}, unfinished\n{}", table::format_csv_line(&names));
        let mut bytes = Vec::new();
        self.file.read_to_end(&mut bytes).map_err(failed)?;
        let partial = self.partial.display();
        let is_foreign = !MAGIC.as_bytes().starts_with(&bytes[..bytes.len().min(MAGIC.len())]);
        if is_foreign && !is_forced() {
            return Err(refused(format!(
                "{partial} is the file for unfinished results, but contains other data; move it, give another --out, or \
                 replace it with --force"
            )));
        }
        // A truncated header has no rows after it.
        let is_empty = restart || is_foreign || header.as_bytes().starts_with(&bytes) && bytes.len() < header.len();
        let mut end = 0;
        if !is_empty {
            let lines = bytes.strip_prefix(header.as_bytes()).ok_or_else(|| {
                refused(format!(
                    "{partial} contains unfinished results of another study, model or version, or this study has been changed \
                     since; --restart discards them, another --out keeps them ({} is unchanged)",
                    self.out.display()
                ))
            })?;
            (self.rows, end) = table::read_rows(lines, &columns);
            end += header.len();
        }
        self.file.set_len(end as u64).and_then(|()| self.file.seek(SeekFrom::Start(end as u64))).map_err(failed)?;
        if is_empty {
            self.file.write_all(header.as_bytes()).map_err(failed)?;
        }
        Ok(restart || !is_empty)
    }
}
