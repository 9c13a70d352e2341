//! The log writer: a sink that turns samples and events into MCAP messages as they come.

use std::collections::BTreeMap;
use std::io::{self, Write};

use foxglove::messages::Log;
use mcap::McapError;

use super::channels::Channels;
use super::core::{ChannelId, Core, Feed, Severity};
use super::metadata::RunInfo;
use phalanx_core::trace::{Event, Sample, Sink, SinkError};

/// Writes one run to an MCAP file, streaming: what it keeps in memory is one chunk, and some 400 bytes of index for every
/// chunk written. Nothing is ever sought in `W`, so a pipe will do.
///
/// What it writes of a run is what it is given: how the run ended, too, has to be said, by [`Writer::note`] as source `run`, or the
/// log is that of a run that was killed. [`run_to`](super::run_to) does all of it.
///
/// Dropping a writer finishes the log too, but swallows errors; [`Writer::finish`] reports them.
pub struct Writer<W: Write> {
    core: Core<W>,
    channels: Channels,
    events: ChannelId,
    /// What errors call this log.
    name: String,
}

impl<W: Write> Writer<W> {
    /// Starts a log: header, metadata, scene text and channels. `name` is what errors call it.
    pub fn new(out: W, name: &str, run: &RunInfo<'_>) -> Result<Self, SinkError> {
        Writer::with_feed(out, name, run, None)
    }

    /// The same, with every message handed to a feed as well.
    pub fn with_feed(out: W, name: &str, run: &RunInfo<'_>, feed: Option<Box<dyn Feed>>) -> Result<Self, SinkError> {
        let start = || {
            let mut core = Core::start(out, run, feed)?;
            let channels = Channels::register(&mut core, run.scene)?;
            let events = core.channel::<Log>("/events")?;
            Ok((core, channels, events))
        };
        start()
            .map(|(core, channels, events)| Writer { core, channels, events, name: name.to_string() })
            .map_err(|error| sink_error(name, error))
    }

    /// Writes a line to `/events`, for instance how the run ended; `source` is what it is about.
    pub fn note(&mut self, time_s: f64, severity: Severity, source: &str, text: &str) -> Result<(), SinkError> {
        let written = self.core.line(self.events, time_s, severity, source, text);
        self.named(written)
    }

    /// Writes a metadata record: what is known of the run as a whole.
    pub fn record(&mut self, name: &str, entries: BTreeMap<String, String>) -> Result<(), SinkError> {
        let written = self.core.record(name, entries);
        self.named(written)
    }

    /// Finishes the log (last chunk, index, footer), flushes it, and hands back what it was written to.
    pub fn finish(self) -> Result<W, SinkError> {
        let Writer { core, name, .. } = self;
        core.finish().map_err(|error| sink_error(&name, error))
    }

    /// An error under the name of this log.
    fn named<T>(&self, result: Result<T, McapError>) -> Result<T, SinkError> {
        result.map_err(|error| sink_error(&self.name, error))
    }
}

impl<W: Write> Sink for Writer<W> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let written = self.channels.sample(&mut self.core, sample).and_then(|()| self.core.close_full_chunk());
        self.named(written)
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let written = self.channels.event(&mut self.core, self.events, event);
        let written = written.and_then(|()| self.core.close_full_chunk());
        self.named(written)
    }
}

pub(super) fn sink_error(name: &str, error: McapError) -> SinkError {
    SinkError {
        what: name.to_string(),
        source: match error {
            McapError::Io(error) => error,
            other => io::Error::other(other),
        },
    }
}
