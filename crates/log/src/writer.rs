//! Log writer: a sink that writes samples and events as MCAP messages.

use std::collections::BTreeMap;
use std::io::{self, Write};

use mcap::McapError;

use super::channels::Channels;
use super::mcap_writer::{McapWriter, MessageFeed, Severity};
use super::metadata::RunInfo;
use phalanx_core::trace::{Event, Sample, Sink, SinkError};

/// Streams one run to an MCAP file. Memory use is one chunk plus about 400 bytes of index per written chunk. The writer
/// never seeks, so `W` can be a pipe.
///
/// The caller must also write how the run ended, with [`Writer::note`] and the source `run`; otherwise the log counts
/// as the log of a killed run. [`run_to`](super::run_to) does this.
///
/// Dropping a writer also finishes the log but discards errors; [`Writer::finish`] returns them.
pub struct Writer<W: Write> {
    writer: McapWriter<W>,
    channels: Channels,
    /// Name of this log in errors.
    name: String,
}

impl<W: Write> Writer<W> {
    /// Starts a log: writes header, metadata, scene text and channels. `name` identifies the log in errors.
    pub fn new(out: W, name: &str, run: &RunInfo<'_>) -> Result<Self, SinkError> {
        Writer::with_feed(out, name, run, None)
    }

    /// Like [`Writer::new`], and also passes every message to a feed.
    pub fn with_feed(
        out: W,
        name: &str,
        run: &RunInfo<'_>,
        feed: Option<Box<dyn MessageFeed>>,
    ) -> Result<Self, SinkError> {
        let start = || {
            let mut writer = McapWriter::start(out, run, feed)?;
            let channels = Channels::register(&mut writer, run.scene)?;
            Ok((writer, channels))
        };
        start()
            .map(|(writer, channels)| Writer { writer, channels, name: name.to_string() })
            .map_err(|error| sink_error(name, error))
    }

    /// Writes a line to `/events`, for example how the run ended; `source` names its subject.
    pub fn note(&mut self, time_s: f64, severity: Severity, source: &str, text: &str) -> Result<(), SinkError> {
        let written = self.writer.write_line(self.channels.lines, time_s, severity, source, text);
        self.convert_error(written)
    }

    /// Writes a metadata record about the whole run.
    pub fn record(&mut self, name: &str, entries: BTreeMap<String, String>) -> Result<(), SinkError> {
        let written = self.writer.record(name, entries);
        self.convert_error(written)
    }

    /// Finishes the log (last chunk, index, footer), flushes it and returns the underlying output.
    pub fn finish(self) -> Result<W, SinkError> {
        let Writer { writer, name, .. } = self;
        writer.finish().map_err(|error| sink_error(&name, error))
    }

    /// Adds the name of this log to an error.
    fn convert_error<T>(&self, result: Result<T, McapError>) -> Result<T, SinkError> {
        result.map_err(|error| sink_error(&self.name, error))
    }
}

impl<W: Write> Sink for Writer<W> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let written = self.channels.sample(&mut self.writer, sample).and_then(|()| self.writer.close_full_chunk());
        self.convert_error(written)
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let written = self.channels.event(&mut self.writer, event);
        let written = written.and_then(|()| self.writer.close_full_chunk());
        self.convert_error(written)
    }
}

fn sink_error(name: &str, error: McapError) -> SinkError {
    SinkError {
        target: name.to_string(),
        source: match error {
            McapError::Io(error) => error,
            other => io::Error::other(other),
        },
    }
}
