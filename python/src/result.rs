//! The class `Result`: columns, events and summary of a run.

use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use arrow_array::types::Float64Type;
use arrow_array::{Array, ArrayRef, PrimitiveArray, RecordBatch};
use phalanx::format::ToReport;
use phalanx::log::copy_log;
use phalanx::page::{Page, Playback, render_page};
use phalanx::report::document::RunReport;
use phalanx::report::replay::ReplayReport;
use phalanx::scene::Scene;
use phalanx::trace::{Channel, Model, Recording, Schema};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule, PyDict, PyIterator, PyType};

use super::columns::Heading;
use super::conversion::Reduced;
use super::simulate::{self, RunInput, SavedRun};
use super::simulation::{event_list, named_events};
use super::{columns, conversion, errors};

/// The results of a run, or of the run in a log. All values are in SI; column names contain the units.
#[pyclass(frozen, mapping, module = "phalanx")]
pub struct Result {
    headings: Vec<Heading>,
    /// One column for each heading.
    arrays: Vec<ArrayRef>,
    events: Vec<NamedEvent>,
    /// Number of fingers of the scene; 0 for mechanisms and discs.
    fingers: usize,
    report: ResultReport,
    source: Source,
    /// Derivatives by field, as JSON.
    gradient: Option<String>,
}

/// An event as the arguments of `phalanx.Event`: time, contact, kind, approach speed, impulse.
pub type NamedEvent = (f64, String, String, f64, f64);

/// The report of a result: that of `phalanx run`, or that of `phalanx replay`.
pub enum ResultReport {
    /// Built when first read: the closures of a grasp take longer than the rest of a result.
    Run(Box<LazyLock<RunReport, Box<dyn FnOnce() -> RunReport + Send>>>),
    Log(Box<ReplayReport>),
    /// Of a pickled result, as JSON.
    Saved(String),
}

impl ResultReport {
    fn json(&self) -> String {
        match self {
            ResultReport::Run(report) => report.json(),
            ResultReport::Log(report) => report.json(),
            ResultReport::Saved(json) => json.clone(),
        }
    }
}

/// Source of a result: either the input of a run, or a log. The scene of a log is included if the log has all data of a
/// page and is not pickled.
pub enum Source {
    Run(Arc<RunInput>),
    Log(PathBuf, Option<Box<Scene>>),
}

impl Result {
    pub fn new(
        schema: Schema,
        recording: Recording,
        report: ResultReport,
        source: Source,
        gradient: Option<String>,
    ) -> Self {
        let (columns, events) = recording.into_parts();
        let column = |(channel, values): (Channel, Vec<f64>)| {
            ((channel.name, channel.unit.to_string()), columns::array_of_numbers(values))
        };
        let (headings, arrays) = columns.into_iter().map(column).unzip();
        let (events, fingers) = (named_events(&schema, &events), schema.fingers.len());
        Result { headings, arrays, events, fingers, report, source, gradient }
    }

    /// Returns all columns as a batch. It is built when needed: names and units of its fields cost more than the arrays.
    fn batch(&self) -> PyResult<RecordBatch> {
        columns::number_batch(&self.headings, &self.arrays)
    }

    fn column_index(&self, column: &str) -> Option<usize> {
        self.headings.iter().position(|(name, _)| name == column)
    }

    /// Returns an entry of the summary, or None.
    fn summary_entry<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        let summary = conversion::parse_json(py, &self.report.json())?;
        Ok(summary.cast::<PyDict>()?.get_item(key)?.unwrap_or_else(|| py.None().into_bound(py)))
    }
}

#[pymethods]
impl Result {
    /// Returns a column as a read-only numpy array that shares memory with the run, such as `result["q11_rad"]`.
    ///
    /// `columns` lists the names. Units: angles rad, rates rad/s, forces N, torques N·m, lengths m, energies J.
    fn __getitem__<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Bound<'py, PyAny>> {
        match self.column_index(column) {
            Some(index) => columns::number_array(py, &self.arrays[index]),
            None => Err(columns::unknown_column(column, &self.columns(), "this run", "result.columns")),
        }
    }

    fn __contains__(&self, column: &Bound<'_, PyAny>) -> bool {
        column.extract::<&str>().is_ok_and(|column| self.column_index(column).is_some())
    }

    /// Iterates over the names of the columns.
    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        self.columns().into_pyobject(py)?.try_iter()
    }

    /// Returns a column, or a default if there is none of this name.
    #[pyo3(signature = (key, default = None, /))]
    fn get<'py>(&self, key: &Bound<'py, PyAny>, default: Option<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        let py = key.py();
        match self.__contains__(key) {
            true => self.__getitem__(py, key.extract()?),
            false => Ok(default.unwrap_or_else(|| py.None().into_bound(py))),
        }
    }

    /// Names of the columns, as a view.
    fn keys<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        view(slf, "KeysView")
    }

    /// Columns, as a view.
    fn values<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        view(slf, "ValuesView")
    }

    /// Pairs of name and column, as a view.
    fn items<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        view(slf, "ItemsView")
    }

    /// Names of all columns with their units, as in `phalanx replay --csv`: `time_s` first, the energies last.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.headings.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// Times of the samples, s. Two samples may have the same time, before and after an event.
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        columns::number_array(py, &self.arrays[0])
    }

    /// Contact events in order of time, as `phalanx.Event`.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        event_list(py, self.events.clone())
    }

    /// The document of `phalanx run --json` (for a log: `phalanx replay --json`) as a dictionary.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        conversion::parse_json(py, &self.report.json())
    }

    /// Same as `summary`.
    #[getter]
    fn outcome<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.summary(py)
    }

    /// For each contact: time of the first touch-down (s), number of touch-downs, largest force (N), largest
    /// penetration (m), impulse (N·s).
    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.summary_entry(py, "contacts")
    }

    /// Criteria of a finger (class, its reason `class_reason`, time to stability `tts_s`, `rebound_percent`, …), or the
    /// fate of the object of a hand: a dictionary whose `grasp` has fate, reason, times, pairs and margin. That of a gripper
    /// also has the entries of its `grasp` itself.
    ///
    /// None for discs (`contacts` contains their restitution), and for a run without criteria; `summary["no_criteria"]` or
    /// `summary["no_grasp"]` gives the reason.
    #[getter]
    fn criteria<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        if self.fingers == 1 {
            return self.summary_entry(py, "criteria");
        }
        let grasp = self.summary_entry(py, "grasp")?;
        if grasp.is_none() {
            return Ok(grasp);
        }
        let criteria = PyDict::new(py);
        if self.fingers > 1 {
            criteria.update(grasp.cast()?)?;
        }
        criteria.set_item("grasp", grasp)?;
        Ok(criteria.into_any())
    }

    /// Energies and work at the end, J.
    #[getter]
    fn energies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.summary_entry(py, "energy")
    }

    /// Derivatives of the run by the fields given to `run(…, gradient=[…])`, in SI units; None without them.
    ///
    /// `gradient["design.base"]` has `end` (of the last sample, by column), `events` (`time`: of the time of the event,
    /// `state`: of the sample at it) and `tts_s` (time to stability). `end` and `state` have `values`, `errors` (estimates)
    /// and `reason`; the others have `value`, `error` and `reason`. Where there is no derivative, `reason` is a sentence.
    #[getter]
    fn gradient<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match &self.gradient {
            Some(gradient) => conversion::parse_json(py, gradient),
            None => Ok(py.None().into_bound(py)),
        }
    }

    /// Error estimate from a second, independent resolution; None if the run was not checked.
    #[getter]
    fn check<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.summary_entry(py, "check")
    }

    /// Reasons to doubt the results, such as an unbalanced energy; empty for a valid run, None for a log.
    #[getter]
    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.summary_entry(py, "warnings")
    }

    /// Whether the run reached its full duration; None if a log ends too early to tell.
    #[getter]
    fn completed<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.summary_entry(py, "completed")
    }

    /// Returns all columns as a pandas DataFrame that shares memory with the run.
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        columns::to_pandas(py, &self.batch()?)
    }

    /// Returns all columns as a Polars DataFrame that shares memory with the run.
    fn to_polars<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        columns::to_polars(slf.py(), slf.as_any())
    }

    /// Returns all columns as an Arrow stream, for pyarrow, Polars, DuckDB and others, without a copy.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // The protocol allows a producer to ignore the requested schema.
        let _ = requested_schema;
        columns::arrow_stream(py, &self.batch()?)
    }

    /// Supports the dataframe interchange protocol through pyarrow, for libraries without Arrow's C stream interface.
    ///
    /// Raises ImportError without pyarrow.
    #[pyo3(signature = (nan_as_null = false, allow_copy = true))]
    fn __dataframe__<'py>(slf: &Bound<'py, Self>, nan_as_null: bool, allow_copy: bool) -> PyResult<Bound<'py, PyAny>> {
        columns::interchange(slf.as_any(), nan_as_null, allow_copy)
    }

    /// Writes the same log as `phalanx run --log`, byte for byte (MCAP, for Foxglove, Rerun and PlotJuggler).
    ///
    /// This repeats the run; the same scene gives the same run. For a result from a log, it copies the file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        match &self.source {
            Source::Run(input) => simulate::save(py, Arc::clone(input), &path),
            Source::Log(log, _) => copy_log(log, &path).map_err(|error| errors::run(py, error, None)),
        }
    }

    /// Returns the page of `html` in a frame, for notebooks.
    fn _repr_html_(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let page = self.html(py)?.map(|page| page.replace('&', "&amp;").replace('"', "&quot;"));
        Ok(page.map(|page| {
            format!(
                "<iframe srcdoc=\"{page}\" sandbox=\"allow-scripts allow-downloads\" width=\"100%\" height=\"720\" \
             style=\"border:0\" title=\"phalanx\"></iframe>"
            )
        }))
    }

    /// Returns the animated page of `phalanx run --plot`. None for a log without a readable scene.
    ///
    /// This repeats the run, or reads the log again.
    fn html(&self, py: Python<'_>) -> PyResult<Option<String>> {
        Ok(match (&self.source, &self.report) {
            (Source::Run(input), ResultReport::Run(report)) => page_of_run(input, report),
            (Source::Run(input), _) => simulate::report(input).and_then(|report| page_of_run(input, &report)),
            (Source::Log(log, Some(scene)), ResultReport::Log(report)) => page_of_log(log, scene, report),
            (Source::Log(log, _), ResultReport::Saved(_)) => simulate::read_log(py, log.clone())?.html(py)?,
            (Source::Log(..), _) => None,
        })
    }

    /// Supports pickling, such as for other processes: with the numbers, without repeating the run.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py, (SavedResult<'py>,)>> {
        let (py, result) = (slf.py(), slf.get());
        let column = |((name, unit), array): (&Heading, &ArrayRef)| {
            let numbers = array.as_any().downcast_ref::<PrimitiveArray<Float64Type>>();
            let bytes = conversion::to_bytes(numbers.map_or(&[], |numbers| numbers.values()));
            (name.clone(), unit.clone(), PyBytes::new(py, &bytes))
        };
        let (run, log) = match &result.source {
            Source::Run(input) => (Some(input.saved(py)?), None),
            Source::Log(path, _) => (None, Some(path.clone())),
        };
        let saved = SavedResult {
            columns: result.headings.iter().zip(&result.arrays).map(column).collect(),
            events: result.events.clone(),
            fingers: result.fingers,
            summary: result.report.json(),
            gradient: result.gradient.clone(),
            run,
            log,
        };
        Ok((py.get_type::<Self>().getattr("_restore")?, (saved,)))
    }

    #[classmethod]
    fn _restore(class: &Bound<'_, PyType>, saved: SavedResult<'_>) -> PyResult<Self> {
        let column = |(name, unit, bytes): (String, String, Bound<'_, PyBytes>)| {
            ((name, unit), columns::array_of_numbers(conversion::from_bytes(bytes.as_bytes())))
        };
        let (headings, arrays) = saved.columns.into_iter().map(column).unzip();
        let source = match (saved.run, saved.log) {
            (Some(run), _) => Source::Run(Arc::new(RunInput::restore(class.py(), &run)?)),
            (None, log) => Source::Log(log.unwrap_or_default(), None),
        };
        let (events, fingers, report) = (saved.events, saved.fingers, ResultReport::Saved(saved.summary));
        Ok(Result { headings, arrays, events, fingers, report, source, gradient: saved.gradient })
    }

    /// Number of columns.
    fn __len__(&self) -> usize {
        self.arrays.len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let text = |key: &str| -> PyResult<String> { Ok(self.summary_entry(py, key)?.str()?.to_string()) };
        let (scene, model, completed) = (text("scene")?, text("model")?, text("completed")?);
        let (samples, columns, events) = (self.arrays[0].len(), self.arrays.len(), self.events.len());
        let suffix = if completed == "True" { "" } else { ", not completed" };
        Ok(format!(
            "<phalanx.Result of \"{scene}\": {model} model, {samples} samples of {columns} columns, {events} events{suffix}>"
        ))
    }
}

/// A view of a result as a mapping, by its class in `collections.abc`.
fn view<'py>(result: &Bound<'py, Result>, class: &str) -> PyResult<Bound<'py, PyAny>> {
    result.py().import("collections.abc")?.call_method1(class, (result,))
}

/// A result in the form in which it is pickled.
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
pub struct SavedResult<'py> {
    /// Name, unit, and numbers as bytes.
    columns: Vec<(String, String, Bound<'py, PyBytes>)>,
    events: Vec<NamedEvent>,
    fingers: usize,
    summary: String,
    gradient: Option<String>,
    run: Option<SavedRun>,
    log: Option<PathBuf>,
}

/// Renders the page of a run, which it repeats.
fn page_of_run(input: &RunInput, report: &RunReport) -> Option<String> {
    let playback = simulate::playback(input)?.into_playback(input.model.name(), &input.scene, report.report());
    Some(render(playback.with_grasp(report.played_grasp()), &input.scene))
}

/// Renders the page of a log, which it reads again.
fn page_of_log(log: &Path, scene: &Scene, report: &ReplayReport) -> Option<String> {
    let label = report.model.as_deref().unwrap_or("run");
    let playback = simulate::playback_of_log(log)?.into_playback(label, scene, report.report());
    Some(render(playback.with_grasp(report.played_grasp()), scene))
}

fn render(playback: Playback, scene: &Scene) -> String {
    let (title, description) = (scene.name.clone(), scene.description.clone());
    render_page(&Page { title, description, runs: vec![playback], ..Page::default() })
}

/// Parses the name of a model.
pub fn model(py: Python<'_>, name: &str) -> PyResult<Model> {
    conversion::parse_keyword("model", name).map_err(|error| errors::argument(py, error))
}
