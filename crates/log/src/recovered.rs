//! Recovers the intact part of a damaged log as a complete, indexed log that documents what is missing.
//!
//! Metadata, attachment, schemas, channels and messages are copied from the source in its order, byte for byte and with
//! the same ids. Intact chunks after damage are included; the sequence numbers of their messages tell exactly what is
//! missing before them. A metadata record [`RECOVERED_NAME`] describes the source:
//!
//! | entry | content |
//! |---|---|
//! | `source`, `source_bytes` | name of the damaged log, without directories, and its size |
//! | `loss_descriptions` | description of the losses |
//! | `messages` | number of recovered messages |
//! | `gaps` | number of gaps, not counting the end |
//! | `gap_1_after_messages`, `gap_1_from_s`, `gap_1_to_s`, … | number of messages before the gap, log times around it |
//! | `missing_messages` | number of messages missing before later messages of their channels |
//! | `phalanx_version` | version that recovered the log |

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::{BufWriter, Read, Seek, Write};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Attachment, McapError};

use super::mcap_writer::{CHUNK_BYTES, RECORD_OVERHEAD, write_options};
use super::metadata::METADATA_NAME;
use super::metadata::RECOVERED_NAME;
use super::reader::{LogSink, LogSummary, MessageRecord, ReadError, Record, read_past_damage};
use super::writer::sink_error;
use phalanx_core::trace::SinkError;

/// Topic of the last message of every sample.
const SAMPLE_END_TOPIC: &str = "/energy";

/// A gap with missing messages.
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// Number of messages of the recovered log before the gap.
    pub after_messages: u64,
    /// Log time of the last message before the gap.
    pub from_s: f64,
    /// Log time of the first message after the gap.
    pub to_s: f64,
}

/// Result of a recovery.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recovery {
    /// Summary of the damaged log.
    pub reading: LogSummary,
    /// Number of recovered messages.
    pub messages: u64,
    /// Number of messages omitted because their channel records are lost.
    pub unidentified: u64,
    pub gaps: Vec<Gap>,
    /// Number of messages missing before later messages of their channels.
    pub missing: u64,
    /// Log time of the last message.
    pub to_s: Option<f64>,
}

/// Called with the log time of every message, ns; an error aborts the operation.
pub type ProgressCheck<'a> = &'a dyn Fn(u64) -> Result<(), SinkError>;

/// Writes the intact part of a log. `source_name` is the file name of the source, without directories; `name`
/// identifies the new log in errors.
///
/// # Errors
/// Returns [`ReadError`] if the source is not a log, or the new log cannot be written.
pub fn recover(
    source: &mut (impl Read + Seek),
    source_name: &str,
    out: impl Write,
    name: &str,
    check: ProgressCheck<'_>,
) -> Result<Recovery, ReadError> {
    let mut survey = RecoverySurvey::new(check);
    let reading = read_past_damage(&mut *source, &mut survey)?;
    let recovery = survey.finish(reading);
    let entries = entries(&recovery, source_name);
    let to_sink_error = |error| sink_error(name, error);
    let mcap = write_options().create(NoSeek::new(BufWriter::new(out))).map_err(to_sink_error)?;
    let mut copy = LogCopy {
        mcap,
        name,
        entries: Some(entries),
        channels: HashSet::new(),
        open_chunk_bytes: 0,
        latest_ns: 0,
        check,
    };
    read_past_damage(source, &mut copy)?;
    let mut mcap = copy.mcap;
    mcap.finish().map_err(to_sink_error)?;
    let mut buffered = mcap.into_inner().into_inner();
    buffered.flush().map_err(|error| to_sink_error(McapError::Io(error)))?;
    Ok(recovery)
}

/// Returns the gaps recorded in a recovered log.
pub fn gaps(entries: &BTreeMap<String, String>) -> Vec<Gap> {
    fn number<T: std::str::FromStr>(entries: &BTreeMap<String, String>, index: u64, field: &str) -> Option<T> {
        entries.get(&format!("gap_{index}_{field}"))?.parse().ok()
    }
    let gap = |index| {
        Some(Gap {
            after_messages: number(entries, index, "after_messages")?,
            from_s: number(entries, index, "from_s")?,
            to_s: number(entries, index, "to_s")?,
        })
    };
    (1..).map_while(gap).collect()
}

fn entries(found: &Recovery, source_name: &str) -> BTreeMap<String, String> {
    let mut loss_descriptions: Vec<String> = found.reading.losses.iter().map(ToString::to_string).collect();
    if found.missing > 0 {
        loss_descriptions.push(format!("{} messages are missing before later ones", found.missing));
    }
    if found.unidentified > 0 {
        loss_descriptions
            .push(format!("{} messages are omitted because their channel records are lost", found.unidentified));
    }
    if let Some(before) = found.reading.recovered.as_ref().and_then(|entries| entries.get("lost")) {
        loss_descriptions.push(format!("the source was itself a recovered log, with these losses: {before}"));
    }
    if loss_descriptions.is_empty() {
        loss_descriptions.push("nothing".to_string());
    }
    let mut entries = vec![
        ("source".to_string(), source_name.to_string()),
        ("source_bytes".to_string(), found.reading.bytes.to_string()),
        ("lost".to_string(), loss_descriptions.join("; ")),
        ("messages".to_string(), found.messages.to_string()),
        ("missing_messages".to_string(), found.missing.to_string()),
        ("gaps".to_string(), found.gaps.len().to_string()),
        ("phalanx_version".to_string(), env!("CARGO_PKG_VERSION").to_string()),
    ];
    for (index, gap) in found.gaps.iter().enumerate() {
        let entry = |field: &str, value: String| (format!("gap_{}_{field}", index + 1), value);
        entries.push(entry("after_messages", gap.after_messages.to_string()));
        entries.push(entry("from_s", format!("{:?}", gap.from_s)));
        entries.push(entry("to_s", format!("{:?}", gap.to_s)));
    }
    entries.into_iter().collect()
}

fn seconds(log_time_ns: u64) -> f64 {
    log_time_ns as f64 * 1e-9
}

/// First pass: determines the recoverable messages and their gaps.
struct RecoverySurvey<'a> {
    channels: HashSet<u16>,
    /// Latest sequence number by channel, and number of gaps known at that message.
    latest: HashMap<u16, (u32, usize)>,
    /// Whether the next message is the first after damage.
    is_after_damage: bool,
    latest_ns: u64,
    /// Gaps of the source if it is itself a recovered log, by time.
    earlier_gaps: Vec<Gap>,
    /// Possible gaps after damage, without a known missing message so far: the first message after damage can be an
    /// event, on a channel that lacks none.
    unconfirmed: Vec<Gap>,
    /// Channel with messages in every chunk; it confirms or rejects possible gaps.
    sample_end_channel: Option<u16>,
    found: Recovery,
    check: ProgressCheck<'a>,
}

impl<'a> RecoverySurvey<'a> {
    fn new(check: ProgressCheck<'a>) -> Self {
        RecoverySurvey {
            channels: HashSet::new(),
            latest: HashMap::new(),
            is_after_damage: false,
            latest_ns: 0,
            earlier_gaps: Vec::new(),
            unconfirmed: Vec::new(),
            sample_end_channel: None,
            found: Recovery::default(),
            check,
        }
    }

    fn message(&mut self, message: &MessageRecord<'_>) {
        if !self.channels.contains(&message.channel) {
            self.found.unidentified += 1;
            return;
        }
        let last = self.latest.get(&message.channel);
        let (next, gaps) = last.map_or((0, 0), |(last, gaps)| (last.wrapping_add(1), *gaps));
        let skipped = message.sequence.saturating_sub(next);
        // Messages missing on an infrequent channel were lost in a gap that is already known.
        let is_sample_end = self.sample_end_channel == Some(message.channel);
        let is_known_gap = !is_sample_end && self.found.gaps.len() > gaps;
        let (from_s, to_s) = (seconds(self.latest_ns), seconds(message.log_time_ns));
        let known = self.earlier_gaps.iter().position(|gap| (gap.from_s, gap.to_s) == (from_s, to_s));
        let earlier_gap = known.map(|index| self.earlier_gaps.remove(index));
        if self.is_after_damage || earlier_gap.is_some() {
            self.unconfirmed.push(Gap { after_messages: self.found.messages, from_s, to_s });
        }
        self.is_after_damage = false;
        if skipped > 0 && !is_known_gap {
            self.found.gaps.append(&mut self.unconfirmed);
        } else if is_sample_end {
            self.unconfirmed.clear();
        }
        self.latest.insert(message.channel, (message.sequence, self.found.gaps.len()));
        self.found.missing += u64::from(skipped);
        self.found.messages += 1;
        self.latest_ns = self.latest_ns.max(message.log_time_ns);
        self.found.to_s = Some(seconds(self.latest_ns));
    }

    fn finish(self, reading: LogSummary) -> Recovery {
        Recovery { reading, ..self.found }
    }
}

impl LogSink for RecoverySurvey<'_> {
    fn mark_discontinuity(&mut self) -> Result<(), SinkError> {
        self.is_after_damage = true;
        Ok(())
    }

    fn record(&mut self, record: &Record<'_>) -> Result<(), SinkError> {
        match record {
            Record::Metadata { name: RECOVERED_NAME, entries } => self.earlier_gaps = gaps(entries),
            Record::Channel(channel) => {
                self.channels.insert(channel.id);
                if channel.topic == SAMPLE_END_TOPIC {
                    self.sample_end_channel = Some(channel.id);
                }
            }
            Record::Message(message) => {
                (self.check)(message.log_time_ns)?;
                self.message(message);
            }
            _ => {}
        }
        Ok(())
    }
}

/// Second pass: copies records to the new log.
struct LogCopy<'a, W: Write> {
    mcap: mcap::Writer<NoSeek<BufWriter<W>>>,
    name: &'a str,
    /// Entries about the recovery; `None` once written.
    entries: Option<BTreeMap<String, String>>,
    channels: HashSet<u16>,
    /// Uncompressed bytes in the open chunk.
    open_chunk_bytes: usize,
    latest_ns: u64,
    check: ProgressCheck<'a>,
}

impl<W: Write> LogCopy<'_, W> {
    fn write_record(&mut self, record: &Record<'_>) -> Result<(), McapError> {
        match record {
            // The new recovery record includes the earlier one.
            Record::Metadata { name: RECOVERED_NAME, .. } => {}
            Record::Metadata { name, entries } => {
                self.metadata(name, (*entries).clone())?;
                if *name == METADATA_NAME
                    && let Some(entries) = self.entries.take()
                {
                    self.metadata(RECOVERED_NAME, entries)?;
                }
            }
            Record::Attachment(found) => self.mcap.attach(&Attachment {
                log_time: found.log_time_ns,
                create_time: found.create_time_ns,
                name: found.name.to_string(),
                media_type: found.media_type.to_string(),
                data: Cow::Borrowed(found.data),
            })?,
            Record::Schema(found) => {
                self.mcap.add_schema_with_id(found.id, found.name, found.encoding, found.data)?;
            }
            Record::Channel(found) => {
                let (id, schema) = (found.id, found.schema);
                self.mcap.add_channel_with_id(id, schema, found.topic, found.encoding, &found.metadata)?;
                self.channels.insert(id);
            }
            Record::Message(found) => self.message(found)?,
        }
        Ok(())
    }

    fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> Result<(), McapError> {
        self.mcap.write_metadata(&mcap::write::Metadata { name: name.to_string(), metadata })
    }

    fn message(&mut self, found: &MessageRecord<'_>) -> Result<(), McapError> {
        let MessageRecord { channel, sequence, log_time_ns, publish_time_ns, data } = *found;
        if !self.channels.contains(&channel) {
            return Ok(());
        }
        // End chunks between samples, unless too many messages share one log time.
        let is_between_samples = log_time_ns != self.latest_ns && self.open_chunk_bytes >= CHUNK_BYTES;
        if is_between_samples || self.open_chunk_bytes >= 16 * CHUNK_BYTES {
            self.mcap.flush()?;
            self.open_chunk_bytes = 0;
        }
        self.latest_ns = log_time_ns;
        let header =
            MessageHeader { channel_id: channel, sequence, log_time: log_time_ns, publish_time: publish_time_ns };
        self.mcap.write_to_known_channel(&header, data)?;
        self.open_chunk_bytes += RECORD_OVERHEAD + data.len();
        Ok(())
    }
}

impl<W: Write> LogSink for LogCopy<'_, W> {
    fn record(&mut self, record: &Record<'_>) -> Result<(), SinkError> {
        if let Record::Message(message) = record {
            (self.check)(message.log_time_ns)?;
        }
        self.write_record(record).map_err(|error| sink_error(self.name, error))
    }
}
