//! The class `Result`: columns, events and summary of a run.

use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

use arrow_array::{ArrayRef, RecordBatch};
use phalanx::format::{Report, ToReport};
use phalanx::log::copy_log;
use phalanx::page::{Page, render_page};
use phalanx::report::document::RunReport;
use phalanx::report::replay::ReplayReport;
use phalanx::scene::Scene;
use phalanx::trace::{Channel, Event, Model, Recording, Schema};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict};

use super::simulate::{self, RunInput};
use super::simulation::event_list;
use super::{columns, conversion, errors};

/// The results of a run, or of the run in a log. All values are in SI; column names contain the units.
#[pyclass(frozen, module = "phalanx")]
pub struct Result {
    channels: Vec<Channel>,
    /// One column for each channel.
    arrays: Vec<ArrayRef>,
    events: Vec<Event>,
    schema: Schema,
    report: ResultReport,
    source: Source,
    /// Derivatives by field, as JSON.
    gradient: Option<String>,
}

/// The report of a result: of `phalanx run`, or of `phalanx replay`.
pub enum ResultReport {
    /// Built when first read: the closures of a grasp take longer than the rest of a result.
    Run(Box<LazyLock<RunReport, Box<dyn FnOnce() -> RunReport + Send>>>),
    Log(Box<ReplayReport>),
}

impl ResultReport {
    fn json(&self) -> String {
        match self {
            ResultReport::Run(report) => report.json(),
            ResultReport::Log(report) => report.json(),
        }
    }

    fn report(&self) -> Report {
        match self {
            ResultReport::Run(report) => report.report(),
            ResultReport::Log(report) => report.report(),
        }
    }
}

/// Source of a result: the input of a run; or a log, and its scene if the log has all data of a page.
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
        let (channels, arrays) =
            columns.into_iter().map(|(channel, values)| (channel, columns::array_of_numbers(values))).unzip();
        Result { channels, arrays, events, schema, report, source, gradient }
    }

    /// Returns all columns as a batch. It is built when needed: names and units of its fields cost more than the arrays.
    fn batch(&self) -> PyResult<RecordBatch> {
        columns::channel_batch(&self.channels, &self.arrays)
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
        let index = self.channels.iter().position(|channel| channel.name == column).ok_or_else(|| {
            let similar = phalanx::scene::closest_match(column, &self.columns());
            let suggestion =
                similar.map(|name| format!("; did you mean \"{name}\"?")).unwrap_or_else(|| ".".to_string());
            PyKeyError::new_err(format!(
                "{column} is not a column of this run{suggestion} result.columns lists all columns"
            ))
        })?;
        columns::number_array(py, &self.arrays[index])
    }

    /// Names of all columns with their units, as in `phalanx replay --csv`: `time_s` first, the energies last.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.channels.iter().map(|channel| channel.name.as_str()).collect()
    }

    /// Times of the samples, s. Two samples may have the same time, before and after an event.
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        columns::number_array(py, &self.arrays[0])
    }

    /// Contact events in order of time, as `phalanx.Event`.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        event_list(py, &self.schema, &self.events)
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
        let fingers = self.schema.fingers.len();
        if fingers == 1 {
            return self.summary_entry(py, "criteria");
        }
        let grasp = self.summary_entry(py, "grasp")?;
        if grasp.is_none() {
            return Ok(grasp);
        }
        let criteria = PyDict::new(py);
        if fingers > 1 {
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
    fn _repr_html_(&self) -> Option<String> {
        let page = self.html()?.replace('&', "&amp;").replace('"', "&quot;");
        Some(format!(
            "<iframe srcdoc=\"{page}\" sandbox=\"allow-scripts allow-downloads\" width=\"100%\" height=\"720\" \
             style=\"border:0\" title=\"phalanx\"></iframe>"
        ))
    }

    /// Returns the animated page of `phalanx run --plot`. None for a log without a readable scene.
    ///
    /// This repeats the run, or reads the log again.
    fn html(&self) -> Option<String> {
        let (scene, label, recorder) = match &self.source {
            Source::Run(input) => (&input.scene, input.model.name().to_string(), simulate::playback(input)?),
            Source::Log(log, scene) => {
                let ResultReport::Log(report) = &self.report else { return None };
                let label = report.model.clone().unwrap_or_else(|| "run".to_string());
                (&**scene.as_ref()?, label, simulate::playback_of_log(log)?)
            }
        };
        let grasp = match &self.report {
            ResultReport::Run(report) => report.played_grasp(),
            ResultReport::Log(report) => report.played_grasp(),
        };
        Some(render_page(&Page {
            title: scene.name.clone(),
            description: scene.description.clone(),
            runs: vec![recorder.into_playback(&label, scene, self.report.report()).with_grasp(grasp)],
            ..Page::default()
        }))
    }

    fn __len__(&self) -> usize {
        self.arrays[0].len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let text = |key: &str| -> PyResult<String> { Ok(self.summary_entry(py, key)?.str()?.to_string()) };
        let (scene, model, completed) = (text("scene")?, text("model")?, text("completed")?);
        let (samples, columns, events) = (self.__len__(), self.arrays.len(), self.events.len());
        let suffix = if completed == "True" { "" } else { ", not completed" };
        Ok(format!(
            "<phalanx.Result of \"{scene}\": {model} model, {samples} samples of {columns} columns, {events} events{suffix}>"
        ))
    }
}

/// Parses the name of a model.
pub fn model(py: Python<'_>, name: &str) -> PyResult<Model> {
    conversion::parse_keyword("model", name).map_err(|error| errors::argument(py, error))
}
