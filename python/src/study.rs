//! Sweeps of study files, in one piece or in parts.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use phalanx::parallel::{ComputeError, Monitor};
use phalanx::study::parts::{self, MergeResult, WrittenPart};
use phalanx::study::results::{OpenedResults, open};
use phalanx::study::sweep::{
    Row, Study, check_unsharded, load as load_study_file, run_while, shard, sorted_table, source_files,
};
use phalanx::table;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::table::Table;
use super::{conversion, errors, interruptible};

/// Reads a study file.
fn load(py: Python<'_>, path: &Path, model: Option<&str>, preset: Option<&str>, check: bool) -> PyResult<Study> {
    let mut study = load_study_file(path).map_err(|error| errors::study(py, &error))?;
    if let Some(model) = model {
        study.model = super::result::model(py, model)?;
    }
    set_preset(py, &mut study, preset)?;
    study.checked = check;
    Ok(study)
}

/// Sets the preset of all runs of a study by its name.
pub fn set_preset(py: Python<'_>, study: &mut Study, name: Option<&str>) -> PyResult<()> {
    let preset = super::simulate::parse_preset(py, name)?;
    study.set_preset(preset).map_err(|error| errors::argument(py, error))
}

/// Simulates the first `limit` runs of a study, on `threads` threads, and returns their rows.
pub fn run_rows(py: Python<'_>, study: &Study, threads: usize, limit: u64) -> PyResult<table::Table> {
    check_unsharded(study, limit).map_err(|error| errors::sweep(py, format!("error: {error}")))?;
    let rows = interruptible::run(py, |keep_running| {
        let mut rows = Vec::new();
        let push = |row: Row| {
            rows.push(row.cells);
            true
        };
        run_while(study, threads, 1..=limit, &HashSet::new(), keep_running, push);
        rows
    })?;
    Ok(sorted_table(study, rows))
}

/// Simulates all runs of a study (`phalanx sweep`).
///
/// study: path of a study file (TOML). threads: number of threads; 0 for one per core. out: path of the results, CSV or
/// Parquet according to its suffix. With `out`, an interrupted sweep resumes when it is called again, and the file
/// OUT.study.json identifies the study. model: overrides the model of the study. preset: replaces the integrator
/// settings of all runs ("draft" for searches). check: check every run. limit: simulate only the first `limit` runs.
/// restart: discard earlier results in `out`.
///
/// An invalid scene or an incomplete run gives a row with status and reason. A design that cannot grasp its object has
/// a reason and no class. Raises StudyError for an invalid study or unusable results.
#[pyfunction]
#[pyo3(signature = (study, threads = 0, out = None, *, model = None, preset = None, check = false, limit = None, restart = false))]
#[expect(clippy::too_many_arguments, reason = "the flags of the command")]
pub fn sweep(
    py: Python<'_>,
    study: PathBuf,
    threads: i128,
    out: Option<PathBuf>,
    model: Option<&str>,
    preset: Option<&str>,
    check: bool,
    limit: Option<i128>,
    restart: bool,
) -> PyResult<Table> {
    let threads = conversion::threads(py, threads)?;
    let limit = limit.map_or(Ok(u64::MAX), |limit| conversion::count(py, "limit", limit, 0..=u64::MAX))?;
    let study = load(py, &study, model, preset, check)?;
    let table = match out {
        None => run_rows(py, &study, threads, limit)?,
        Some(out) => run_to_file(py, &study, threads, &out, limit, restart)?,
    };
    Table::new(py, table, None)
}

/// Simulates the runs of a study that are missing in the file `out`, and returns the complete table.
fn run_to_file(
    py: Python<'_>,
    study: &Study,
    threads: usize,
    out: &Path,
    limit: u64,
    restart: bool,
) -> PyResult<table::Table> {
    let results_error = |error: ComputeError| results_error(py, &error);
    let mut store = match open(study, out, limit, restart).map_err(results_error)? {
        OpenedResults::Complete(table) => return Ok(table),
        OpenedResults::Incomplete(store) => store,
    };
    let completed: HashSet<u64> = store.completed_runs().collect();
    let (store, write_error) = interruptible::run(py, |keep_running| {
        let mut write_error = None;
        run_while(study, threads, 1..=limit, &completed, keep_running, |row| {
            // After a failed write, later rows are dropped.
            if write_error.is_none() {
                write_error = store.append(row.cells).err();
            }
            write_error.is_none()
        });
        (store, write_error)
    })?;
    if let Some(error) = write_error {
        return Err(errors::sweep(py, format!("error: cannot write {}: {error}", store.partial_path().display())));
    }
    store.finish(study).map_err(results_error)
}

/// Simulates one part of a study and writes it atomically as a Parquet file (`phalanx sweep --shard k/n`).
///
/// k: number of the part, from 1 to n. An existing part is not simulated again, so repeating the call resumes an
/// interrupted sweep. Returns the description of the part: `shard`, `of`, `first_run`, `last_run`, `runs` (of the whole
/// study), …, and `made_now`, the number of new runs.
#[pyfunction]
#[pyo3(signature = (study, k, n, out, threads = 0, *, model = None, preset = None, check = false, restart = false))]
#[expect(clippy::too_many_arguments, reason = "the flags of the command")]
pub fn sweep_shard<'py>(
    py: Python<'py>,
    study: PathBuf,
    k: i128,
    n: i128,
    out: PathBuf,
    threads: i128,
    model: Option<&str>,
    preset: Option<&str>,
    check: bool,
    restart: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let threads = conversion::threads(py, threads)?;
    let [k, n] = [("k", k), ("n", n)].map(|(name, value)| conversion::count(py, name, value, 1..=u64::MAX));
    let (k, n) = (k?, n?);
    let study = load(py, &study, model, preset, check)?;
    let shard = shard(&study, k, n).map_err(|error| results_error(py, &ComputeError::Unsuitable(error)))?;
    let written = interruptible::run(py, |keep_running| {
        parts::write_part(&study, shard, &out, threads, restart, keep_running, |_| {})
    })?;
    let WrittenPart { part, stats, .. } = written.map_err(|error| results_error(py, &error))?;
    let info = conversion::parse_json(py, &serde_json::to_string(&part).unwrap_or_default())?.cast_into::<PyDict>()?;
    info.set_item("made_now", stats.map_or(0, |stats| stats.runs))?;
    Ok(info)
}

/// Merges the parts of a study (`phalanx sweep merge`).
///
/// The files `out` and OUT.study.json have the same bytes as those of an uninterrupted sweep. parts: files or
/// directories, in any order. Raises StudyError that names missing, duplicate, damaged or foreign parts. Returns
/// `parts`, `bytes` and `runs`.
#[pyfunction]
#[pyo3(signature = (study, parts, out, *, model = None, preset = None, check = false))]
pub fn sweep_merge<'py>(
    py: Python<'py>,
    study: PathBuf,
    parts: Vec<PathBuf>,
    out: PathBuf,
    model: Option<&str>,
    preset: Option<&str>,
    check: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let study = load(py, &study, model, preset, check)?;
    let merged =
        interruptible::run(py, |keep_running| parts::merge(&study, &parts, &out, &Monitor::silent(keep_running)))?;
    let MergeResult { parts, bytes, summary } = merged.map_err(|error| results_error(py, &error))?;
    let info = PyDict::new(py);
    info.set_item("parts", parts)?;
    info.set_item("bytes", bytes)?;
    info.set_item("runs", summary.runs)?;
    Ok(info)
}

/// Returns the files of a study: the study file, then the files of its base scene.
#[pyfunction]
pub fn _study_files(py: Python<'_>, study: PathBuf) -> PyResult<Vec<PathBuf>> {
    load_study_file(&study).map_err(|error| errors::study(py, &error))?;
    Ok(source_files(&study))
}

/// Describes a study: `name`, `model`, `runs`, `designs`, and `fingerprint`. Studies with different results have
/// different fingerprints.
#[pyfunction]
#[pyo3(signature = (study, *, model = None, preset = None, check = false))]
pub fn study_info<'py>(
    py: Python<'py>,
    study: PathBuf,
    model: Option<&str>,
    preset: Option<&str>,
    check: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let study = load(py, &study, model, preset, check)?;
    let info = PyDict::new(py);
    info.set_item("name", &study.name)?;
    info.set_item("model", study.model.name())?;
    info.set_item("runs", study.runs())?;
    info.set_item("designs", study.designs())?;
    info.set_item("fingerprint", study.fingerprint())?;
    Ok(info)
}

fn results_error(py: Python<'_>, error: &ComputeError) -> PyErr {
    errors::sweep(py, format!("error: {error}"))
}
