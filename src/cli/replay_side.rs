//! A log that is held whole, to be set beside another.

use std::io;
use std::path::Path;

use super::Failure;
use super::interrupt::Interrupt;
use super::replay_page::Tee;
use super::replay_read::{Listeners, bad_log, head};
use crate::limits::MOST_COMPARED_FIGURES;
use crate::log::{self, LogSink, Reading};
use crate::trace::{Event, Layout, Sample, Sink, SinkError};
use crate::validate::Recording;

/// A log that is held whole.
pub(super) struct Side<'a> {
    pub listeners: Listeners<'a>,
    pub reading: Reading,
    pub recording: Recording,
    pub layout: Layout,
    figures: usize,
    too_long: bool,
}

impl<'a> Side<'a> {
    /// Reads a log; `film` gets all of it too.
    pub fn read(path: &Path, interrupt: &'a Interrupt, film: &mut impl LogSink) -> Result<Self, Failure> {
        let mut side = Side {
            listeners: Listeners::new(path, interrupt)?,
            reading: Reading::default(),
            recording: Recording::default(),
            layout: Layout::of_kind(head(path)?.kind()),
            figures: 0,
            too_long: false,
        };
        let reading = log::read_any_file(path, &mut Tee(&mut side, film));
        side.listeners.done();
        side.reading = match reading {
            Err(_) if side.too_long => {
                return Err(Failure::bad_input(format!(
                    "{} is too long to be compared: both logs are held in memory, {MOST_COMPARED_FIGURES} figures of each (476,000 \
                     samples of a finger); log at a lower rate, or compare the tables that --csv writes",
                    path.display()
                )));
            }
            reading => reading.map_err(|error| bad_log(path, &error))?,
        };
        if let Some(outcome) = side.listeners.summary().outcome() {
            side.recording.outcome = outcome.clone();
        }
        Ok(side)
    }

    fn hold(&mut self, figures: usize) -> Result<(), SinkError> {
        self.figures += figures;
        self.too_long = self.figures > MOST_COMPARED_FIGURES;
        match self.too_long {
            true => Err(SinkError { what: "so long a log to memory".to_string(), source: io::ErrorKind::Other.into() }),
            false => Ok(()),
        }
    }
}

impl LogSink for Side<'_> {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.layout = layout.clone();
        self.listeners.layout(layout)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let Sample { fingers, bodies, contacts, .. } = sample;
        self.hold(8 + 10 * fingers.len() + 6 * bodies.len() + 10 * contacts.len())?;
        self.recording.sample(sample)?;
        self.listeners.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.hold(8)?;
        self.recording.event(event)?;
        self.listeners.event(event)
    }
}
