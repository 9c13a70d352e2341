//! The file beneath a log: chunks, channels, one clock. What a kind of scene says goes through here.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};

use foxglove::messages::{Log, Timestamp, log::Level};
use foxglove::{Encode, Schema};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Attachment, Compression, McapError, WriteOptions};

use super::messages::stamp_ns;
use super::metadata::{ATTACHMENT_MEDIA_TYPE, METADATA_NAME, RunInfo, metadata, scene_text};
use super::schema::schema_of;

/// Largest uncompressed size of a chunk, at which it is closed, written and flushed: what a killed run loses at most.
pub const CHUNK_BYTES: usize = 256 * 1024;

/// The first chunks are smaller, so that little is left to compress when a short run is over…
const FIRST_CHUNK_BYTES: usize = 16 * 1024;
/// …and grow with what has been written: each is an eighth of it.
const CHUNK_SHARE: usize = 8;

/// Level of zstd, a negative one as the crate takes it: a log of the engine takes a quarter less time than at level 1, and 6 %
/// more bytes.
const COMPRESSION_LEVEL: u32 = (-3i32) as u32;

/// Opcode, length, channel, sequence and two times of a message record.
pub(super) const RECORD_OVERHEAD: usize = 1 + 8 + 2 + 4 + 8 + 8;

/// How much a line on `/events` matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    Info,
    Warning,
    Error,
}

/// A channel of this log, by its place among them.
#[derive(Clone, Copy, Debug)]
pub struct ChannelId(usize);

struct Channel {
    id: u16,
    sequence: u32,
}

/// Who is handed every message as it is logged, for instance a server: the same channels, in the same order, the same bytes.
pub trait Feed: Send {
    /// A channel begins; they are numbered from 0 in the order of these calls.
    fn channel(&mut self, topic: &str, encoding: &str, schema: Option<Schema>);

    /// A message on a channel. How it fares with those who are fed does not concern the log.
    fn put(&mut self, channel: usize, log_time_ns: u64, message: &[u8]);
}

/// The MCAP file itself, buffered and never sought in, with its channels.
pub struct Core<W: Write> {
    mcap: mcap::Writer<NoSeek<BufWriter<W>>>,
    channels: Vec<Channel>,
    /// Encoded message, reused.
    buffer: Vec<u8>,
    /// Uncompressed bytes in the open chunk, and in those before it.
    pending: usize,
    written: usize,
    /// Latest log time.
    clock_ns: u64,
    feed: Option<Box<dyn Feed>>,
}

impl<W: Write> Core<W> {
    /// Starts a file: header, metadata, scene text.
    pub fn start(out: W, run: &RunInfo<'_>, feed: Option<Box<dyn Feed>>) -> Result<Self, McapError> {
        let options = options().compression_level(COMPRESSION_LEVEL);
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
        Ok(Core {
            mcap,
            channels: Vec::new(),
            buffer: Vec::with_capacity(256),
            pending: 0,
            written: 0,
            clock_ns: 0,
            feed,
        })
    }

    /// Writes a metadata record.
    pub fn record(&mut self, name: &str, metadata: BTreeMap<String, String>) -> Result<(), McapError> {
        self.mcap.write_metadata(&mcap::write::Metadata { name: name.to_string(), metadata })
    }

    /// Registers the schema of `M` (once, however many channels share it) and a channel of it.
    pub fn channel<M: Encode>(&mut self, topic: &str) -> Result<ChannelId, McapError> {
        let (schema, encoding) = (schema_of::<M>(), M::get_message_encoding());
        let schema_id = match &schema {
            Some(schema) => self.mcap.add_schema(&schema.name, &schema.encoding, &schema.data)?,
            None => 0,
        };
        let id = self.mcap.add_channel(schema_id, topic, &encoding, &BTreeMap::new())?;
        if let Some(feed) = &mut self.feed {
            feed.channel(topic, &encoding, schema);
        }
        self.channels.push(Channel { id, sequence: 0 });
        Ok(ChannelId(self.channels.len() - 1))
    }

    /// Log time of an instant: monotonic whatever rounding does.
    pub fn tick(&mut self, time_s: f64) -> u64 {
        self.clock_ns = self.clock_ns.max(stamp_ns(time_s));
        self.clock_ns
    }

    /// Writes one message.
    pub fn put<M: Encode>(&mut self, channel: ChannelId, log_time: u64, message: &M) -> Result<(), McapError> {
        let Channel { id, sequence } = &mut self.channels[channel.0];
        self.buffer.clear();
        message.encode(&mut self.buffer).map_err(|error| McapError::Io(io::Error::other(error.to_string())))?;
        let header = MessageHeader { channel_id: *id, sequence: *sequence, log_time, publish_time: log_time };
        *sequence = sequence.wrapping_add(1);
        self.mcap.write_to_known_channel(&header, &self.buffer)?;
        if let Some(feed) = &mut self.feed {
            feed.put(channel.0, log_time, &self.buffer);
        }
        self.pending += RECORD_OVERHEAD + self.buffer.len();
        Ok(())
    }

    /// Writes a line of text on a channel of `foxglove.Log`.
    pub fn line(
        &mut self,
        channel: ChannelId,
        time_s: f64,
        severity: Severity,
        source: &str,
        text: &str,
    ) -> Result<(), McapError> {
        let log_time = self.tick(time_s);
        let level = match severity {
            Severity::Info => Level::Info,
            Severity::Warning => Level::Warning,
            Severity::Error => Level::Error,
        };
        let message = Log {
            timestamp: Some(stamp(log_time)),
            level: level as i32,
            message: text.to_string(),
            name: source.to_string(),
            ..Log::default()
        };
        self.put(channel, log_time, &message)
    }

    /// Closes and flushes the chunk once it is full.
    pub fn close_full_chunk(&mut self) -> Result<(), McapError> {
        if self.pending < (self.written / CHUNK_SHARE).clamp(FIRST_CHUNK_BYTES, CHUNK_BYTES) {
            return Ok(());
        }
        self.written += std::mem::take(&mut self.pending);
        self.mcap.flush()
    }

    /// Finishes the file (last chunk, index, footer), flushes it, and hands back what it was written to.
    pub fn finish(mut self) -> Result<W, McapError> {
        self.mcap.finish()?;
        let buffered = self.mcap.into_inner().into_inner();
        buffered.into_inner().map_err(|error| McapError::Io(error.into_error()))
    }
}

/// How every log is written.
pub fn options() -> WriteOptions {
    WriteOptions::new()
        .library(concat!("phalanx/", env!("CARGO_PKG_VERSION")))
        .compression(Some(Compression::Zstd))
        // One thread: the bytes must not depend on how many processors there are.
        .compression_threads(0)
        // Chunks end where their writer says, between samples, and reach the file whole.
        .chunk_size(None)
        .disable_seeking(true)
}

/// A log time as the messages of foxglove have it. That of a run longer than 136 years would not fit: it stays at the
/// largest one.
pub fn stamp(log_time_ns: u64) -> Timestamp {
    Timestamp::new(u32::try_from(log_time_ns / 1_000_000_000).unwrap_or(u32::MAX), (log_time_ns % 1_000_000_000) as u32)
}
