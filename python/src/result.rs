//! A run: its columns, its events, what it came to.

use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::RecordBatch;
use phalanx::page::{Page, Reel, page};
use phalanx::scene::Scene;
use phalanx::trace::{Event, Layout, Model, Recording};
use phalanx::wording::Report;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict};

use super::simulate::{self, Made};
use super::{columns, errors, words};

/// A run of a scene, or what a log has of one. Figures are in SI, their names say the unit.
#[pyclass(frozen, module = "phalanx")]
pub struct Result {
    batch: RecordBatch,
    events: Vec<Event>,
    layout: Layout,
    /// The document that the command prints: of `phalanx run --json`, or of `phalanx replay --json`.
    document: String,
    film: Option<Arc<Film>>,
    source: Source,
}

/// What the page shows.
pub struct Film {
    pub scene: Scene,
    pub label: String,
    pub reel: Reel,
    pub summary: Report,
}

/// Where a result comes from.
pub enum Source {
    Run(Arc<Made>),
    Log(PathBuf),
}

impl Result {
    pub fn new(
        layout: Layout,
        recording: Recording,
        document: String,
        film: Option<Film>,
        source: Source,
    ) -> PyResult<Self> {
        let (columns, events) = recording.into_parts();
        let film = film.map(Arc::new);
        Ok(Result { batch: columns::batch(columns)?, events, layout, document, film, source })
    }

    fn part<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        let summary = words::json(py, &self.document)?;
        Ok(summary.cast::<PyDict>()?.get_item(key)?.unwrap_or_else(|| py.None().into_bound(py)))
    }
}

#[pymethods]
impl Result {
    /// A column as an array of numpy that cannot be written to, over the very numbers of the run: `result["q11_rad"]`. Names are
    /// those of `columns`; angles rad, rates rad/s, forces N, torques N·m, lengths m, energies J.
    fn __getitem__<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Bound<'py, PyAny>> {
        let array = self.batch.column_by_name(column).ok_or_else(|| {
            let near = phalanx::scene::nearest(column, &self.columns());
            let meant = near.map(|name| format!("; did you mean \"{name}\"?")).unwrap_or_default();
            PyKeyError::new_err(format!("{column}: no column of this run{meant} result.columns names all"))
        })?;
        columns::numpy(py, array)
    }

    /// Names of all columns with their units, as `phalanx replay --csv` has them: `time_s` first, the energies last.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.batch.schema_ref().fields().iter().map(|field| field.name().as_str()).collect()
    }

    /// Times of the samples, in s; two may share one, before and after an event.
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        columns::numpy(py, self.batch.column(0))
    }

    /// Changes of contact in order of time, a `phalanx.Event` each.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let class = py.import("phalanx.events")?.getattr("Event")?;
        let of = |event: &Event| {
            let place = self.layout.contacts.get(event.contact);
            let name = place.map_or("", |place| place.name.as_str());
            class.call1((event.time_s, name, event.kind.name(), event.approach_speed, event.impulse))
        };
        self.events.iter().map(of).collect()
    }

    /// The document of `phalanx run --json` (of a log: `phalanx replay --json`) as a dictionary.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        words::json(py, &self.document)
    }

    /// The same as `summary`.
    #[getter]
    fn outcome<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.summary(py)
    }

    /// By contact: first touch (s), touch-downs, largest force (N), deepest penetration (m), impulse (N·s).
    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.part(py, "contacts")
    }

    /// Of a finger: class, what decides it (`class_reason`), time to stability `tts_s`, `rebound_percent`, …; of a gripper what became
    /// of its object; of discs None (`contacts` has their restitution). None too where the run does not say: `summary["no_criteria"]`
    /// says why.
    #[getter]
    fn criteria<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let gripper = self.layout.fingers.len() > 1;
        self.part(py, if gripper { "grasp" } else { "criteria" })
    }

    /// Energies and works at the end, in J.
    #[getter]
    fn energies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.part(py, "energy")
    }

    /// What a second, independent resolution says of the error; None where the run was not checked.
    #[getter]
    fn check<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.part(py, "check")
    }

    /// Sentences on what makes the results doubtful, such as an energy balance that is off; empty for a sound run, None of a log.
    #[getter]
    fn warnings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.part(py, "warnings")
    }

    /// Whether the run got to its end.
    #[getter]
    fn completed<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.part(py, "completed")
    }

    /// All columns as a pandas DataFrame over the same numbers.
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        columns::pandas(py, &self.batch)
    }

    /// All columns as a Polars DataFrame over the same numbers.
    fn to_polars<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        columns::polars(slf.py(), slf.as_any())
    }

    /// All columns as a stream of Arrow, for pyarrow, Polars, DuckDB and others; the numbers are not copied.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // A wish that nobody has to grant.
        let _ = requested_schema;
        columns::stream(py, &self.batch)
    }

    /// Writes the log that `phalanx run --log` would (MCAP, for Foxglove, Rerun and PlotJuggler), byte for byte.
    ///
    /// The run is made again for it: the same scene gives the same run. Of a result that was read from a log, that file is copied.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        match &self.source {
            Source::Run(made) => simulate::save(py, Arc::clone(made), &path),
            Source::Log(log) => {
                let copied = std::fs::copy(log, &path).map(drop);
                copied.map_err(|error| {
                    errors::run(py, format!("cannot copy {} to {}: {error}", log.display(), path.display()), None)
                })
            }
        }
    }

    /// The moving page of `phalanx run --html`, in a frame of its own: what a notebook shows.
    fn _repr_html_(&self) -> Option<String> {
        let page = self.html()?.replace('&', "&amp;").replace('"', "&quot;");
        Some(format!(
            "<iframe srcdoc=\"{page}\" sandbox=\"allow-scripts allow-downloads\" width=\"100%\" height=\"720\" \
             style=\"border:0\" title=\"phalanx\"></iframe>"
        ))
    }

    /// The same page as a document of its own: what `phalanx run --html` writes. None of a log whose scene is lost.
    fn html(&self) -> Option<String> {
        let film = self.film.as_ref()?;
        let scene = &film.scene;
        Some(page(&Page {
            title: scene.name.clone(),
            description: scene.description.clone(),
            runs: vec![film.reel.clone().film(&film.label, scene, film.summary.clone())],
            ..Page::default()
        }))
    }

    fn __len__(&self) -> usize {
        self.batch.num_rows()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let text = |key: &str| -> PyResult<String> { Ok(self.part(py, key)?.str()?.to_string()) };
        let (scene, model, completed) = (text("scene")?, text("model")?, text("completed")?);
        let (samples, columns, events) = (self.batch.num_rows(), self.batch.num_columns(), self.events.len());
        let end = if completed == "True" { "" } else { ", not completed" };
        Ok(format!(
            "<phalanx.Result of \"{scene}\": {model} model, {samples} samples of {columns} columns, {events} events{end}>"
        ))
    }
}

/// The model of a name.
pub fn model(py: Python<'_>, name: &str) -> PyResult<Model> {
    words::word("model", name).map_err(|error| errors::argument(py, error))
}
