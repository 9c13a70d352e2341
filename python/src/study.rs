//! Sweeps of study files: all of them, parts of them, and parts joined.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use phalanx::study::parts::{self, Made, Merged, PartError, Work};
use phalanx::study::store::{Found, StoreError, open};
use phalanx::study::sweep::{Row, Study, files, in_one_piece, load as loaded, run_while, shard, sorted};
use phalanx::table;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::table::Table;
use super::{errors, watch, words};

/// Reads a study file.
pub fn load(py: Python<'_>, path: &Path, model: Option<&str>, check: bool) -> PyResult<Study> {
    let mut study = loaded(path).map_err(|error| errors::study(py, &error))?;
    if let Some(model) = model {
        study.model = super::result::model(py, model)?;
    }
    study.checked = check;
    Ok(study)
}

/// Makes the first `most` runs of a study, on `threads` threads.
pub fn rows(py: Python<'_>, study: &Study, threads: usize, most: u64) -> PyResult<table::Table> {
    in_one_piece(study, most).map_err(|error| errors::sweep(py, format!("error: {error}")))?;
    let made = watch::free(py, |go_on| {
        let mut rows = Vec::new();
        let take = |row: Row| {
            rows.push(row.cells);
            true
        };
        run_while(study, threads, most, &HashSet::new(), go_on, take);
        rows
    })?;
    Ok(sorted(study, made))
}

/// Makes every run of a study (`phalanx sweep`).
///
/// study: path of a study file (TOML). threads: 0 for one on each core. out: CSV or Parquet by the name; then a sweep that was broken
/// off goes on where it was when it is called again, and OUT.study.json beside it says of which study the results are.
/// model: instead of the study's. check: check every run. limit: only the first so many runs. restart: begin anew, whatever is in out.
///
/// A scene that is not valid and a run that does not end are rows, with status and reason; so are designs that cannot grasp, which
/// have a reason and no class. Raises StudyError for what is wrong
/// with the study, or with the place of its results.
#[pyfunction]
#[pyo3(signature = (study, threads = 0, out = None, *, model = None, check = false, limit = None, restart = false))]
#[expect(clippy::too_many_arguments, reason = "the flags of the command")]
pub fn sweep(
    py: Python<'_>,
    study: PathBuf,
    threads: usize,
    out: Option<PathBuf>,
    model: Option<&str>,
    check: bool,
    limit: Option<u64>,
    restart: bool,
) -> PyResult<Table> {
    let study = load(py, &study, model, check)?;
    let most = limit.unwrap_or(u64::MAX);
    let table = match out {
        None => rows(py, &study, threads, most)?,
        Some(out) => kept(py, &study, threads, &out, most, restart)?,
    };
    Table::new(py, table, None)
}

/// The same with results on the disk.
fn kept(py: Python<'_>, study: &Study, threads: usize, out: &Path, most: u64, restart: bool) -> PyResult<table::Table> {
    let raised = |error: StoreError| errors::sweep(py, format!("error: {error}"));
    let mut store = match open(study, out, most, restart).map_err(raised)? {
        Found::Complete(table) => return Ok(table),
        Found::Begun(store) => store,
    };
    let done: HashSet<u64> = store.done().collect();
    let (store, broken) = watch::free(py, |go_on| {
        let mut broken = None;
        run_while(study, threads, most, &done, go_on, |row| {
            // Nothing may follow what could not be written.
            if broken.is_none() {
                broken = store.add(row.cells).err();
            }
            broken.is_none()
        });
        (store, broken)
    })?;
    if let Some(error) = broken {
        return Err(errors::sweep(py, format!("error: cannot write {}: {error}", store.partial().display())));
    }
    store.finish(study).map_err(raised)
}

/// Makes one part of a study into a Parquet file that appears whole or not at all (`phalanx sweep --shard k/n`).
///
/// k: from 1 to n. A part that is there already is left as it is, so the same call again takes a broken sweep up. Returns what the
/// part is: `shard`, `of`, `first_run`, `last_run`, `runs` (of the whole study), …, and `made_now`, how many runs were made now.
#[pyfunction]
#[pyo3(signature = (study, k, n, out, threads = 0, *, model = None, check = false, restart = false))]
#[expect(clippy::too_many_arguments, reason = "the flags of the command")]
pub fn sweep_shard<'py>(
    py: Python<'py>,
    study: PathBuf,
    k: u64,
    n: u64,
    out: PathBuf,
    threads: usize,
    model: Option<&str>,
    check: bool,
    restart: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let study = load(py, &study, model, check)?;
    let shard = shard(&study, k, n).map_err(|error| part(py, &error.into()))?;
    let work = Work { threads, restart };
    let made = watch::free(py, |go_on| parts::write_part(&study, shard, &out, work, go_on, |_| {}))?;
    let Made { part: info, ran, .. } = made.map_err(|error| part(py, &error))?;
    let found = words::json(py, &serde_json::to_string(&info).unwrap_or_default())?.cast_into::<PyDict>()?;
    found.set_item("made_now", ran.map_or(0, |ran| ran.runs))?;
    Ok(found)
}

/// Joins the parts of a study to the results of the whole (`phalanx sweep merge`): out and OUT.study.json get the very bytes that the
/// undisturbed sweep writes.
///
/// parts: files, or directories of them, in any order. Raises StudyError with what is missing, there twice, damaged or foreign.
/// Returns `parts`, `bytes` and `runs`.
#[pyfunction]
#[pyo3(signature = (study, parts, out, *, model = None, check = false))]
pub fn sweep_merge<'py>(
    py: Python<'py>,
    study: PathBuf,
    parts: Vec<PathBuf>,
    out: PathBuf,
    model: Option<&str>,
    check: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let study = load(py, &study, model, check)?;
    let merged = watch::free(py, |go_on| parts::merge(&study, &parts, &out, &|| go_on(), &mut |_| {}))?;
    let Merged { parts, bytes, found } = merged.map_err(|error| part(py, &error))?;
    let said = PyDict::new(py);
    said.set_item("parts", parts)?;
    said.set_item("bytes", bytes)?;
    said.set_item("runs", found.runs)?;
    Ok(said)
}

/// The files of a study: its own, then those of its base scene.
#[pyfunction]
pub fn _study_files(py: Python<'_>, study: PathBuf) -> PyResult<Vec<PathBuf>> {
    files(&study).map_err(|error| errors::study(py, &error))
}

/// What a study is: `name`, `model`, `runs`, `designs`, and `fingerprint`, which tells studies apart whose results differ.
#[pyfunction]
#[pyo3(signature = (study, *, model = None, check = false))]
pub fn study_info<'py>(
    py: Python<'py>,
    study: PathBuf,
    model: Option<&str>,
    check: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let study = load(py, &study, model, check)?;
    let said = PyDict::new(py);
    said.set_item("name", &study.name)?;
    said.set_item("model", study.model.name())?;
    said.set_item("runs", study.runs())?;
    said.set_item("designs", study.designs())?;
    said.set_item("fingerprint", study.fingerprint())?;
    Ok(said)
}

fn part(py: Python<'_>, error: &PartError) -> PyErr {
    errors::sweep(py, format!("error: {error}"))
}
