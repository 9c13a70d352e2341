//! Functions that simulate scenes and read logs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use phalanx::format;
use phalanx::gradient::{Gradient, gradient as differentiate};
use phalanx::log::{self, FinishedRun, LogFile, LogSink, RunInfo};
use phalanx::page::PlaybackRecorder;
use phalanx::report::document::RunReport;
use phalanx::report::replay::{LogObserver, scene_in_log};
use phalanx::report::simulation::{CheckPolicy, SimulationOptions, report_of};
use phalanx::scene::{Keyword, Preset, Scene};
use phalanx::study::parameter::parameters;
use phalanx::trace::overrides::{self, Overrides};
use phalanx::trace::{Cancellable, Event, KeepRunning, Model, Recording, Sample, Schema, Sink, SinkError};
use phalanx::units::Dimension;
use pyo3::prelude::*;
use pyo3::types::PyString;

use super::result::{Result, ResultReport, Source, model};
use super::scene::{Scene as PythonScene, SceneLike};
use super::{conversion, errors, interruptible};

/// The input of a run. The run can be repeated from it.
pub struct RunInput {
    /// The scene, including the overrides.
    pub scene: Scene,
    pub model: Model,
    /// Name of the scene file in the log.
    scene_file: String,
    check: Option<bool>,
    loaded: PythonScene,
    overrides: Overrides,
}

/// The input of a run in the form in which it is pickled.
#[derive(FromPyObject, IntoPyObject)]
#[pyo3(from_item_all)]
pub struct SavedRun {
    scene: Py<PythonScene>,
    model: String,
    check: Option<bool>,
    preset: Option<String>,
    /// rtol, step, tolerance, duration, numeric rate and picture rate.
    numbers: [Option<f64>; 6],
}

impl RunInput {
    fn new(
        py: Python<'_>,
        loaded: PythonScene,
        model: Model,
        check: Option<bool>,
        overrides: Overrides,
    ) -> PyResult<Self> {
        let file_name = Path::new(loaded.file()).file_name().map(|name| name.to_string_lossy().into_owned());
        let scene_file = file_name.unwrap_or_else(|| "scene.toml".to_string());
        let mut scene = loaded.scene.clone();
        overrides.apply(model, &mut scene).map_err(|error| errors::argument(py, error))?;
        Ok(Self { scene, model, scene_file, check, loaded, overrides })
    }

    fn check_policy(&self) -> CheckPolicy {
        match self.check {
            Some(true) => CheckPolicy::Always,
            Some(false) => CheckPolicy::Never,
            None => CheckPolicy::IfCheap,
        }
    }

    pub fn saved(&self, py: Python<'_>) -> PyResult<SavedRun> {
        let Overrides { preset, rtol, step_s, tolerance_m, duration_s, numeric_hz, picture_hz } = &self.overrides;
        Ok(SavedRun {
            scene: Py::new(py, self.loaded.clone())?,
            model: self.model.name().to_string(),
            check: self.check,
            preset: preset.map(|preset| preset.keyword().to_string()),
            numbers: [*rtol, *step_s, *tolerance_m, *duration_s, *numeric_hz, *picture_hz],
        })
    }

    pub fn restore(py: Python<'_>, saved: &SavedRun) -> PyResult<Self> {
        let [rtol, step_s, tolerance_m, duration_s, numeric_hz, picture_hz] = saved.numbers;
        let preset = parse_preset(py, saved.preset.as_deref())?;
        let overrides = Overrides { preset, rtol, step_s, tolerance_m, duration_s, numeric_hz, picture_hz };
        Self::new(py, saved.scene.get().clone(), self::model(py, &saved.model)?, saved.check, overrides)
    }
}

/// Reads the name of a preset.
pub fn parse_preset(py: Python<'_>, name: Option<&str>) -> PyResult<Option<Preset>> {
    let preset = name.map(|name| conversion::parse_keyword::<Preset>("preset", name)).transpose();
    preset.map_err(|error| errors::argument(py, error))
}

/// Parses a setting of a run: a string with a unit, or a number in SI.
fn parse_setting(
    py: Python<'_>,
    name: &str,
    value: Option<&Bound<'_, PyAny>>,
    dimension: Dimension,
    parse: fn(&str) -> std::result::Result<f64, String>,
) -> PyResult<Option<f64>> {
    let text = value.map(|value| conversion::quantity_text(value, dimension)).transpose()?;
    let parsed = text.as_deref().map(parse).transpose();
    parsed.map_err(|error| errors::argument(py, format!("{name}: {error}")))
}

/// Simulates a scene.
///
/// model: "analytic" or "engine". check: True estimates the error with a second, independent resolution and detects a
/// chaotic outcome; None does so only if it is cheap (as `phalanx run` does); False never does. log: path of a log to
/// write (MCAP).
///
/// The other arguments replace settings of the scene: preset "draft", "engineering" or "reference" (analytic), rtol
/// (analytic), step such as "1 us" (engine), tolerance such as "0.02 um" (engine), duration such as "30 ms",
/// numeric_rate such as "20 kHz", picture_rate such as "1 kHz". Quantities are strings with units, or numbers in SI.
///
/// gradient: numeric fields of the scene, such as `["design.base", "contact.friction.mu_static"]`. The run is
/// differentiated with respect to them (analytic model); `gradient` of the result contains the derivatives.
///
/// Raises SceneError for an invalid scene or argument, and RunError if the run is not completed. The `result` of a
/// RunError contains the run up to its end. Other Python threads continue during the run; Ctrl-C interrupts it.
#[pyfunction]
#[pyo3(signature = (scene, model = "analytic", check = Some(false), *, preset = None, rtol = None, step = None, tolerance = None, duration = None, numeric_rate = None, picture_rate = None, log = None, gradient = None),
       text_signature = "(scene, model='analytic', check=False, *, preset=None, rtol=None, step=None, \
                         tolerance=None, duration=None, numeric_rate=None, picture_rate=None, log=None, gradient=None)")]
#[expect(clippy::too_many_arguments, reason = "the flags of the command")]
pub fn run(
    py: Python<'_>,
    scene: SceneLike,
    model: &str,
    check: Option<bool>,
    preset: Option<&str>,
    rtol: Option<&Bound<'_, PyAny>>,
    step: Option<&Bound<'_, PyAny>>,
    tolerance: Option<&Bound<'_, PyAny>>,
    duration: Option<&Bound<'_, PyAny>>,
    numeric_rate: Option<&Bound<'_, PyAny>>,
    picture_rate: Option<&Bound<'_, PyAny>>,
    log: Option<PathBuf>,
    gradient: Option<Vec<String>>,
) -> PyResult<Result> {
    let argument_error = |message: String| errors::argument(py, message);
    let model = self::model(py, model)?;
    let rtol = rtol.map(|value| -> PyResult<String> {
        if value.is_instance_of::<PyString>() { value.extract() } else { conversion::setting_text(value) }
    });
    let rtol = rtol.transpose()?.as_deref().map(overrides::rtol).transpose();
    let overrides = Overrides {
        preset: parse_preset(py, preset)?,
        rtol: rtol.map_err(|error| argument_error(format!("rtol: {error}")))?,
        step_s: parse_setting(py, "step", step, Dimension::Time, overrides::step)?,
        tolerance_m: parse_setting(py, "tolerance", tolerance, Dimension::Length, overrides::tolerance)?,
        duration_s: parse_setting(py, "duration", duration, Dimension::Time, overrides::duration)?,
        numeric_hz: parse_setting(py, "numeric_rate", numeric_rate, Dimension::Frequency, overrides::numeric_rate)?,
        picture_hz: parse_setting(py, "picture_rate", picture_rate, Dimension::Frequency, overrides::picture_rate)?,
    };
    let input = RunInput::new(py, scene.get(py)?, model, check, overrides)?;
    let gradient = match gradient {
        Some(_) if model == Model::Engine => {
            let message = "gradient: derivatives are computed in the analytic model; remove `model` or `gradient`";
            return Err(argument_error(message.to_string()));
        }
        Some(fields) => {
            let finish = |scene: &mut Scene| drop(input.overrides.apply(model, scene));
            let texts = (&input.loaded.layers[..], &input.loaded.settings[..]);
            let found = interruptible::run_on_caller(py, |keep_running| {
                let parameters = parameters(texts, &fields, &finish).map_err(Err)?;
                differentiate(&input.scene, &parameters, keep_running).map_err(|error| Ok(error.to_string()))
            })?;
            let found = found.map_err(|error| match error {
                Ok(run_error) => errors::run(py, format!("gradient: {run_error}"), None),
                Err(message) => errors::argument(py, format!("gradient: {message}")),
            })?;
            let by_field: BTreeMap<String, Gradient> = fields.into_iter().zip(found).collect();
            Some(serde_json::to_string(&by_field).map_err(|error| errors::argument(py, error))?)
        }
        None => None,
    };
    let schema = Schema::from_scene(&input.scene);
    let recording = Recording::new(&schema);
    let (run, recording) = interruptible::run_on_caller(py, |keep_running| {
        simulate(&input, log.as_deref(), input.check_policy(), recording, keep_running)
    })?
    .map_err(|error| errors::run(py, error, None))?;
    let stopped = run.stopped.clone();
    let duration = format::format_duration(input.scene.duration_s);
    let input = Arc::new(input);
    let source = Source::Run(Arc::clone(&input));
    let log = log.map(|path| path.display().to_string());
    let report = move || RunReport { log, ..report_of(input.model, &input.scene, &run) };
    let report = ResultReport::Run(Box::new(LazyLock::new(Box::new(report))));
    let result = Result::new(schema, recording, report, source, gradient);
    match stopped {
        None => Ok(result),
        Some((time_s, reason)) => {
            let end = format::format_duration(time_s);
            let message = format!("the simulation stopped at {end} of {duration}: {reason}");
            Err(errors::run(py, message, Some(Py::new(py, result)?.into_any())))
        }
    }
}

/// Reads a log of phalanx (MCAP) up to its end or to the first damage. `summary["losses"]` lists lost data;
/// `summary["missing"]` lists missing topics.
#[pyfunction]
pub fn read_log(py: Python<'_>, path: PathBuf) -> PyResult<Result> {
    let contents = interruptible::run_on_caller(py, |keep_running| {
        let head = log::read_head(&path)?;
        let scene = scene_in_log(&head).and_then(std::result::Result::ok);
        let scene = scene.filter(|scene| scene.finger_count() == head.finger_count());
        let (observer, _) = LogObserver::new(&head);
        let schema = Schema::default();
        let mut reader = Reader { recording: Recording::new(&schema), schema, observer, keep_running };
        let reading = log::read_file(&path, &mut reader)?;
        let Reader { schema, recording, mut observer, .. } = reader;
        // The page needs all data of the samples.
        let scene = scene.filter(|scene| reading.is_drawable() && schema.has_subjects_of(scene));
        Ok::<_, log::ReadError>((schema, recording, observer.report(path.display().to_string(), &reading), scene))
    })?;
    let (schema, recording, report, scene) = contents.map_err(|error| match &error {
        log::ReadError::NotFound { .. } | log::ReadError::NotAFile { .. } => errors::run(py, error, None),
        _ => errors::run(py, format!("{}: {error}", path.display()), None),
    })?;
    let source = Source::Log(path, scene.map(Box::new));
    Ok(Result::new(schema, recording, ResultReport::Log(Box::new(report)), source, None))
}

/// Repeats a run to obtain its report.
pub fn report(input: &RunInput) -> Option<RunReport> {
    let run = simulate(input, None, input.check_policy(), (), &|| true);
    run.ok().map(|(run, ())| report_of(input.model, &input.scene, &run))
}

/// Repeats a run to record its page.
pub fn playback(input: &RunInput) -> Option<PlaybackRecorder> {
    let run = simulate(input, None, CheckPolicy::Never, PlaybackRecorder::default(), &|| true);
    run.ok().map(|(_, recorder)| recorder)
}

/// Reads a log again, to record its page.
pub fn playback_of_log(path: &Path) -> Option<PlaybackRecorder> {
    struct LogPlayback(PlaybackRecorder);
    impl LogSink for LogPlayback {
        fn sample(&mut self, sample: &Sample) -> std::result::Result<(), SinkError> {
            self.0.sample(sample)
        }

        fn event(&mut self, event: &Event) -> std::result::Result<(), SinkError> {
            self.0.event(event)
        }
    }
    let mut playback = LogPlayback(PlaybackRecorder::default());
    log::read_file(path, &mut playback).ok().map(|_| playback.0)
}

/// Repeats a run to write its log.
pub fn save(py: Python<'_>, input: Arc<RunInput>, path: &Path) -> PyResult<()> {
    let outcome = interruptible::run_on_caller(py, |keep_running| {
        simulate(&input, Some(path), CheckPolicy::IfCheap, (), keep_running).map(drop)
    })?;
    outcome.map_err(|error| errors::run(py, error, None))
}

/// Simulates a run, and writes its log if a path is given.
fn simulate<S: Sink>(
    input: &RunInput,
    log_path: Option<&Path>,
    check_policy: CheckPolicy,
    mut sink: S,
    keep_running: KeepRunning<'_>,
) -> std::result::Result<(FinishedRun<LogFile>, S), String> {
    let scene = &input.scene;
    let info = RunInfo { scene, scene_file: &input.scene_file, model: input.model.name() };
    let log = log_path.map(|path| log::create(path, &info)).transpose().map_err(|error| error.to_string())?;
    let mut cancellable = Cancellable { sink: &mut sink, keep_running };
    let options = SimulationOptions { check_policy, keep_running, describe_reason: &ToString::to_string };
    let mut run = log::simulate(input.model, scene, log, &options, &mut cancellable);
    let log = std::mem::replace(&mut run.log, Ok(None));
    log.and_then(|log| log.map_or(Ok(()), LogFile::commit)).map_err(|error| error.to_string())?;
    Ok((run, sink))
}

/// Passes the contents of a log to a recording and to the observer that builds the report.
struct Reader<'a> {
    schema: Schema,
    recording: Recording,
    observer: LogObserver,
    keep_running: KeepRunning<'a>,
}

impl LogSink for Reader<'_> {
    fn schema(&mut self, schema: &Schema) -> std::result::Result<(), SinkError> {
        self.schema = schema.clone();
        self.recording = Recording::new(schema);
        self.observer.schema(schema)
    }

    fn sample(&mut self, sample: &Sample) -> std::result::Result<(), SinkError> {
        if !(self.keep_running)() {
            let source = std::io::Error::from(std::io::ErrorKind::Interrupted);
            return Err(SinkError { target: "the whole log".to_string(), source });
        }
        Sink::sample(&mut self.recording, sample)?;
        self.observer.sample(sample)
    }

    fn event(&mut self, event: &Event) -> std::result::Result<(), SinkError> {
        Sink::event(&mut self.recording, event)?;
        self.observer.event(event)
    }
}
