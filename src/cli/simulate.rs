//! One simulation of `phalanx run`, `validate --out` or `replay --verify`, with a progress line and interruption by
//! signals; and the table of all samples that `--csv` of `run` and `replay` writes.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::Failure;
use super::output::{print_diagnostic, stdout, write_failure};
use super::progress::{Interrupt, Progress};
use crate::criteria::static_grasp;
use crate::files::NewFile;
use crate::integrator::Reason;
pub(super) use crate::log::CheckPolicy;
use crate::log::{self, FinishedRun, SimulationOptions, ThreadedWriter};
use crate::report::samples::{csv_head, csv_sample};
use crate::scene::Scene;
use crate::trace::{Channel, Event, Model, RequiredData, Sample, Schema, Sink, SinkError};

/// Conditions that end a run early, and whether to check it.
pub(super) struct RunLimits<'a> {
    pub interrupt: &'a Interrupt,
    /// Time after which the run may end, at the next sample, s.
    pub until_s: f64,
    pub check_policy: CheckPolicy,
}

/// Simulates a scene. `other_sink` receives the same data as the log.
pub(super) fn simulate<W: Write + Send + 'static>(
    model: Model,
    scene: &Scene,
    log: Option<ThreadedWriter<W>>,
    limits: &RunLimits<'_>,
    other_sink: &mut impl Sink,
) -> FinishedRun<W> {
    let object = scene.object().filter(|_| scene.finger_count() == 1);
    if let Some(Err(error)) = object.map(|object| static_grasp(scene, object)) {
        print_diagnostic(&format!("no dynamic criteria, because the finger cannot grasp this object: {error}"));
    }
    // The run may end before the duration of the scene.
    let duration_s = scene.duration_s.min(limits.until_s);
    let mut monitored_sink = MonitoredSink { last_s: 0.0, duration_s, progress: Progress::new(), limits, other_sink };
    let interrupt = limits.interrupt;
    let options = SimulationOptions {
        check_policy: limits.check_policy,
        keep_running: &|| interrupt.keep_running(),
        describe_reason: &|reason| match (reason, interrupt.signal()) {
            (Reason::Stopped, Some(signal)) => format!("interrupted by {signal}"),
            _ => reason.to_string(),
        },
    };
    let run = log::simulate(model, scene, log, &options, &mut monitored_sink);
    monitored_sink.progress.clear();
    run
}

/// Adds a progress line and interruption to the sinks of a run.
struct MonitoredSink<'a, A> {
    /// Time of the last sample.
    last_s: f64,
    duration_s: f64,
    progress: Progress,
    limits: &'a RunLimits<'a>,
    other_sink: &'a mut A,
}

impl<A: Sink> Sink for MonitoredSink<'_, A> {
    fn required_data(&self) -> RequiredData {
        self.other_sink.required_data()
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.last_s = sample.time_s;
        self.progress.show_time(sample.time_s, self.duration_s);
        self.other_sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.other_sink.event(event)
    }

    fn should_continue(&self) -> bool {
        self.last_s <= self.limits.until_s && self.limits.interrupt.keep_running()
    }
}

/// Name for standard output.
const STDOUT: &str = "-";

/// Returns the file of `--csv`, or `None` if the table replaces the summary on standard output.
///
/// # Errors
/// Returns an error if the table and `--json` would both go to standard output.
pub(super) fn csv_file(path: Option<&Path>, json: bool) -> Result<Option<&Path>, Failure> {
    match path == Some(Path::new(STDOUT)) {
        false => Ok(path),
        true if !json => Ok(None),
        true => Err(Failure::bad_input(
            "--csv - and --json would both write to standard output; give --csv the name of a file, or leave out --json",
        )),
    }
}

/// Table with a line for each sample, on standard output or in a file that is replaced at the end.
pub(super) struct SampleTable {
    path: PathBuf,
    out: TableOutput,
    channels: Vec<Channel>,
    has_header: bool,
    write_error: Option<io::ErrorKind>,
}

enum TableOutput {
    Stdout(BufWriter<io::StdoutLock<'static>>),
    File(NewFile),
}

impl SampleTable {
    pub(super) fn create(path: &Path) -> Result<Self, Failure> {
        let out = match path == Path::new(STDOUT) {
            true => stdout().map(|out| TableOutput::Stdout(BufWriter::new(out))),
            false => NewFile::create(path).map(TableOutput::File),
        };
        let out = out.map_err(|error| write_failure(path, error))?;
        let (channels, has_header, write_error) = (Vec::new(), false, None);
        Ok(SampleTable { path: path.to_path_buf(), out, channels, has_header, write_error })
    }

    /// Sets the columns; called before the first sample.
    pub(super) fn set_schema(&mut self, schema: &Schema) {
        self.channels = schema.channels();
    }

    /// Whether a line could not be written.
    pub(super) fn has_failed(&self) -> bool {
        self.write_error.is_some()
    }

    /// Completes the table; returns false if the reader of standard output closed the pipe (`| head`).
    pub(super) fn finish(self) -> Result<bool, Failure> {
        let is_stdout = matches!(self.out, TableOutput::Stdout(_));
        let written = match (self.write_error, self.out) {
            (Some(kind), _) => Err(kind.into()),
            (None, TableOutput::Stdout(mut out)) => out.flush(),
            (None, TableOutput::File(file)) => file.commit(),
        };
        match written {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe && is_stdout => Ok(false),
            written => written.map(|()| true).map_err(|error| write_failure(&self.path, error)),
        }
    }
}

impl Sink for SampleTable {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let out: &mut dyn Write = match &mut self.out {
            TableOutput::Stdout(out) => out,
            TableOutput::File(file) => &mut file.out,
        };
        let header = if self.has_header { Ok(()) } else { csv_head(out, &self.channels) };
        self.has_header = true;
        header.and_then(|()| csv_sample(out, &self.channels, sample)).map_err(|source| {
            self.write_error = Some(source.kind());
            SinkError { target: "the table of samples".to_string(), source }
        })
    }
}
