//! Reading a log for its summary and criteria, with progress and interruption.

use std::cell::RefCell;
use std::io;
use std::path::Path;

use super::Failure;
use super::interrupt::Interrupt;
use super::output::print_diagnostic;
use super::progress::Progress;
use crate::log::{self, LogSink, LogSummary, ReadError};
pub(super) use crate::report::replay::scene_in_log;
use crate::report::replay::{LogObserver, ReplayReport, Summary};
use crate::trace::{Event, Layout, Sample, Sink, SinkError};

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
    pub fn clear_progress(&mut self) {
        self.progress.clear();
    }

    /// Returns the report on the log.
    pub fn report(&self, name: String, summary: &LogSummary) -> ReplayReport {
        self.observer.report(name, summary)
    }

    fn check_interrupt(&self) -> Result<(), SinkError> {
        check_interrupt(self.interrupt, "a summary of the whole log")
    }
}

impl LogSink for SummarySink<'_> {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.observer.layout(layout)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.check_interrupt()?;
        Sink::sample(&mut self.progress, sample)?;
        self.observer.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.observer.event(event)
    }
}

/// Reads a log into a summary.
pub(super) fn read_log(path: &Path, sink: &mut SummarySink<'_>) -> Result<LogSummary, Failure> {
    let summary = log::read_any_file(path, sink).map_err(|error| read_failure(path, &error));
    sink.progress.clear();
    summary
}

/// Shows the progress of reading a log message by message and stops at a signal.
pub(super) struct ReadMonitor<'a> {
    progress: RefCell<Progress>,
    interrupt: &'a Interrupt,
    /// Output that an interrupt leaves unwritten, for error messages.
    target: &'a str,
}

impl<'a> ReadMonitor<'a> {
    pub fn new(duration_s: Option<f64>, interrupt: &'a Interrupt, target: &'a str) -> Self {
        ReadMonitor { progress: RefCell::new(Progress::new(duration_s.unwrap_or(f64::INFINITY))), interrupt, target }
    }

    pub fn update(&self, log_time_ns: u64) -> Result<(), SinkError> {
        self.progress.borrow_mut().update(log_time_ns as f64 * 1e-9);
        check_interrupt(self.interrupt, self.target)
    }

    /// Clears the progress line.
    pub fn clear_progress(&self) {
        self.progress.borrow_mut().clear();
    }
}

/// Returns an error once a signal has arrived; the error stops the reading of a log.
fn check_interrupt(interrupt: &Interrupt, target: &str) -> Result<(), SinkError> {
    match interrupt.signal() {
        None => Ok(()),
        Some(signal) => {
            Err(SinkError { target: target.to_string(), source: io::Error::other(format!("interrupted by {signal}")) })
        }
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
