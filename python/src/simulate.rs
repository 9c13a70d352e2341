//! Runs, and logs that are read back.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use phalanx::log::{self, LogFile, LogSink, RunInfo};
use phalanx::page::Reel;
use phalanx::report::document::RunReport;
use phalanx::report::replay::{Heard, attached};
use phalanx::report::simulated::{Checking, Making, simulated};
use phalanx::scene::{Construction, Preset, Scene};
use phalanx::trace::overrides::{self, Overrides};
use phalanx::trace::{Event, Layout, Model, Recording, Sample, Sink, SinkError};
use phalanx::wording::{self, Reported};
use pyo3::prelude::*;
use pyo3::types::PyString;

use super::result::{Film, Result, Source, model};
use super::scene::SceneLike;
use super::{errors, watch, words};

/// What a run was made of.
#[derive(Clone)]
pub struct Made {
    pub scene: Scene,
    pub model: Model,
    /// What its log calls the scene.
    pub scene_file: String,
}

/// Simulates a scene.
///
/// model: "analytic" or "engine". check: True estimates the error by a second, independent resolution and says whether the outcome
/// is chaotic, None does so where it is cheap (as `phalanx run`), False never. log: also write a log there (MCAP).
/// The others are the flags of `phalanx run`: preset "engineering" or "reference" (analytic), rtol (analytic), construction
/// "maximal" or "reduced" (engine), step such as "1 us" (engine), tolerance such as "0.02 um" (engine), duration such as "30 ms",
/// numeric_rate such as "20 kHz", picture_rate such as "1 kHz".
///
/// Raises SceneError for what is wrong with the scene or an argument, RunError if the run does not get to its end; the error's
/// `result` has the run up to there. Other threads go on meanwhile, and Ctrl-C ends the run.
#[pyfunction]
#[pyo3(signature = (scene, model = "analytic", check = Some(false), *, preset = None, rtol = None, construction = None,
                    step = None, tolerance = None, duration = None, numeric_rate = None, picture_rate = None, log = None),
       text_signature = "(scene, model='analytic', check=False, *, preset=None, rtol=None, construction=None, step=None, \
                         tolerance=None, duration=None, numeric_rate=None, picture_rate=None, log=None)")]
#[expect(clippy::too_many_arguments, reason = "the flags of the command")]
pub fn run(
    py: Python<'_>,
    scene: SceneLike,
    model: &str,
    check: Option<bool>,
    preset: Option<&str>,
    rtol: Option<&Bound<'_, PyAny>>,
    construction: Option<&str>,
    step: Option<&str>,
    tolerance: Option<&str>,
    duration: Option<&str>,
    numeric_rate: Option<&str>,
    picture_rate: Option<&str>,
    log: Option<PathBuf>,
) -> PyResult<Result> {
    let wrong = |error: String| errors::argument(py, error);
    let model = self::model(py, model)?;
    let read = |name: &str, text: Option<&str>, by: fn(&str) -> std::result::Result<String, String>| {
        text.map(by).transpose().map_err(|error| errors::argument(py, format!("{name}: {error}")))
    };
    let rtol = rtol.map(|value| -> PyResult<String> {
        if value.is_instance_of::<PyString>() { value.extract() } else { words::toml(value) }
    });
    let overrides = Overrides {
        preset: preset.map(|word| words::word::<Preset>("preset", word)).transpose().map_err(wrong)?,
        rtol: read("rtol", rtol.transpose()?.as_deref(), overrides::rtol)?,
        construction: construction
            .map(|word| words::word::<Construction>("construction", word))
            .transpose()
            .map_err(wrong)?,
        step: read("step", step, overrides::step)?,
        tolerance: read("tolerance", tolerance, overrides::tolerance)?,
        duration_s: duration.map(overrides::duration).transpose().map_err(wrong)?,
        numeric_rate: read("numeric_rate", numeric_rate, overrides::numeric_rate)?,
        picture_rate: read("picture_rate", picture_rate, overrides::picture_rate)?,
    };
    let own = scene.get(py)?;
    let path = Path::new(own.file()).file_name().map(|name| name.to_string_lossy().into_owned());
    let mut scene = own.scene;
    overrides.apply(model, &mut scene).map_err(wrong)?;
    let checking = match check {
        Some(true) => Checking::Always,
        Some(false) => Checking::Never,
        None => Checking::Cheap,
    };
    let made = Made { scene, model, scene_file: path.unwrap_or_else(|| "scene.toml".to_string()) };
    let layout = Layout::of(&made.scene.system);
    let kept = Kept { recording: Recording::new(&layout), reel: Reel::default() };
    let (report, kept) = watch::free(py, |go_on| make(&made, log.as_deref(), checking, kept, go_on))?
        .map_err(|error| errors::run(py, error, None))?;
    let film =
        Film { scene: made.scene.clone(), label: model.name().to_string(), reel: kept.reel, summary: report.report() };
    let document = report.json();
    let result = Result::new(layout, kept.recording, document, Some(film), Source::Run(Arc::new(made)))?;
    match report.error {
        None => Ok(result),
        Some(failure) => {
            let (at, of) = (wording::duration(failure.time_s), wording::duration(report.duration_s));
            let message = format!("the simulation stopped at {at} of {of}: {}", failure.reason);
            Err(errors::run(py, message, Some(Py::new(py, result)?.into_any())))
        }
    }
}

/// Reads a log of phalanx (MCAP), as far as it goes: `summary["losses"]` says what is lost, `summary["missing"]` which topics are missing.
#[pyfunction]
pub fn read_log(py: Python<'_>, path: PathBuf) -> PyResult<Result> {
    let read = watch::free(py, |go_on| {
        let head = log::read_head(&path)?;
        let scene = attached(&head).and_then(std::result::Result::ok);
        let scene = scene.filter(|scene| scene.kind() == head.kind());
        let (heard, _) = Heard::new(&head);
        let layout = Layout::of_kind(head.kind());
        let kept = Kept { recording: Recording::new(&layout), reel: Reel::default() };
        let mut reader = Reader { layout, kept, heard, go_on };
        let reading = log::read_any_file(&path, &mut reader)?;
        let Reader { layout, kept, heard, .. } = reader;
        // A page shows every part of a sample.
        let drawable = reading.missing.iter().all(|missing| missing.concerns == log::Concerns::Run);
        let scene = scene.filter(|_| drawable);
        Ok::<_, log::ReadError>((layout, kept, heard.report(path.display().to_string(), &reading), scene))
    })?;
    let (layout, kept, report, scene) = read.map_err(|error| match &error {
        log::ReadError::Missing { .. } | log::ReadError::NotAFile { .. } => errors::run(py, error, None),
        _ => errors::run(py, format!("{}: {error}", path.display()), None),
    })?;
    let film = scene.filter(|scene| Layout::of(&scene.system) == layout).map(|scene| Film {
        scene,
        label: report.model.clone().unwrap_or_else(|| "run".to_string()),
        reel: kept.reel,
        summary: report.report(),
    });
    Result::new(layout, kept.recording, report.json(), film, Source::Log(path))
}

/// Makes a run again for its log.
pub fn save(py: Python<'_>, made: Arc<Made>, path: &Path) -> PyResult<()> {
    let written = watch::free(py, |go_on| make(&made, Some(path), Checking::Cheap, (), go_on).map(drop))?;
    written.map_err(|error| errors::run(py, error, None))
}

/// Makes a run, and its log if there is to be one.
fn make<S: Sink>(
    made: &Made,
    to: Option<&Path>,
    checking: Checking,
    sink: S,
    go_on: &(dyn Fn() -> bool + Sync),
) -> std::result::Result<(RunReport, S), String> {
    let scene = &made.scene;
    let info = RunInfo { scene, scene_file: &made.scene_file, model: made.model.name() };
    let log = to.map(|path| log::create(path, &info)).transpose().map_err(|error| error.to_string())?;
    let mut sink = Watched { sink, go_on };
    let making = Making { checking, go_on: &|| go_on(), reason: &ToString::to_string };
    let run = simulated(made.model, scene, log, &making, &mut sink);
    let mut report = run.report(made.model, scene);
    report.log = to.map(|path| path.display().to_string());
    run.log.and_then(|log| log.map_or(Ok(()), LogFile::keep)).map_err(|error| error.to_string())?;
    Ok((report, sink.sink))
}

/// Everything that is kept of a run: its columns, and what a page shows.
struct Kept {
    recording: Recording,
    reel: Reel,
}

impl Sink for Kept {
    fn sample(&mut self, sample: &Sample) -> std::result::Result<(), SinkError> {
        Sink::sample(&mut self.recording, sample)?;
        self.reel.sample(sample)
    }

    fn event(&mut self, event: &Event) -> std::result::Result<(), SinkError> {
        Sink::event(&mut self.recording, event)?;
        self.reel.event(event)
    }
}

/// A sink whose run goes on as long as it may.
struct Watched<'a, S> {
    sink: S,
    go_on: &'a (dyn Fn() -> bool + Sync),
}

impl<S: Sink> Sink for Watched<'_, S> {
    fn sample(&mut self, sample: &Sample) -> std::result::Result<(), SinkError> {
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> std::result::Result<(), SinkError> {
        self.sink.event(event)
    }

    fn proceed(&self) -> bool {
        (self.go_on)()
    }
}

/// Everything that listens to a log.
struct Reader<'a> {
    layout: Layout,
    kept: Kept,
    heard: Heard,
    go_on: &'a (dyn Fn() -> bool + Sync),
}

impl LogSink for Reader<'_> {
    fn layout(&mut self, layout: &Layout) -> std::result::Result<(), SinkError> {
        self.layout = layout.clone();
        self.kept.recording = Recording::new(layout);
        self.heard.layout(layout)
    }

    fn sample(&mut self, sample: &Sample) -> std::result::Result<(), SinkError> {
        if !(self.go_on)() {
            let source = std::io::Error::from(std::io::ErrorKind::Interrupted);
            return Err(SinkError { what: "the whole log".to_string(), source });
        }
        self.kept.sample(sample)?;
        self.heard.sample(sample)
    }

    fn event(&mut self, event: &Event) -> std::result::Result<(), SinkError> {
        self.kept.event(event)?;
        self.heard.event(event)
    }
}
