//! Reading a log with everything that listens to it: the summary of either kind, the criteria, the table of samples.

use std::cell::RefCell;
use std::io;
use std::path::Path;

use super::Failure;
use super::interrupt::Interrupt;
use super::output::complain;
use super::progress::Progress;
use crate::log::{self, LogSink, ReadError, Reading};
pub(super) use crate::report::replay::attached;
use crate::report::replay::{Heard, ReplayReport, Summary};
use crate::trace::{Event, Layout, Sample, Sink, SinkError};

/// Everything that listens to a log.
pub(super) struct Listeners<'a> {
    heard: Heard,
    progress: Progress,
    interrupt: &'a Interrupt,
}

impl<'a> Listeners<'a> {
    /// Looks at the head of the log: the criteria need its scene before the first sample.
    pub fn new(path: &Path, interrupt: &'a Interrupt) -> Result<Self, Failure> {
        let head = head(path)?;
        let duration_s = head.metadata.get("duration_s").and_then(|text| text.parse().ok());
        let (heard, said) = Heard::new(&head);
        said.iter().for_each(|said| complain(said));
        Ok(Listeners { heard, progress: Progress::new(duration_s.unwrap_or(f64::INFINITY)), interrupt })
    }

    /// What is known of the run, and what its samples consist of.
    pub fn summary(&self) -> &Summary {
        self.heard.summary()
    }

    /// Wipes the line that says how far it has come.
    pub fn done(&mut self) {
        self.progress.clear();
    }

    /// The summary of what was read.
    pub fn report(&self, name: String, reading: &Reading) -> ReplayReport {
        self.heard.report(name, reading)
    }

    fn check(&self) -> Result<(), SinkError> {
        go_on(self.interrupt, "a summary of the whole log")
    }
}

impl LogSink for Listeners<'_> {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.heard.layout(layout)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.check()?;
        Sink::sample(&mut self.progress, sample)?;
        self.heard.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.heard.event(event)
    }
}

/// Reads a log.
pub(super) fn read(path: &Path, listeners: &mut Listeners<'_>) -> Result<Reading, Failure> {
    let reading = log::read_any_file(path, listeners).map_err(|error| bad_log(path, &error));
    listeners.progress.clear();
    reading
}

/// Watches a log being gone through message by message: shows how far that has come, and ends it at a signal.
pub(super) struct Watch<'a> {
    progress: RefCell<Progress>,
    interrupt: &'a Interrupt,
    /// What errors say is not done.
    what: &'a str,
}

impl<'a> Watch<'a> {
    pub fn new(duration_s: Option<f64>, interrupt: &'a Interrupt, what: &'a str) -> Self {
        Watch { progress: RefCell::new(Progress::new(duration_s.unwrap_or(f64::INFINITY))), interrupt, what }
    }

    pub fn reached(&self, log_time_ns: u64) -> Result<(), SinkError> {
        self.progress.borrow_mut().reached(log_time_ns as f64 * 1e-9);
        go_on(self.interrupt, self.what)
    }

    /// Wipes the line.
    pub fn done(&self) {
        self.progress.borrow_mut().clear();
    }
}

/// An error that ends the reading of a log, once a signal has come.
fn go_on(interrupt: &Interrupt, what: &str) -> Result<(), SinkError> {
    match interrupt.signal() {
        None => Ok(()),
        Some(signal) => {
            Err(SinkError { what: what.to_string(), source: io::Error::other(format!("interrupted by {signal}")) })
        }
    }
}

pub(super) fn bad_log(path: &Path, error: &ReadError) -> Failure {
    match error {
        ReadError::Missing { .. } | ReadError::NotAFile { .. } => Failure::bad_input(error),
        ReadError::Sink(error) => Failure::incomplete(error),
        _ => Failure::bad_input(format!("{}: {error}", path.display())),
    }
}

/// The head of a log: its metadata and its scene.
pub(super) fn head(log: &Path) -> Result<Reading, Failure> {
    crate::log::read_head(log).map_err(|error| bad_log(log, &error))
}
