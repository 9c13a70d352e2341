//! The good part of a damaged log as a log of its own: whole, indexed, and honest about what is missing.
//!
//! Metadata, attachment, schemas, channels and messages are those of the source, in its order, byte for byte, under the
//! same ids; nothing is made up. Whole chunks behind a damage are kept too: their messages carry sequence numbers, which
//! say exactly what is missing before them. A metadata record [`RECOVERED_NAME`] says what the log was made from:
//!
//! | entry | |
//! |---|---|
//! | `source`, `source_bytes` | name of the damaged log, without directories, and its size |
//! | `lost` | what was lost of it, in words |
//! | `messages` | messages kept |
//! | `gaps` | places in which messages are missing, not counting the end |
//! | `gap_1_after_messages`, `gap_1_from_s`, `gap_1_to_s`, … | messages before it, log times around it |
//! | `missing_messages` | messages missing before others of their channels that are there |
//! | `phalanx_version` | what recovered it |

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::{BufWriter, Read, Seek, Write};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Attachment, McapError};

use super::core::{CHUNK_BYTES, RECORD_OVERHEAD, options};
use super::metadata::METADATA_NAME;
use super::metadata::RECOVERED_NAME;
use super::reader::{LogSink, MessageRecord, ReadError, Reading, Record, read_pieces};
use super::writer::sink_error;
use phalanx_core::trace::SinkError;

/// The last message of every sample, of fingers and of discs.
const REGULAR: &str = "/energy";

/// A place where messages are missing.
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// Messages of the recovered log before it.
    pub after_messages: u64,
    /// Log times of the messages around it.
    pub from_s: f64,
    pub to_s: f64,
}

/// What was recovered.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recovery {
    /// The damaged log.
    pub reading: Reading,
    /// Messages kept, and messages of channels that are not known because the part that named them is lost.
    pub messages: u64,
    pub nameless: u64,
    pub gaps: Vec<Gap>,
    /// Messages missing before others of their channels.
    pub missing: u64,
    /// Log time of the last message.
    pub to_s: Option<f64>,
}

/// Told the log time of every message, in ns; an error ends what is being done.
pub type Check<'a> = &'a dyn Fn(u64) -> Result<(), SinkError>;

/// Writes the good part of a log. `source_name` is what the log is called, without directories; `name` is what errors call
/// the new one.
///
/// # Errors
/// [`ReadError`] if the source is no log, or the new one cannot be written.
pub fn recover(
    source: &mut (impl Read + Seek),
    source_name: &str,
    out: impl Write,
    name: &str,
    check: Check<'_>,
) -> Result<Recovery, ReadError> {
    let mut survey = Survey::new(check);
    let reading = read_pieces(&mut *source, &mut survey)?;
    let recovery = survey.finish(reading);
    let entries = entries(&recovery, source_name);
    let named = |error| sink_error(name, error);
    let mcap = options().create(NoSeek::new(BufWriter::new(out))).map_err(named)?;
    let mut copy =
        Copy { mcap, name, entries: Some(entries), channels: HashSet::new(), pending: 0, latest_ns: 0, check };
    read_pieces(source, &mut copy)?;
    let mut mcap = copy.mcap;
    mcap.finish().map_err(named)?;
    let mut buffered = mcap.into_inner().into_inner();
    buffered.flush().map_err(|error| named(McapError::Io(error)))?;
    Ok(recovery)
}

/// The gaps that a recovered log speaks of.
pub fn gaps(entries: &BTreeMap<String, String>) -> Vec<Gap> {
    fn number<T: std::str::FromStr>(entries: &BTreeMap<String, String>, index: u64, what: &str) -> Option<T> {
        entries.get(&format!("gap_{index}_{what}"))?.parse().ok()
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
    let mut lost: Vec<String> = found.reading.losses.iter().map(ToString::to_string).collect();
    if found.missing > 0 {
        lost.push(format!("{} messages are missing before others that are there", found.missing));
    }
    if found.nameless > 0 {
        lost.push(format!("{} messages are left out, for what their channels are is lost", found.nameless));
    }
    if let Some(before) = found.reading.recovered.as_ref().and_then(|entries| entries.get("lost")) {
        lost.push(format!("it was a recovered log itself, of which was said: {before}"));
    }
    if lost.is_empty() {
        lost.push("nothing".to_string());
    }
    let mut entries = vec![
        ("source".to_string(), source_name.to_string()),
        ("source_bytes".to_string(), found.reading.bytes.to_string()),
        ("lost".to_string(), lost.join("; ")),
        ("messages".to_string(), found.messages.to_string()),
        ("missing_messages".to_string(), found.missing.to_string()),
        ("gaps".to_string(), found.gaps.len().to_string()),
        ("phalanx_version".to_string(), env!("CARGO_PKG_VERSION").to_string()),
    ];
    for (index, gap) in found.gaps.iter().enumerate() {
        let entry = |what: &str, value: String| (format!("gap_{}_{what}", index + 1), value);
        entries.push(entry("after_messages", gap.after_messages.to_string()));
        entries.push(entry("from_s", format!("{:?}", gap.from_s)));
        entries.push(entry("to_s", format!("{:?}", gap.to_s)));
    }
    entries.into_iter().collect()
}

fn seconds(log_time_ns: u64) -> f64 {
    log_time_ns as f64 * 1e-9
}

/// Finds what will be kept, and what is missing in it.
struct Survey<'a> {
    channels: HashSet<u16>,
    /// Latest sequence number by channel, and how many gaps were known at that message.
    latest: HashMap<u16, (u32, usize)>,
    /// What follows is behind a damage.
    behind: bool,
    latest_ns: u64,
    /// Gaps of a source that is a recovered log itself, in terms of time.
    before: Vec<Gap>,
    /// Places behind a damage at which no message is known to be missing yet: the first message there can be an event, of
    /// which none is missing.
    doubtful: Vec<Gap>,
    /// The channel that every chunk has messages of: it settles a doubt.
    regular: Option<u16>,
    found: Recovery,
    check: Check<'a>,
}

impl<'a> Survey<'a> {
    fn new(check: Check<'a>) -> Self {
        Survey {
            channels: HashSet::new(),
            latest: HashMap::new(),
            behind: false,
            latest_ns: 0,
            before: Vec::new(),
            doubtful: Vec::new(),
            regular: None,
            found: Recovery::default(),
            check,
        }
    }

    fn message(&mut self, message: &MessageRecord<'_>) {
        if !self.channels.contains(&message.channel) {
            self.found.nameless += 1;
            return;
        }
        let last = self.latest.get(&message.channel);
        let (next, gaps) = last.map_or((0, 0), |(last, gaps)| (last.wrapping_add(1), *gaps));
        let skipped = message.sequence.saturating_sub(next);
        // A channel that speaks seldom tells of a gap that is known already: what is missing of it was lost there.
        let is_regular = self.regular == Some(message.channel);
        let is_told = !is_regular && self.found.gaps.len() > gaps;
        let (from_s, to_s) = (seconds(self.latest_ns), seconds(message.log_time_ns));
        let known = self.before.iter().position(|gap| (gap.from_s, gap.to_s) == (from_s, to_s));
        let old = known.map(|index| self.before.remove(index));
        if self.behind || old.is_some() {
            self.doubtful.push(Gap { after_messages: self.found.messages, from_s, to_s });
        }
        self.behind = false;
        if skipped > 0 && !is_told {
            self.found.gaps.append(&mut self.doubtful);
        } else if is_regular {
            self.doubtful.clear();
        }
        self.latest.insert(message.channel, (message.sequence, self.found.gaps.len()));
        self.found.missing += u64::from(skipped);
        self.found.messages += 1;
        self.latest_ns = self.latest_ns.max(message.log_time_ns);
        self.found.to_s = Some(seconds(self.latest_ns));
    }

    fn finish(self, reading: Reading) -> Recovery {
        Recovery { reading, ..self.found }
    }
}

impl LogSink for Survey<'_> {
    fn piece(&mut self) -> Result<(), SinkError> {
        self.behind = true;
        Ok(())
    }

    fn record(&mut self, record: &Record<'_>) -> Result<(), SinkError> {
        match record {
            Record::Metadata { name: RECOVERED_NAME, entries } => self.before = gaps(entries),
            Record::Channel(channel) => {
                self.channels.insert(channel.id);
                if channel.topic == REGULAR {
                    self.regular = Some(channel.id);
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

/// Writes what it is given.
struct Copy<'a, W: Write> {
    mcap: mcap::Writer<NoSeek<BufWriter<W>>>,
    name: &'a str,
    /// What is said of the recovery, until it is written.
    entries: Option<BTreeMap<String, String>>,
    channels: HashSet<u16>,
    /// Uncompressed bytes in the open chunk.
    pending: usize,
    latest_ns: u64,
    check: Check<'a>,
}

impl<W: Write> Copy<'_, W> {
    fn put(&mut self, record: &Record<'_>) -> Result<(), McapError> {
        match record {
            // What is said of an earlier recovery is part of what is said of this one.
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
        // Between samples, as a log is written; unless everything claims to be of one time.
        let between = log_time_ns != self.latest_ns && self.pending >= CHUNK_BYTES;
        if between || self.pending >= 16 * CHUNK_BYTES {
            self.mcap.flush()?;
            self.pending = 0;
        }
        self.latest_ns = log_time_ns;
        let header =
            MessageHeader { channel_id: channel, sequence, log_time: log_time_ns, publish_time: publish_time_ns };
        self.mcap.write_to_known_channel(&header, data)?;
        self.pending += RECORD_OVERHEAD + data.len();
        Ok(())
    }
}

impl<W: Write> LogSink for Copy<'_, W> {
    fn record(&mut self, record: &Record<'_>) -> Result<(), SinkError> {
        if let Record::Message(message) = record {
            (self.check)(message.log_time_ns)?;
        }
        self.put(record).map_err(|error| sink_error(self.name, error))
    }
}
