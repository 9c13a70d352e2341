//! The log writer: a sink that turns samples and events into MCAP messages as they come.

use std::io::{self, Write};

use foxglove::messages::Log;
use mcap::McapError;

use super::core::{ChannelId, Core, Feed, Severity};
use super::metadata::{Logged, RunInfo};
use crate::trace::SinkError;

/// Writes one run to an MCAP file, streaming: what it keeps in memory is one chunk, and some 400 bytes of index for every
/// chunk written. Nothing is ever sought in `W`, so a pipe will do. `C` are the channels of a kind of scene.
///
/// Dropping a writer finishes the log too, but swallows errors; [`Writer::finish`] reports them.
pub struct Writer<W: Write, C = super::finger::FingerChannels> {
    pub(super) core: Core<W>,
    pub(super) channels: C,
    pub(super) events: ChannelId,
    /// What errors call this log.
    name: String,
}

/// Channels of a kind of scene, registered when a log of it starts.
pub trait Channels<S>: Sized {
    fn register<W: Write>(core: &mut Core<W>, scene: &S) -> Result<Self, McapError>;
}

impl<W: Write, C> Writer<W, C> {
    /// Starts a log: header, metadata, scene text and channels. `name` is what errors call it.
    pub fn new<S>(out: W, name: &str, run: &RunInfo<'_, S>) -> Result<Self, SinkError>
    where
        S: Logged<Channels = C>,
        C: Channels<S>,
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
        C: Channels<S>,
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

    /// Writes a line to `/events`, for instance how the run ended.
    pub fn note(&mut self, time_s: f64, severity: Severity, text: &str) -> Result<(), SinkError> {
        let written = self.core.line(self.events, time_s, severity, "run", text);
        self.named(written)
    }

    /// Finishes the log (last chunk, index, footer), flushes it, and hands back what it was written to.
    pub fn finish(self) -> Result<W, SinkError> {
        let Writer { core, name, .. } = self;
        core.finish().map_err(|error| sink_error(&name, error))
    }

    /// An error under the name of this log.
    pub(super) fn named<T>(&self, result: Result<T, McapError>) -> Result<T, SinkError> {
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
