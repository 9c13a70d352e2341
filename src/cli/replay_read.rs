//! Arguments of `phalanx replay`; reading a log for its summary, criteria and page, with progress and interruption.

use std::io;
use std::path::{Path, PathBuf};

use clap::Args;

use super::interrupt::Interrupt;
use super::output::print_diagnostic;
use super::progress::Progress;
use super::{Failure, Status};
use crate::format::Report;
use crate::log::{ChannelContent, LogSink, LogSummary, MissingData, ReadError};
use crate::page::{Playback, PlaybackRecorder};
pub(super) use crate::report::replay::scene_in_log;
use crate::report::replay::{LogObserver, ReplayReport, Summary};
use crate::scene::Scene;
use crate::trace::{Event, Sample, Schema, Sink, SinkError};

/// Summarise the run in a log, verify it by simulating again, compare it with another log, or export its samples.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx replay run.mcap\n  phalanx replay run.mcap --verify\n  phalanx replay run.mcap --csv \
                  run.csv\n  phalanx replay analytic.mcap --against engine.mcap --html both.html\n\nA truncated or damaged log is read \
                  up to the damage (mcap recover extracts what follows). The order of messages in the file does not matter. Exit \
                  status: 0 the log is complete (with --verify: and identical to the new run); 1 data are lost, a topic is missing, \
                  or the runs differ; 2 bad input; 3 interrupted, or a file could not be written."
)]
pub(crate) struct ReplayArgs {
    /// Log of a run (MCAP), or the partial log of a killed run
    #[arg(value_name = "LOG.mcap")]
    pub(super) log: PathBuf,

    /// Print one JSON document with SI units in its keys instead of the summary
    #[arg(long)]
    pub(super) json: bool,

    /// Simulate the scene again with all settings in the log and compare all samples and events bit for bit
    #[arg(long, group = "mode")]
    pub(super) verify: bool,

    /// Compare with another log of the same kind of scene: results of both with their differences, and the differences
    /// of the trajectories over the common time
    #[arg(long, value_name = "OTHER.mcap", group = "mode")]
    pub(super) against: Option<PathBuf>,

    /// With --against: write the report and plots to this directory, which is created if needed
    #[arg(long, value_name = "DIR", requires = "against")]
    pub(super) out: Option<PathBuf>,

    /// Write all samples as comma-separated values to this file, one line per sample, with SI units in the column
    /// names; - writes to standard output
    #[arg(long, value_name = "FILE", conflicts_with = "mode")]
    pub(super) csv: Option<PathBuf>,

    /// Write a page for any browser, also offline: an animation, plots and events; with --against both logs are
    /// overlaid. If the run has too many samples for a page, some are omitted and the page states this
    #[arg(long, value_name = "FILE.html", conflicts_with = "verify")]
    pub(super) html: Option<PathBuf>,
}

/// A log sink that collects the summary of a run, shows progress and stops at a signal.
pub(super) struct SummarySink<'a> {
    observer: LogObserver,
    progress: Progress,
    interrupt: &'a Interrupt,
}

impl<'a> SummarySink<'a> {
    /// Reads the head of the log, because the criteria need its scene before the first sample.
    pub fn new(path: &Path, interrupt: &'a Interrupt) -> Result<Self, Failure> {
        let head = read_head(path)?;
        let duration_s = head.metadata.get("duration_s").and_then(|text| text.parse().ok());
        let (observer, warning) = LogObserver::new(&head);
        warning.iter().for_each(|warning| print_diagnostic(warning));
        Ok(SummarySink { observer, progress: Progress::new(duration_s.unwrap_or(f64::INFINITY)), interrupt })
    }

    /// Returns the summary of the run, including the layout of its samples.
    pub fn summary(&self) -> &Summary {
        self.observer.summary()
    }

    /// Clears the progress line.
    pub(crate) fn clear_progress(&mut self) {
        self.progress.clear();
    }

    /// Returns the report on the log.
    pub fn report(&mut self, path: &Path, summary: &LogSummary) -> ReplayReport {
        self.observer.report(path.display().to_string(), summary)
    }
}

impl LogSink for SummarySink<'_> {
    fn schema(&mut self, schema: &Schema) -> Result<(), SinkError> {
        self.observer.schema(schema)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if let Some(signal) = self.interrupt.signal() {
            let source = io::Error::other(format!("interrupted by {signal}"));
            return Err(SinkError { target: "a summary of the whole log".to_string(), source });
        }
        self.progress.update(sample.time_s);
        self.observer.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.observer.event(event)
    }
}

pub(super) fn read_failure(path: &Path, error: &ReadError) -> Failure {
    match error {
        ReadError::NotFound { .. } | ReadError::NotAFile { .. } => Failure::bad_input(error),
        ReadError::Sink(error) => Failure::incomplete(error),
        _ => Failure::bad_input(format!("{}: {error}", path.display())),
    }
}

/// Reads the head of a log: its metadata and its scene.
pub(super) fn read_head(log: &Path) -> Result<LogSummary, Failure> {
    crate::log::read_head(log).map_err(|error| read_failure(log, &error))
}

/// Records a log for a page in bounded memory; samples of long runs are decimated.
pub(super) struct LogPlaybackRecorder {
    scene: Scene,
    recorder: Box<PlaybackRecorder>,
    /// Whether the layout of the samples matches the scene.
    matches_scene: bool,
}

/// Returns an error if a topic is missing, because a page needs all parts of a sample.
pub(super) fn ensure_drawable(path: &Path, summary: &LogSummary) -> Result<(), Failure> {
    let is_drawn = |missing: &&MissingData| missing.content != ChannelContent::Lines;
    let Some(missing) = summary.missing.iter().find(is_drawn) else { return Ok(()) };
    let (topic, defect) = (&missing.topic, &missing.defect);
    let message = format!("error: {}: no page can be written: missing data: {topic} {defect}", path.display());
    Err(Failure { message, status: Status::CheckFailed })
}

impl LogPlaybackRecorder {
    /// Creates a recorder for the scene in the head of a log.
    ///
    /// # Errors
    /// Returns an error if the log has no readable scene of its kind.
    pub fn new(path: &Path, head: &LogSummary) -> Result<Self, Failure> {
        let bad_input =
            |reason: String| Failure::bad_input(format!("{}: there is nothing to draw: {reason}", path.display()));
        match scene_in_log(head) {
            Some(Ok(scene)) if scene.kind() == head.kind() => {
                Ok(LogPlaybackRecorder { scene, recorder: Box::default(), matches_scene: true })
            }
            Some(Ok(_)) => {
                Err(bad_input("the kind of the scene in the log differs from the kind in its metadata".to_string()))
            }
            Some(Err(error)) => {
                Err(bad_input(format!("the scene in the log cannot be read by this version of phalanx:\n{error}")))
            }
            None => Err(bad_input("the part of the log with its scene is lost".to_string())),
        }
    }

    /// Returns the name and description of the scene.
    pub(crate) fn name_and_description(&self) -> (String, String) {
        (self.scene.name.clone(), self.scene.description.clone())
    }

    pub fn into_playback(self, path: &Path, label: &str, summary: impl Into<Report>) -> Result<Playback, Failure> {
        match self.matches_scene {
            true => Ok(self.recorder.into_playback(label, &self.scene, summary)),
            false => Err(Failure::bad_input(format!(
                "{}: there is nothing to draw: the samples do not match the scene in the log",
                path.display()
            ))),
        }
    }
}

impl LogSink for LogPlaybackRecorder {
    fn schema(&mut self, schema: &Schema) -> Result<(), SinkError> {
        self.matches_scene = Schema::from_system(&self.scene.system) == *schema;
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if self.matches_scene { self.recorder.sample(sample) } else { Ok(()) }
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        if self.matches_scene { self.recorder.event(event) } else { Ok(()) }
    }
}

/// Passes a log to two sinks.
pub(super) struct Tee<'a, A, B>(pub &'a mut A, pub &'a mut B);

impl<A: LogSink, B: LogSink> LogSink for Tee<'_, A, B> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.sample(sample)?;
        self.1.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.0.event(event)?;
        self.1.event(event)
    }

    fn schema(&mut self, schema: &Schema) -> Result<(), SinkError> {
        self.0.schema(schema)?;
        self.1.schema(schema)
    }
}

/// Prints lost, missing and inconsistent parts of a log and returns the resulting exit status.
pub(super) fn print_defects(log: &Path, report: &ReplayReport) -> Status {
    let losses = report.reading.losses.iter();
    let mut messages: Vec<String> =
        losses.map(|loss| format!("error: {}: {}", log.display(), loss.description)).collect();
    messages.extend(report.error_messages());
    messages.iter().for_each(|message| print_diagnostic(message));
    if messages.is_empty() { Status::Done } else { Status::CheckFailed }
}
