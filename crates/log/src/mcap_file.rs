//! MCAP file of a log: chunks, channels and a common clock, independent of the kind of scene.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};

use foxglove::messages::{Log, Timestamp, log::Level};
use foxglove::{Encode, Schema};
use mcap::records::MessageHeader;
use mcap::write::{Metadata, NoSeek};
use mcap::{Attachment, Compression, McapError, WriteOptions};

use super::messages::stamp_ns;
use super::metadata::{ATTACHMENT_MEDIA_TYPE, METADATA_NAME, RunInfo, metadata, scene_text};
use phalanx_core::trace::SinkError;

/// Maximum uncompressed size of a chunk. A chunk that reaches it is closed, written and flushed, so that a killed run
/// loses at most this much data.
pub const CHUNK_BYTES: usize = 256 * 1024;

/// Size of the first chunks: small, so that little is left to compress at the end of a short run.
const FIRST_CHUNK_BYTES: usize = 32 * 1024;
/// Chunks grow with the log: their size is the number of bytes already written divided by this.
const CHUNK_GROWTH_DIVISOR: usize = 8;

/// zstd compression level: a log is about a tenth smaller than at level −3, and the thread that writes it executes a third
/// more instructions.
const COMPRESSION_LEVEL: u32 = 3;

/// Bytes of opcode, length, channel, sequence and two times of a message record.
const RECORD_OVERHEAD: usize = 1 + 8 + 2 + 4 + 8 + 8;

/// Encoding of all messages.
const ENCODING: &str = "protobuf";

/// Index of a channel among those of this log.
#[derive(Clone, Copy, Debug)]
pub struct ChannelId(usize);

/// Buffered writer of the file; it never seeks.
pub(crate) struct McapFile<W: Write> {
    mcap: mcap::Writer<NoSeek<BufWriter<W>>>,
    /// Name of this log in errors.
    name: String,
    /// Id in the file and next sequence number of every channel.
    channels: Vec<(u16, u32)>,
    /// Reused buffer of the encoded message.
    buffer: Vec<u8>,
    /// Uncompressed bytes in the open chunk.
    open_chunk_bytes: usize,
    /// Uncompressed bytes in all closed chunks.
    closed_chunk_bytes: usize,
    /// Latest log time.
    clock_ns: u64,
}

impl<W: Write> McapFile<W> {
    /// Starts a file: writes header, metadata and scene text. `name` identifies the log in errors.
    pub fn start(out: W, name: &str, run: &RunInfo<'_>) -> Result<Self, SinkError> {
        let options = WriteOptions::new()
            .library(concat!("phalanx/", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_level(COMPRESSION_LEVEL)
            // One thread: the bytes must not depend on the number of processors.
            .compression_threads(0)
            // The writer ends chunks explicitly, between samples.
            .chunk_size(None)
            .disable_seeking(true);
        let mcap = options.create(NoSeek::new(BufWriter::new(out))).map_err(|error| sink_error(name, error))?;
        let mut file = McapFile {
            mcap,
            name: name.to_string(),
            channels: Vec::new(),
            buffer: Vec::with_capacity(256),
            open_chunk_bytes: 0,
            closed_chunk_bytes: 0,
            clock_ns: 0,
        };
        file.record(METADATA_NAME, metadata(run))?;
        let text = scene_text(run.scene);
        let attached = file.mcap.attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: run.scene_file.to_string(),
            media_type: ATTACHMENT_MEDIA_TYPE.to_string(),
            data: Cow::Borrowed(text.as_bytes()),
        });
        let flushed = attached.and_then(|()| file.mcap.flush());
        file.convert_error(flushed)?;
        Ok(file)
    }

    /// Writes a metadata record.
    pub fn record(&mut self, name: &str, metadata: BTreeMap<String, String>) -> Result<(), SinkError> {
        let written = self.mcap.write_metadata(&Metadata { name: name.to_string(), metadata });
        self.convert_error(written)
    }

    /// Finishes the file (last chunk, index, footer), flushes it and returns the underlying output.
    pub fn finish(mut self) -> Result<W, SinkError> {
        let finished = self.mcap.finish();
        self.convert_error(finished)?;
        let McapFile { mcap, name, .. } = self;
        let flushed = mcap.into_inner().into_inner().into_inner();
        flushed.map_err(|error| SinkError { target: name, source: error.into_error() })
    }

    /// Registers a channel of protobuf messages. The schema is written once for all channels that share it.
    pub fn register(&mut self, topic: &str, schema: Option<Schema>) -> Result<ChannelId, SinkError> {
        self.register_with_metadata(topic, schema, &BTreeMap::new())
    }

    /// Registers a channel with metadata.
    pub fn register_with_metadata(
        &mut self,
        topic: &str,
        schema: Option<Schema>,
        metadata: &BTreeMap<String, String>,
    ) -> Result<ChannelId, SinkError> {
        let schema_id = match &schema {
            Some(schema) => self.mcap.add_schema(&schema.name, &schema.encoding, &schema.data),
            None => Ok(0),
        };
        let id = schema_id.and_then(|schema| self.mcap.add_channel(schema, topic, ENCODING, metadata));
        let id = self.convert_error(id)?;
        self.channels.push((id, 0));
        Ok(ChannelId(self.channels.len() - 1))
    }

    /// Returns the log time of an instant, ns. It never decreases, despite rounding.
    pub fn log_time_ns(&mut self, time_s: f64) -> u64 {
        self.clock_ns = self.clock_ns.max(stamp_ns(time_s));
        self.clock_ns
    }

    /// Writes a Foxglove message.
    pub fn write_message<M: Encode>(
        &mut self,
        channel: ChannelId,
        log_time: u64,
        message: &M,
    ) -> Result<(), SinkError> {
        self.buffer.clear();
        let encoded = message.encode(&mut self.buffer);
        let encoded = encoded.map_err(|error| McapError::Io(io::Error::other(error.to_string())));
        self.convert_error(encoded)?;
        self.write_buffer(channel, log_time)
    }

    /// Writes a message. `encode` appends its bytes to an empty buffer.
    pub fn write(
        &mut self,
        channel: ChannelId,
        time_s: f64,
        encode: impl FnOnce(&mut Vec<u8>),
    ) -> Result<(), SinkError> {
        self.buffer.clear();
        encode(&mut self.buffer);
        let log_time = self.log_time_ns(time_s);
        self.write_buffer(channel, log_time)
    }

    /// Writes a line of text on a channel of `foxglove.Log`.
    pub fn write_line(
        &mut self,
        channel: ChannelId,
        time_s: f64,
        severity: Level,
        source: &str,
        text: &str,
    ) -> Result<(), SinkError> {
        let log_time = self.log_time_ns(time_s);
        let (timestamp, message, name) = (Some(to_timestamp(log_time)), text.to_string(), source.to_string());
        let line = Log { timestamp, level: severity as i32, message, name, ..Log::default() };
        self.write_message(channel, log_time, &line)
    }

    /// Writes the encoded message in the buffer.
    fn write_buffer(&mut self, channel: ChannelId, log_time: u64) -> Result<(), SinkError> {
        let (channel_id, sequence) = &mut self.channels[channel.0];
        let header = MessageHeader { channel_id: *channel_id, sequence: *sequence, log_time, publish_time: log_time };
        *sequence = sequence.wrapping_add(1);
        let written = self.mcap.write_to_known_channel(&header, &self.buffer);
        self.convert_error(written)?;
        self.open_chunk_bytes += RECORD_OVERHEAD + self.buffer.len();
        Ok(())
    }

    /// Closes and flushes the chunk once it is full.
    pub(crate) fn close_full_chunk(&mut self) -> Result<(), SinkError> {
        let limit = (self.closed_chunk_bytes / CHUNK_GROWTH_DIVISOR).clamp(FIRST_CHUNK_BYTES, CHUNK_BYTES);
        if self.open_chunk_bytes < limit {
            return Ok(());
        }
        self.closed_chunk_bytes += std::mem::take(&mut self.open_chunk_bytes);
        let flushed = self.mcap.flush();
        self.convert_error(flushed)
    }

    /// Adds the name of this log to an error.
    fn convert_error<T>(&self, result: Result<T, McapError>) -> Result<T, SinkError> {
        result.map_err(|error| sink_error(&self.name, error))
    }
}

fn sink_error(name: &str, error: McapError) -> SinkError {
    let source = match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    };
    SinkError { target: name.to_string(), source }
}

/// Converts a log time to a Foxglove timestamp. Seconds saturate at `u32::MAX`, which is 136 years.
pub(crate) fn to_timestamp(log_time_ns: u64) -> Timestamp {
    Timestamp::new(u32::try_from(log_time_ns / 1_000_000_000).unwrap_or(u32::MAX), (log_time_ns % 1_000_000_000) as u32)
}
