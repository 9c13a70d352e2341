//! Arguments of `phalanx replay`; reading a log for its summary, criteria, page, table and recording, with progress and
//! interruption.

use std::io;
use std::path::{Path, PathBuf};

use clap::Args;

use super::output::print_diagnostic;
use super::parsers::picture;
use super::progress::{Interrupt, Progress};
use super::simulate::SampleTable;
use super::{Failure, Status};
use crate::format::Report;
use crate::limits::MAX_COMPARED_VALUES;
use crate::log::{ChannelContent, LogSink, LogSummary, MissingData, ReadError, read_file, read_head};
use crate::page::{Playback, PlaybackRecorder};
use crate::report::replay::{LogObserver, ReplayReport, scene_in_log};
use crate::scene::Scene;
use crate::trace::{Event, Sample, Schema, Sink, SinkError};
use crate::validate::Recording;

/// Summarise the run in a log, verify it by simulating again, compare it with another log, or export its samples.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx replay run.mcap\n  phalanx replay run.mcap --verify\n  phalanx replay run.mcap --csv \
                  run.csv\n  phalanx replay analytic.mcap --against engine.mcap --plot both.html\n\nA truncated or damaged log is read \
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
    #[arg(long, value_name = "FILE.html", value_parser = picture(&["html"]), conflicts_with = "verify")]
    pub(super) plot: Option<PathBuf>,
}

/// Reads a log for its summary and criteria with a progress line until a signal arrives; on request also for a page, a
/// table, or a recording in memory.
pub(super) struct LogReader<'a> {
    pub path: &'a Path,
    /// Contents of the log: at first only its head; after reading, the whole log.
    pub summary: LogSummary,
    pub schema: Schema,
    pub recording: Option<Recording>,
    observer: LogObserver,
    /// Scene of the page, if one was requested.
    page_scene: Option<Scene>,
    /// Records the page in bounded memory; samples of long runs are decimated.
    page: Option<PlaybackRecorder>,
    pub table: Option<SampleTable>,
    value_count: usize,
    progress: Progress,
    duration_s: f64,
    interrupt: &'a Interrupt,
}

impl<'a> LogReader<'a> {
    /// Reads the head of the log, because the criteria need its scene before the first sample.
    pub(super) fn new(path: &'a Path, interrupt: &'a Interrupt) -> Result<Self, Failure> {
        let summary = read_head(path).map_err(|error| read_failure(path, &error))?;
        let duration_s = summary.metadata.get("duration_s").and_then(|text| text.parse().ok());
        let (observer, warning) = LogObserver::new(&summary);
        warning.iter().for_each(|warning| print_diagnostic(warning));
        Ok(LogReader {
            path,
            schema: Schema::default(),
            summary,
            recording: None,
            observer,
            page_scene: None,
            page: None,
            table: None,
            value_count: 0,
            progress: Progress::new(),
            duration_s: duration_s.unwrap_or(f64::INFINITY),
            interrupt,
        })
    }

    fn nothing_to_draw(&self, reason: impl std::fmt::Display) -> Failure {
        Failure::bad_input(format!("{}: there is nothing to draw: {reason}", self.path.display()))
    }

    /// Requests the data of a page.
    ///
    /// # Errors
    /// Returns an error if the log has no readable scene of its kind.
    pub(super) fn record_page(&mut self) -> Result<(), Failure> {
        let scene = match scene_in_log(&self.summary) {
            Some(Ok(scene)) if scene.finger_count() == self.summary.finger_count() => scene,
            Some(Ok(_)) => {
                let reason = "the kind of the scene in the log differs from the kind in its metadata";
                return Err(self.nothing_to_draw(reason));
            }
            Some(Err(error)) => {
                let reason = "the scene in the log cannot be read by this version of phalanx";
                return Err(self.nothing_to_draw(format!("{reason}:\n{error}")));
            }
            None => return Err(self.nothing_to_draw("the part of the log with its scene is lost")),
        };
        (self.page_scene, self.page) = (Some(scene), Some(PlaybackRecorder::default()));
        Ok(())
    }

    /// Reads the log.
    pub(super) fn read(&mut self) -> Result<(), Failure> {
        let path = self.path;
        let result = read_file(path, self);
        self.progress.clear();
        self.summary = match result {
            Err(_) if self.value_count > MAX_COMPARED_VALUES => {
                return Err(Failure::bad_input(format!(
                    "{} is too long to be compared: both logs are loaded into memory, with at most {MAX_COMPARED_VALUES} figures each \
                     (320,000 samples of a finger); log at a lower rate, or compare the tables that --csv writes",
                    path.display()
                )));
            }
            result => result.map_err(|error| read_failure(path, &error))?,
        };
        if let (Some(recording), Some(outcome)) = (&mut self.recording, self.observer.outcome()) {
            recording.outcome = outcome.clone();
        }
        Ok(())
    }

    /// Returns the report on the log, after it was read.
    pub(super) fn report(&mut self) -> ReplayReport {
        self.observer.report(self.path.display().to_string(), &self.summary)
    }

    /// Returns an error if a topic is missing, because a page needs all parts of a sample.
    pub(super) fn ensure_drawable(&self) -> Result<(), Failure> {
        let is_drawn = |missing: &&MissingData| missing.content != ChannelContent::Lines;
        let Some(missing) = self.summary.missing.iter().find(is_drawn) else { return Ok(()) };
        let (path, topic, defect) = (self.path.display(), &missing.topic, &missing.defect);
        let message = format!("error: {path}: no page can be written: missing data: {topic} {defect}");
        Err(Failure { message, status: Status::CheckFailed })
    }

    /// Returns the name and description of the scene of the page.
    pub(super) fn name_and_description(&self) -> (String, String) {
        self.page_scene.as_ref().map(|scene| (scene.name.clone(), scene.description.clone())).unwrap_or_default()
    }

    /// Returns the run for its page, which must have been requested.
    pub(super) fn into_playback(mut self, label: &str, summary: impl Into<Report>) -> Result<Playback, Failure> {
        match self.page.take().zip(self.page_scene.as_ref()) {
            Some((page, scene)) => Ok(page.into_playback(label, scene, summary)),
            None => Err(self.nothing_to_draw("the samples do not match the scene in the log")),
        }
    }

    /// Counts values that are stored in memory.
    fn count_values(&mut self, values: usize) -> Result<(), SinkError> {
        self.value_count += if self.recording.is_some() { values } else { 0 };
        match self.value_count > MAX_COMPARED_VALUES {
            true => Err(SinkError { target: "the log to memory".to_string(), source: io::ErrorKind::Other.into() }),
            false => Ok(()),
        }
    }
}

impl LogSink for LogReader<'_> {
    fn schema(&mut self, schema: &Schema) -> Result<(), SinkError> {
        self.schema = schema.clone();
        self.table.iter_mut().for_each(|table| table.set_schema(schema));
        if self.page_scene.as_ref().is_some_and(|scene| !schema.has_subjects_of(scene)) {
            self.page = None;
        }
        self.observer.schema(schema)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if let Some(signal) = self.interrupt.signal() {
            let source = io::Error::other(format!("interrupted by {signal}"));
            return Err(SinkError { target: "a summary of the whole log".to_string(), source });
        }
        self.progress.show_time(sample.time_s, self.duration_s);
        self.count_values(1 + sample.values().len())?;
        self.table.sample(sample)?;
        self.recording.sample(sample)?;
        self.observer.sample(sample)?;
        self.page.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.count_values(8)?;
        self.recording.event(event)?;
        self.observer.event(event)?;
        self.page.event(event)
    }
}

pub(super) fn read_failure(path: &Path, error: &ReadError) -> Failure {
    match error {
        ReadError::NotFound { .. } | ReadError::NotAFile { .. } => Failure::bad_input(error),
        ReadError::Sink(error) => Failure::incomplete(error),
        _ => Failure::bad_input(format!("{}: {error}", path.display())),
    }
}

/// Prints lost, missing and inconsistent parts of a log and returns the resulting exit status.
pub(super) fn print_defects(log: &Path, report: &ReplayReport) -> Status {
    let losses = report.reading.losses.iter();
    let losses = losses.map(|loss| format!("error: {}: {}", log.display(), loss.description));
    let messages: Vec<String> = losses.chain(report.error_messages()).collect();
    messages.iter().for_each(|message| print_diagnostic(message));
    if messages.is_empty() { Status::Done } else { Status::CheckFailed }
}
