//! A log that is loaded completely, for comparison with another one.

use std::io;
use std::path::Path;

use super::Failure;
use super::interrupt::Interrupt;
use super::replay_page::Tee;
use super::replay_read::{SummarySink, read_failure, read_head};
use crate::limits::MAX_COMPARED_VALUES;
use crate::log::{self, LogSink, LogSummary};
use crate::trace::{Event, Layout, Sample, Sink, SinkError};
use crate::validate::Recording;

/// A log that is loaded completely into memory.
pub(super) struct LoadedLog<'a> {
    pub sink: SummarySink<'a>,
    pub summary: LogSummary,
    pub recording: Recording,
    pub layout: Layout,
    value_count: usize,
    exceeds_limit: bool,
}

impl<'a> LoadedLog<'a> {
    /// Reads a log and also passes it to `recorder`.
    pub fn read(path: &Path, interrupt: &'a Interrupt, recorder: &mut impl LogSink) -> Result<Self, Failure> {
        let mut loaded = LoadedLog {
            sink: SummarySink::new(path, interrupt)?,
            summary: LogSummary::default(),
            recording: Recording::default(),
            layout: Layout::from_kind(read_head(path)?.kind()),
            value_count: 0,
            exceeds_limit: false,
        };
        let summary = log::read_any_file(path, &mut Tee(&mut loaded, recorder));
        loaded.sink.clear_progress();
        loaded.summary = match summary {
            Err(_) if loaded.exceeds_limit => {
                return Err(Failure::bad_input(format!(
                    "{} is too long to be compared: both logs are loaded into memory, with at most {MAX_COMPARED_VALUES} figures each \
                     (476,000 samples of a finger); log at a lower rate, or compare the tables that --csv writes",
                    path.display()
                )));
            }
            summary => summary.map_err(|error| read_failure(path, &error))?,
        };
        if let Some(outcome) = loaded.sink.summary().outcome() {
            loaded.recording.outcome = outcome.clone();
        }
        Ok(loaded)
    }

    fn count_values(&mut self, values: usize) -> Result<(), SinkError> {
        self.value_count += values;
        self.exceeds_limit = self.value_count > MAX_COMPARED_VALUES;
        match self.exceeds_limit {
            true => Err(SinkError { target: "the log to memory".to_string(), source: io::ErrorKind::Other.into() }),
            false => Ok(()),
        }
    }
}

impl LogSink for LoadedLog<'_> {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.layout = layout.clone();
        self.sink.layout(layout)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let Sample { fingers, bodies, contacts, .. } = sample;
        self.count_values(8 + 10 * fingers.len() + 6 * bodies.len() + 10 * contacts.len())?;
        self.recording.sample(sample)?;
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.count_values(8)?;
        self.recording.event(event)?;
        self.sink.event(event)
    }
}
