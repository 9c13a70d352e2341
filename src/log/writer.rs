//! The log writer: a sink that turns samples and events into MCAP messages as they come.

use std::collections::BTreeMap;
use std::io::{self, Write};

use foxglove::messages::Log;
use mcap::McapError;

use super::core::{ChannelId, Core, Feed, Severity};
use super::finger::FingerChannels;
use super::metadata::{Logged, RunInfo};
use crate::trace::{Instant, SinkError};

/// Writes one run to an MCAP file, streaming: what it keeps in memory is one chunk, and some 400 bytes of index for every
/// chunk written. Nothing is ever sought in `W`, so a pipe will do. `C` are the channels of a kind of scene.
///
/// What it writes of a run is what it is given: how the run ended, too, has to be said, by [`Writer::note`] as source `run`, or the
/// log is that of a run that was killed. [`run_to`](super::run_to) does all of it.
///
/// Dropping a writer finishes the log too, but swallows errors; [`Writer::finish`] reports them.
pub struct Writer<W: Write, C = FingerChannels> {
    core: Core<W>,
    channels: C,
    events: ChannelId,
    /// What errors call this log.
    name: String,
}

/// Channels of a kind of scene, and what goes into them.
pub trait Channels: Sized + Send + 'static {
    type Scene;
    type Sample: Instant + Send + 'static;
    type Event: Copy + Send + 'static;

    /// Registers the channels when a log starts.
    fn register<W: Write>(core: &mut Core<W>, scene: &Self::Scene) -> Result<Self, McapError>;

    /// Writes a sample.
    fn sample<W: Write>(&mut self, core: &mut Core<W>, sample: &Self::Sample) -> Result<(), McapError>;

    /// Writes an event as figures, and as text on the channel `lines`.
    fn event<W: Write>(&mut self, core: &mut Core<W>, lines: ChannelId, event: &Self::Event) -> Result<(), McapError>;
}

impl<W: Write, C: Channels> Writer<W, C> {
    /// Starts a log: header, metadata, scene text and channels. `name` is what errors call it.
    pub fn new<S: Logged<Channels = C>>(out: W, name: &str, run: &RunInfo<'_, S>) -> Result<Self, SinkError>
    where
        C: Channels<Scene = S>,
    {
        Writer::with_feed(out, name, run, None)
    }

    /// The same, with every message handed to a feed as well.
    pub fn with_feed<S>(
        out: W,
        name: &str,
        run: &RunInfo<'_, S>,
        feed: Option<Box<dyn Feed>>,
    ) -> Result<Self, SinkError>
    where
        S: Logged<Channels = C>,
        C: Channels<Scene = S>,
    {
        let start = || {
            let mut core = Core::start(out, run, feed)?;
            let channels = C::register(&mut core, run.scene)?;
            let events = core.channel::<Log>("/events")?;
            Ok((core, channels, events))
        };
        start()
            .map(|(core, channels, events)| Writer { core, channels, events, name: name.to_string() })
            .map_err(|error| sink_error(name, error))
    }

    /// Writes a sample.
    pub fn take(&mut self, sample: &C::Sample) -> Result<(), SinkError> {
        let written = self.channels.sample(&mut self.core, sample).and_then(|()| self.core.close_full_chunk());
        self.named(written)
    }

    /// Writes an event.
    pub fn take_event(&mut self, event: &C::Event) -> Result<(), SinkError> {
        let written = self.channels.event(&mut self.core, self.events, event);
        let written = written.and_then(|()| self.core.close_full_chunk());
        self.named(written)
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

pub(super) fn sink_error(name: &str, error: McapError) -> SinkError {
    SinkError {
        what: name.to_string(),
        source: match error {
            McapError::Io(error) => error,
            other => io::Error::other(other),
        },
    }
}
