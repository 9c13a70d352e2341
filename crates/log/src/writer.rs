//! Log writer: a sink that writes samples and events as messages of an MCAP file.

use std::collections::BTreeMap;
use std::io::Write;

use foxglove::messages::log::Level;

use super::channels::Channels;
use super::mcap_file::{McapFile, MessageFeed};
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
    file: McapFile<W>,
    channels: Channels,
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
        let mut file = McapFile::start(out, name, run, feed)?;
        let channels = Channels::register(&mut file, run.scene)?;
        Ok(Writer { file, channels })
    }

    /// Writes a line to `/events`, for example how the run ended; `source` names its subject.
    pub fn note(&mut self, time_s: f64, severity: Level, source: &str, text: &str) -> Result<(), SinkError> {
        self.file.write_line(self.channels.lines, time_s, severity, source, text)
    }

    /// Writes a metadata record about the whole run.
    pub fn record(&mut self, name: &str, metadata: BTreeMap<String, String>) -> Result<(), SinkError> {
        self.file.record(name, metadata)
    }

    /// Finishes the log (last chunk, index, footer), flushes it and returns the underlying output.
    pub fn finish(self) -> Result<W, SinkError> {
        self.file.finish()
    }
}

impl<W: Write> Sink for Writer<W> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.channels.sample(&mut self.file, sample)?;
        self.file.close_full_chunk()
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.channels.event(&mut self.file, event)?;
        self.file.close_full_chunk()
    }
}
