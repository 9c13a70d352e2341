//! MCAP file of a log: chunks, channels and a common clock, independent of the kind of scene.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};

use foxglove::messages::{Log, Timestamp, log::Level};
use foxglove::{Encode, Schema};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Attachment, Compression, McapError, WriteOptions};

use super::messages::{encode, stamp_ns};
use super::metadata::{ATTACHMENT_MEDIA_TYPE, METADATA_NAME, RunInfo, metadata, scene_text};

/// Maximum uncompressed chunk size. A chunk of this size is closed, written and flushed, so a killed run loses at most
/// this much.
pub const CHUNK_BYTES: usize = 256 * 1024;

/// Size of the first chunks: small, so that little is left to compress at the end of a short run.
const FIRST_CHUNK_BYTES: usize = 16 * 1024;
/// Chunks grow with the log: their size is the number of bytes already written divided by this.
const CHUNK_GROWTH_DIVISOR: usize = 8;

/// zstd compression level −3, encoded as the crate requires: compared with level 1, a log of the engine model takes a
/// quarter less time and 6 % more bytes.
const COMPRESSION_LEVEL: u32 = (-3i32) as u32;

/// Bytes of opcode, length, channel, sequence and two times of a message record.
const RECORD_OVERHEAD: usize = 1 + 8 + 2 + 4 + 8 + 8;

/// Encoding of all messages.
const ENCODING: &str = "protobuf";

/// Severity of a line on `/events`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    Info,
    Warning,
    Error,
}

/// Index of a channel of this log.
#[derive(Clone, Copy, Debug)]
pub struct ChannelId(usize);

struct Channel {
    id: u16,
    sequence: u32,
}

/// Receiver of every message as it is logged, for example a server: same channels, same order, same bytes.
pub trait MessageFeed: Send {
    /// Adds a channel. Channels are numbered from 0 in the order of these calls.
    fn add_channel(&mut self, topic: &str, encoding: &str, schema: Option<Schema>);

    /// Passes on a message of a channel. Delivery errors do not affect the log.
    fn write_message(&mut self, channel: usize, log_time_ns: u64, message: &[u8]);
}

/// Buffered writer of an MCAP file and its channels; it never seeks.
pub struct McapWriter<W: Write> {
    mcap: mcap::Writer<NoSeek<BufWriter<W>>>,
    channels: Vec<Channel>,
    /// Reused buffer of the encoded message.
    buffer: Vec<u8>,
    /// Uncompressed bytes in the open chunk.
    open_chunk_bytes: usize,
    /// Uncompressed bytes in all closed chunks.
    closed_chunk_bytes: usize,
    /// Latest log time.
    clock_ns: u64,
    feed: Option<Box<dyn MessageFeed>>,
}

impl<W: Write> McapWriter<W> {
    /// Starts a file: writes header, metadata and scene text.
    pub fn start(out: W, run: &RunInfo<'_>, feed: Option<Box<dyn MessageFeed>>) -> Result<Self, McapError> {
        let options = WriteOptions::new()
            .library(concat!("phalanx/", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_level(COMPRESSION_LEVEL)
            // One thread: the bytes must not depend on the number of processors.
            .compression_threads(0)
            // The writer ends chunks explicitly, between samples.
            .chunk_size(None)
            .disable_seeking(true);
        let mut mcap = options.create(NoSeek::new(BufWriter::new(out)))?;
        mcap.write_metadata(&mcap::write::Metadata { name: METADATA_NAME.to_string(), metadata: metadata(run) })?;
        let text = scene_text(run.scene);
        mcap.attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: run.scene_file.to_string(),
            media_type: ATTACHMENT_MEDIA_TYPE.to_string(),
            data: Cow::Borrowed(text.as_bytes()),
        })?;
        mcap.flush()?;
        Ok(McapWriter {
            mcap,
            channels: Vec::new(),
            buffer: Vec::with_capacity(256),
            open_chunk_bytes: 0,
            closed_chunk_bytes: 0,
            clock_ns: 0,
            feed,
        })
    }

    /// Writes a metadata record.
    pub fn record(&mut self, name: &str, metadata: BTreeMap<String, String>) -> Result<(), McapError> {
        self.mcap.write_metadata(&mcap::write::Metadata { name: name.to_string(), metadata })
    }

    /// Registers a channel of Foxglove messages.
    pub fn register_channel<M: Encode>(&mut self, topic: &str) -> Result<ChannelId, McapError> {
        self.register(topic, M::get_schema())
    }

    /// Registers a channel of protobuf messages. The schema is written once for all channels that share it.
    pub fn register(&mut self, topic: &str, schema: Option<Schema>) -> Result<ChannelId, McapError> {
        let schema_id = match &schema {
            Some(schema) => self.mcap.add_schema(&schema.name, &schema.encoding, &schema.data)?,
            None => 0,
        };
        let id = self.mcap.add_channel(schema_id, topic, ENCODING, &BTreeMap::new())?;
        if let Some(feed) = &mut self.feed {
            feed.add_channel(topic, ENCODING, schema);
        }
        self.channels.push(Channel { id, sequence: 0 });
        Ok(ChannelId(self.channels.len() - 1))
    }

    /// Returns the log time of an instant, ns. It never decreases, despite rounding.
    pub fn log_time_ns(&mut self, time_s: f64) -> u64 {
        self.clock_ns = self.clock_ns.max(stamp_ns(time_s));
        self.clock_ns
    }

    /// Writes a message of Foxglove.
    pub fn write_message<M: Encode>(
        &mut self,
        channel: ChannelId,
        log_time: u64,
        message: &M,
    ) -> Result<(), McapError> {
        self.buffer.clear();
        message.encode(&mut self.buffer).map_err(|error| McapError::Io(io::Error::other(error.to_string())))?;
        self.write_buffer(channel, log_time)
    }

    /// Writes a message of phalanx.
    pub fn write_numbers(
        &mut self,
        channel: ChannelId,
        time_s: f64,
        flags: &[bool],
        numbers: &[f64],
    ) -> Result<(), McapError> {
        self.buffer.clear();
        encode(time_s, flags, numbers, &mut self.buffer);
        let log_time = self.log_time_ns(time_s);
        self.write_buffer(channel, log_time)
    }

    /// Writes the encoded message in the buffer.
    fn write_buffer(&mut self, channel: ChannelId, log_time: u64) -> Result<(), McapError> {
        let Channel { id, sequence } = &mut self.channels[channel.0];
        let header = MessageHeader { channel_id: *id, sequence: *sequence, log_time, publish_time: log_time };
        *sequence = sequence.wrapping_add(1);
        self.mcap.write_to_known_channel(&header, &self.buffer)?;
        if let Some(feed) = &mut self.feed {
            feed.write_message(channel.0, log_time, &self.buffer);
        }
        self.open_chunk_bytes += RECORD_OVERHEAD + self.buffer.len();
        Ok(())
    }

    /// Writes a line of text on a channel of `foxglove.Log`.
    pub fn write_line(
        &mut self,
        channel: ChannelId,
        time_s: f64,
        severity: Severity,
        source: &str,
        text: &str,
    ) -> Result<(), McapError> {
        let log_time = self.log_time_ns(time_s);
        let level = match severity {
            Severity::Info => Level::Info,
            Severity::Warning => Level::Warning,
            Severity::Error => Level::Error,
        };
        let message = Log {
            timestamp: Some(to_timestamp(log_time)),
            level: level as i32,
            message: text.to_string(),
            name: source.to_string(),
            ..Log::default()
        };
        self.write_message(channel, log_time, &message)
    }

    /// Closes and flushes the chunk once it is full.
    pub fn close_full_chunk(&mut self) -> Result<(), McapError> {
        if self.open_chunk_bytes
            < (self.closed_chunk_bytes / CHUNK_GROWTH_DIVISOR).clamp(FIRST_CHUNK_BYTES, CHUNK_BYTES)
        {
            return Ok(());
        }
        self.closed_chunk_bytes += std::mem::take(&mut self.open_chunk_bytes);
        self.mcap.flush()
    }

    /// Finishes the file (last chunk, index, footer), flushes it and returns the underlying output.
    pub fn finish(mut self) -> Result<W, McapError> {
        self.mcap.finish()?;
        let buffered = self.mcap.into_inner().into_inner();
        buffered.into_inner().map_err(|error| McapError::Io(error.into_error()))
    }
}

/// Converts a log time to a Foxglove timestamp. Seconds saturate at `u32::MAX`, which is 136 years.
pub fn to_timestamp(log_time_ns: u64) -> Timestamp {
    Timestamp::new(u32::try_from(log_time_ns / 1_000_000_000).unwrap_or(u32::MAX), (log_time_ns % 1_000_000_000) as u32)
}
