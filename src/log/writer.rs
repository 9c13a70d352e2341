//! The log writer: a [`Sink`] that turns samples and events into MCAP messages as they come.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};

use foxglove::Encode;
use foxglove::messages::{Log, Timestamp, log::Level};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Attachment, Compression, McapError, WriteOptions};

use super::messages::{Contact, Energy, Impact, Limit, LimitImpact, State, stamp_ns};
use super::metadata::{ATTACHMENT_MEDIA_TYPE, METADATA_NAME, RunInfo, metadata};
use crate::trace::{Event, EventKind, Sample, Sink, SinkError, Site};

/// Uncompressed size at which a chunk is closed, written and flushed: what a killed run loses at most.
pub const CHUNK_BYTES: usize = 256 * 1024;

/// The MCAP file itself: buffered, and never sought in.
type Stream<W> = mcap::Writer<NoSeek<BufWriter<W>>>;

/// How much a line on `/events` matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    Info,
    Error,
}

/// Writes one run to an MCAP file, streaming: what it keeps in memory is one chunk, and some 400 bytes of index for every
/// chunk written. Nothing is ever sought in `W`, so a pipe will do.
///
/// Dropping a writer finishes the log too, but swallows errors; [`Writer::finish`] reports them.
pub struct Writer<W: Write> {
    mcap: Stream<W>,
    channels: Channels,
    /// Encoded message, reused.
    buffer: Vec<u8>,
    /// Uncompressed bytes in the open chunk.
    pending: usize,
    /// Latest log time.
    clock_ns: u64,
    /// What errors call this log.
    name: String,
}

/// The channels that a scene needs; `None` where it has no such thing.
struct Channels {
    state: Channel,
    contacts: Option<[Channel; 2]>,
    limit: Option<Channel>,
    energy: Channel,
    impacts: [Option<Channel>; 3],
    events: Channel,
}

#[derive(Clone, Copy)]
struct Channel {
    id: u16,
    sequence: u32,
}

impl<W: Write> Writer<W> {
    /// Starts a log: header, metadata, scene text and channels. `name` is what errors call it.
    pub fn new(out: W, name: &str, run: &RunInfo<'_>) -> Result<Self, SinkError> {
        Self::start(out, run)
            .map(|(mcap, channels)| Writer {
                mcap,
                channels,
                buffer: Vec::with_capacity(256),
                pending: 0,
                clock_ns: 0,
                name: name.to_string(),
            })
            .map_err(|error| sink_error(name, error))
    }

    fn start(out: W, run: &RunInfo<'_>) -> Result<(Stream<W>, Channels), McapError> {
        let mut mcap = WriteOptions::new()
            .library(concat!("phalanx/", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            // One thread: the bytes must not depend on how many processors there are.
            .compression_threads(0)
            // Chunks end where `close_full_chunk` says, between samples, and reach the file whole.
            .chunk_size(None)
            .disable_seeking(true)
            .create(NoSeek::new(BufWriter::new(out)))?;
        mcap.write_metadata(&mcap::write::Metadata { name: METADATA_NAME.to_string(), metadata: metadata(run) })?;
        mcap.attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: run.scene_file.to_string(),
            media_type: ATTACHMENT_MEDIA_TYPE.to_string(),
            data: Cow::Borrowed(run.scene.source.as_bytes()),
        })?;
        mcap.flush()?;

        let object = run.scene.object.is_some();
        let limit = run.scene.limit.is_some();
        let channels = Channels {
            state: channel::<State, _>(&mut mcap, "/state")?,
            contacts: match object {
                true => Some([
                    channel::<Contact, _>(&mut mcap, "/contact/proximal")?,
                    channel::<Contact, _>(&mut mcap, "/contact/distal")?,
                ]),
                false => None,
            },
            limit: limit.then(|| channel::<Limit, _>(&mut mcap, "/limit")).transpose()?,
            energy: channel::<Energy, _>(&mut mcap, "/energy")?,
            impacts: [
                object.then(|| channel::<Impact, _>(&mut mcap, "/impact/proximal")).transpose()?,
                object.then(|| channel::<Impact, _>(&mut mcap, "/impact/distal")).transpose()?,
                limit.then(|| channel::<LimitImpact, _>(&mut mcap, "/impact/limit")).transpose()?,
            ],
            events: channel::<Log, _>(&mut mcap, "/events")?,
        };
        Ok((mcap, channels))
    }

    /// Writes a line to `/events`, for instance how the run ended.
    pub fn note(&mut self, time_s: f64, severity: Severity, text: &str) -> Result<(), SinkError> {
        self.line(time_s, severity, "run", text).map_err(|error| sink_error(&self.name, error))
    }

    /// Finishes the log (last chunk, index, footer), flushes it, and hands back what it was written to.
    pub fn finish(mut self) -> Result<W, SinkError> {
        let named = |error| sink_error(&self.name, error);
        self.mcap.finish().map_err(named)?;
        let buffered = self.mcap.into_inner().into_inner();
        buffered.into_inner().map_err(|error| sink_error(&self.name, McapError::Io(error.into_error())))
    }

    fn line(&mut self, time_s: f64, severity: Severity, source: &str, text: &str) -> Result<(), McapError> {
        let log_time = self.tick(time_s);
        let level = match severity {
            Severity::Info => Level::Info,
            Severity::Error => Level::Error,
        };
        let message = Log {
            // The stamp of a run longer than 136 years would not fit: it stays at the largest one.
            timestamp: Some(Timestamp::new(
                u32::try_from(log_time / 1_000_000_000).unwrap_or(u32::MAX),
                (log_time % 1_000_000_000) as u32,
            )),
            level: level as i32,
            message: text.to_string(),
            name: source.to_string(),
            ..Log::default()
        };
        self.put(|channels| Some(&mut channels.events), log_time, &message)
    }

    /// Log time of an instant: monotonic whatever rounding does.
    fn tick(&mut self, time_s: f64) -> u64 {
        self.clock_ns = self.clock_ns.max(stamp_ns(time_s));
        self.clock_ns
    }

    /// Writes one message; nothing if the scene has no such channel.
    fn put<M: Encode>(
        &mut self,
        channel: impl FnOnce(&mut Channels) -> Option<&mut Channel>,
        log_time: u64,
        message: &M,
    ) -> Result<(), McapError> {
        let Some(channel) = channel(&mut self.channels) else {
            return Ok(());
        };
        self.buffer.clear();
        message.encode(&mut self.buffer).map_err(|error| McapError::Io(io::Error::other(error.to_string())))?;
        let header =
            MessageHeader { channel_id: channel.id, sequence: channel.sequence, log_time, publish_time: log_time };
        channel.sequence = channel.sequence.wrapping_add(1);
        self.mcap.write_to_known_channel(&header, &self.buffer)?;
        self.pending += RECORD_OVERHEAD + self.buffer.len();
        Ok(())
    }

    /// Closes and flushes the chunk once it is full.
    fn close_full_chunk(&mut self) -> Result<(), McapError> {
        if self.pending < CHUNK_BYTES {
            return Ok(());
        }
        self.pending = 0;
        self.mcap.flush()
    }

    fn put_sample(&mut self, sample: &Sample) -> Result<(), McapError> {
        let log_time = self.tick(sample.time_s);
        self.put(|c| Some(&mut c.state), log_time, &State::from(sample))?;
        for (index, contact) in [&sample.proximal, &sample.distal].into_iter().enumerate() {
            let message = Contact::new(sample.time_s, contact);
            self.put(|c| c.contacts.as_mut().map(|pair| &mut pair[index]), log_time, &message)?;
        }
        self.put(|c| c.limit.as_mut(), log_time, &Limit::from(sample))?;
        self.put(|c| Some(&mut c.energy), log_time, &Energy::from(sample))?;
        self.close_full_chunk()
    }

    fn put_event(&mut self, event: &Event) -> Result<(), McapError> {
        let log_time = self.tick(event.time_s);
        let index = event.site as usize;
        match event.site {
            Site::Proximal | Site::Distal => {
                self.put(|c| c.impacts[index].as_mut(), log_time, &Impact::from(event))?;
            }
            Site::Limit => self.put(|c| c.impacts[index].as_mut(), log_time, &LimitImpact::from(event))?,
        }
        self.line(event.time_s, Severity::Info, event.site.name(), &event_text(event))?;
        self.close_full_chunk()
    }
}

/// Opcode, length, channel, sequence and two times of a message record.
const RECORD_OVERHEAD: usize = 1 + 8 + 2 + 4 + 8 + 8;

impl<W: Write> Sink for Writer<W> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.put_sample(sample).map_err(|error| sink_error(&self.name, error))
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.put_event(event).map_err(|error| sink_error(&self.name, error))
    }
}

/// Registers the schema of `M` (once, however many channels share it) and a channel of it.
fn channel<M: Encode, W: Write>(mcap: &mut Stream<W>, topic: &str) -> Result<Channel, McapError> {
    let schema = match M::get_schema() {
        Some(schema) => mcap.add_schema(&schema.name, &schema.encoding, &schema.data)?,
        None => 0,
    };
    let id = mcap.add_channel(schema, topic, &M::get_message_encoding(), &BTreeMap::new())?;
    Ok(Channel { id, sequence: 0 })
}

/// An event in words and figures.
fn event_text(event: &Event) -> String {
    let site = match event.site {
        Site::Proximal => "proximal phalanx",
        Site::Distal => "distal phalanx",
        Site::Limit => "joint limit",
    };
    let (speed_unit, impulse_unit) = match event.site {
        Site::Proximal | Site::Distal => ("m/s", "N·s"),
        Site::Limit => ("rad/s", "N·m·s"),
    };
    let time_ms = event.time_s * 1e3;
    match event.kind {
        EventKind::TouchDown => {
            format!("{site}: touch-down at {time_ms:.6} ms, approach speed {:.6} {speed_unit}", event.approach_speed)
        }
        EventKind::LiftOff => {
            format!(
                "{site}: lift-off at {time_ms:.6} ms, impulse {:.6e} {impulse_unit} since touch-down",
                event.impulse
            )
        }
        EventKind::Reload => format!("{site}: pressed again at {time_ms:.6} ms, before it had parted"),
    }
}

fn sink_error(name: &str, error: McapError) -> SinkError {
    SinkError {
        what: name.to_string(),
        source: match error {
            McapError::Io(error) => error,
            other => io::Error::other(other),
        },
    }
}
