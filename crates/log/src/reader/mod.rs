//! Reader of intact and damaged logs.
//!
//! A [`Sink`] receives the samples and events of the log in order of time, up to the first missing or invalid byte. If
//! the log is in write order, this is a prefix of what was written. The summary reports what was lost, counts what is
//! intact after the damage, and lists data that a log of such a run should contain but does not ([`MissingData`]).
//!
//! The order of messages in the file has no meaning (the MCAP specification leaves it open): the first pass locates
//! messages, the second reads them in order of log time and reconstructs the order within one log time.
//!
//! The file is not trusted: chunks and attachments must match their checksums before use, lengths are compared with the
//! available data, and at most [`MAX_RECORD_BYTES`] are loaded at once unless chunks overlap in time. The reader
//! therefore needs memory for one chunk plus a few bytes per chunk, for a log of any length.
//!
//! | file | job |
//! |---|---|
//! | `bytes` | records of an MCAP file |
//! | `summary` | contents and losses of a log, errors |
//! | `record` | records of a log, and sinks for them |
//! | `wire` | protobuf messages |
//! | `survey` | first pass: schemas, channels and positions of messages |
//! | `merge` | messages in order of log time |
//! | `channels` | content of a channel |
//! | `grouping` | samples and events of the messages of one log time |
//! | `assemble` | messages → samples and events |
//! | `missing` | data missing in the log |
//! | `chunk_search` | intact chunks after damage |
//!
//! The `mcap` crate handles the framing and end of the file and the checksums of its sections. Its record parser is not
//! used because it panics on attachments shorter than their checksum.

mod assemble;
mod bytes;
mod channels;
mod chunk_search;
mod grouping;
mod merge;
mod missing;
mod record;
mod summary;
mod survey;
mod wire;

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use mcap::records::op;

use self::assemble::{Assembler, Decoded};
pub use self::bytes::MAX_RECORD_BYTES;
use self::bytes::MalformedData;
pub(super) use self::bytes::{channel, message, metadata, schema};
use self::channels::{Channels, component_index};
pub use self::chunk_search::IntactChunks;
use self::merge::{MergeControl, merge};
use self::missing::{expected_topics, has_duplicates};
use self::record::SingleFingerSink;
pub use self::record::{AttachmentRecord, ChannelRecord, LogSink, MessageRecord, Record, SchemaRecord};
use self::summary::kind;
pub use self::summary::{LogSummary, Loss, MissingData, ReadError, RunEnd, TopicSubject};
use self::survey::{ScanEnd, Segment, Survey, indexed_chunk_offsets};
use super::channels::{Topics, topics};
use super::file::partial_name;
use phalanx_core::scene::keywords::SceneKind;
use phalanx_core::scene::{System, parse_any};
use phalanx_core::trace::{Layout, Sink, SinkError};

/// Reads the log file of a finger into a sink.
///
/// # Errors
/// Returns [`ReadError`] if the file is not a log of phalanx or cannot be read, or if the sink fails. A truncated or
/// damaged log is not an error: see [`LogSummary::losses`].
pub fn read_file(path: &Path, sink: &mut impl Sink) -> Result<LogSummary, ReadError> {
    read(open_log(path)?, sink)
}

/// Reads a log file of any kind, see [`read_file`].
pub fn read_any_file(path: &Path, sink: &mut impl LogSink) -> Result<LogSummary, ReadError> {
    read_any(open_log(path)?, sink)
}

/// Opens a log file for reading.
pub fn open_log(path: &Path) -> Result<BufReader<File>, ReadError> {
    let not_a_file = |description| ReadError::NotAFile { path: path.to_path_buf(), description };
    match std::fs::metadata(path) {
        Ok(found) if found.is_dir() => return Err(not_a_file("a directory")),
        Ok(found) if !found.is_file() => return Err(not_a_file("not a regular file")),
        Ok(_) => {}
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let partial = partial_name(path);
            let hint = match partial.exists() {
                true => {
                    format!(", but there is {}, the log of an unfinished run; give that path", partial.display())
                }
                false => "; check the path".to_string(),
            };
            return Err(ReadError::NotFound { path: path.to_path_buf(), hint });
        }
        Err(error) => return Err(error.into()),
    }
    Ok(BufReader::with_capacity(1 << 16, File::open(path)?))
}

/// Reads only metadata and scene of a log file. Losses are not reported.
///
/// # Errors
/// See [`read_file`].
pub fn read_head(path: &Path) -> Result<LogSummary, ReadError> {
    read_log(open_log(path)?, &mut (), ReadExtent::Head)
}

/// Reads the log of one finger into a sink, see [`read_file`].
pub fn read(source: impl Read + Seek, sink: &mut impl Sink) -> Result<LogSummary, ReadError> {
    read_any(source, &mut SingleFingerSink { sink, is_single_finger: true })
}

/// Reads a log of any kind into a sink, see [`read_file`].
pub fn read_any(source: impl Read + Seek, sink: &mut impl LogSink) -> Result<LogSummary, ReadError> {
    read_log(source, sink, ReadExtent::UpToDamage)
}

/// Reads a log like [`read_any`], and continues with the intact chunks after damage. The sink can detect what is
/// missing in between from times and sequence numbers.
pub fn read_past_damage(source: impl Read + Seek, sink: &mut impl LogSink) -> Result<LogSummary, ReadError> {
    read_log(source, sink, ReadExtent::PastDamage)
}

/// Part of a log to read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ReadExtent {
    /// The metadata and the scene.
    Head,
    /// The log up to the first missing or invalid byte.
    UpToDamage,
    /// The whole log, including intact chunks after damage.
    PastDamage,
}

fn read_log(
    mut source: impl Read + Seek,
    sink: &mut impl LogSink,
    extent: ReadExtent,
) -> Result<LogSummary, ReadError> {
    let bytes = source.seek(SeekFrom::End(0))?;
    source.rewind()?;
    let mut head = Vec::with_capacity(mcap::MAGIC.len());
    source.by_ref().take(mcap::MAGIC.len() as u64).read_to_end(&mut head)?;
    if !mcap::MAGIC.starts_with(&head) || bytes == 0 {
        return Err(ReadError::NotMcap);
    }
    source.rewind()?;
    let mut survey = Survey::new(bytes);
    let (at_byte, end) = survey.records(&mut source, sink, extent == ReadExtent::Head)?;
    if !survey.is_phalanx_log {
        return Err(if matches!(end, ScanEnd::Truncated) { ReadError::Empty { bytes } } else { ReadError::NotPhalanx });
    }
    if extent == ReadExtent::Head {
        return Ok(survey.summary);
    }
    let mut damage = match end {
        ScanEnd::Complete => None,
        end => Some((at_byte, end, find_chunks_after_damage(&mut source, &mut survey, at_byte, extent)?)),
    };
    let mut reader = Reader::new(sink, &mut survey)?;
    let mut invalid_message = None;
    merge(&mut source, &survey.segments, |segment, body| {
        reader.enter_segment(segment)?;
        Ok(match reader.message(body)? {
            Ok(()) => MergeControl::Continue,
            Err(malformed) => {
                invalid_message.get_or_insert((segment.offset, malformed));
                reader.contiguous_from = None;
                if extent == ReadExtent::PastDamage { MergeControl::SkipSegment } else { MergeControl::Stop }
            }
        })
    })?;
    if invalid_message.is_none()
        && let Err(malformed) = reader.end()?
    {
        invalid_message = survey.segments.last().map(|segment| (segment.offset, malformed));
    }
    if let Some((at_byte, malformed)) = invalid_message {
        let intact =
            chunk_search::find_intact_chunks(&mut source, at_byte + 1, bytes, |_, _, _| Ok::<_, ReadError>(true))?;
        let used = extent == ReadExtent::PastDamage && intact.chunks > 0;
        damage = Some((at_byte, ScanEnd::Damaged(malformed.to_string()), IntactChunks { used, ..intact }));
    }
    let last_s = reader.summary.last_s;
    let loss = damage.and_then(|(at_byte, end, intact)| {
        Some(match end {
            // A record that extends beyond the end of the file is a truncation, unless intact chunks follow its start.
            ScanEnd::Truncated if intact.chunks == 0 => Loss::Truncated { at_byte, bytes, last_s },
            ScanEnd::Truncated => {
                let reason = "a record claims more bytes than the file has".to_string();
                Loss::Damaged { at_byte, bytes, reason, last_s, intact }
            }
            ScanEnd::Damaged(reason) => Loss::Damaged { at_byte, bytes, reason, last_s, intact },
            ScanEnd::UnsupportedCompression(compression) => {
                Loss::UnsupportedCompression { at_byte, bytes, compression, last_s, intact }
            }
            ScanEnd::Complete => return None,
        })
    });
    reader.summary.losses.extend(loss);
    Ok(reader.finish(&survey))
}

/// Finds intact chunks after damage; with [`ReadExtent::PastDamage`] they are added to the survey.
fn find_chunks_after_damage(
    source: &mut (impl Read + Seek),
    survey: &mut Survey,
    at_byte: u64,
    extent: ReadExtent,
) -> Result<IntactChunks, ReadError> {
    let bytes = survey.summary.bytes;
    if extent != ReadExtent::PastDamage {
        return chunk_search::find_intact_chunks(source, at_byte + 1, bytes, |_, _, _| Ok(true));
    }
    if survey.summary.chunks == 0 {
        survey.read_definitions_from_index(source)?;
    }
    let indexed_offsets = indexed_chunk_offsets(source, bytes)?;
    let intact = chunk_search::find_intact_chunks(source, at_byte + 1, bytes, |offset, chunk, records| {
        Ok::<_, ReadError>(survey.add_chunk_after_damage(offset, chunk, records, &indexed_offsets))
    })?;
    Ok(IntactChunks { used: intact.chunks > 0, ..intact })
}

/// Second pass over a log.
struct Reader<'a, S> {
    sink: &'a mut S,
    assembler: Assembler,
    expected_topics: Vec<(String, channels::ChannelContent)>,
    /// Whether the sink has received the layout.
    is_layout_sent: bool,
    /// Start of the latest segment; `None` after an invalid message.
    contiguous_from: Option<u64>,
    summary: LogSummary,
}

impl<'a, S: LogSink> Reader<'a, S> {
    /// Takes over the results of the survey and passes schemas and channels to the sink.
    fn new(sink: &'a mut S, survey: &mut Survey) -> Result<Self, ReadError> {
        let mut summary = std::mem::take(&mut survey.summary);
        let kind = kind(&summary.metadata);
        let scene = summary.scene.as_ref().filter(|(_, text)| text.len() < MAX_RECORD_BYTES);
        let scene = scene.and_then(|(name, text)| parse_any(text, name).ok()).filter(|scene| scene.kind() == kind);
        let system = scene.as_ref().map(|scene| &scene.system);
        let mut channels = Channels::new(kind, log_layout(kind, system));
        for (opcode, data) in &survey.definitions {
            if *opcode == op::SCHEMA
                && let Ok(schema) = bytes::schema(data)
            {
                channels.schema(&schema);
                sink.record(&Record::Schema(schema))?;
            } else if let Ok(channel) = bytes::channel(data) {
                summary.unknown_channels += u64::from(channels.channel(&channel));
                sink.record(&Record::Channel(channel))?;
            }
        }
        let topics = system.map(|system| restrict_topics(topics(system), kind, channels.layout()));
        let expected_topics = expected_topics(kind, topics.as_ref());
        let has_messages = |(id, ..): &&(u16, String, channels::ChannelContent)| survey.sequence_stats.contains_key(id);
        let channels_with_messages = channels.topics().iter().filter(has_messages);
        let mut components: Vec<usize> =
            channels_with_messages.filter_map(|(.., content)| component_index(channels.layout(), *content)).collect();
        components.sort_unstable();
        components.dedup();
        let required: Vec<usize> =
            expected_topics.iter().filter_map(|(_, content)| component_index(channels.layout(), *content)).collect();
        let is_engine = summary.metadata.get("model").is_some_and(|model| model == "engine");
        let assembler =
            Assembler::new(channels, is_engine, components, &required, has_duplicates(&survey.sequence_stats));
        Ok(Reader { sink, assembler, expected_topics, is_layout_sent: false, contiguous_from: Some(0), summary })
    }

    /// Called before a message of this segment. After damage, messages before it may be missing.
    fn enter_segment(&mut self, segment: &Segment) -> Result<(), SinkError> {
        let is_contiguous =
            self.contiguous_from.is_some_and(|offset| offset == segment.offset || !segment.is_after_damage);
        self.contiguous_from = Some(segment.offset);
        if is_contiguous { Ok(()) } else { self.sink.mark_discontinuity() }
    }

    /// Decodes the body of a message record.
    fn message(&mut self, body: &[u8]) -> Result<Result<(), MalformedData>, ReadError> {
        let message = match bytes::message(body) {
            Ok(message) => message,
            Err(malformed) => return Ok(Err(malformed)),
        };
        self.summary.messages += 1;
        self.sink.record(&Record::Message(message))?;
        self.send_layout()?;
        let Reader { sink, assembler, summary, .. } = self;
        Ok(assembler.message(&message, &mut |found: Decoded<'_>| deliver(*sink, summary, found))?)
    }

    /// Called after the last message.
    fn end(&mut self) -> Result<Result<(), MalformedData>, ReadError> {
        let Reader { sink, assembler, summary, .. } = self;
        Ok(assembler.end(&mut |found: Decoded<'_>| deliver(*sink, summary, found))?)
    }

    /// Passes the layout to the sink, once.
    fn send_layout(&mut self) -> Result<(), SinkError> {
        match std::mem::replace(&mut self.is_layout_sent, true) {
            true => Ok(()),
            false => self.sink.layout(self.assembler.layout()),
        }
    }

    /// Returns the summary, including missing data.
    fn finish(self, survey: &Survey) -> LogSummary {
        let Reader { mut assembler, expected_topics, mut summary, .. } = self;
        summary.missing = assembler.missing(&summary, &expected_topics, &survey.sequence_stats);
        summary
    }
}

/// Passes a decoded item to the sink and counts it.
fn deliver(sink: &mut impl LogSink, summary: &mut LogSummary, found: Decoded<'_>) -> Result<(), SinkError> {
    match found {
        Decoded::UnknownMessage => summary.unknown_messages += 1,
        Decoded::RunEnd(run_end) => summary.run_end = Some(run_end),
        Decoded::Event(event) => {
            summary.events += 1;
            sink.event(&event)?;
        }
        Decoded::Sample(sample) => {
            sink.sample(sample)?;
            summary.samples += 1;
            summary.first_s.get_or_insert(sample.time_s);
            summary.last_s = Some(sample.time_s);
        }
    }
    Ok(())
}

/// Returns the layout of the samples in a log. It omits contacts that the scene does not have. The discs come from the
/// scene or, without one, from the channels.
fn log_layout(kind: SceneKind, system: Option<&System>) -> Layout {
    let Some(system) = system.filter(|_| kind == SceneKind::Bodies) else { return Layout::from_kind(kind) };
    let full_layout = Layout::from_system(system);
    let is_present = topics(system).contacts.into_iter().map(|contact| contact.is_some());
    let contacts = full_layout
        .contacts
        .into_iter()
        .zip(is_present)
        .filter(|(_, is_present)| *is_present)
        .map(|(contact, _)| contact);
    Layout { contacts: contacts.collect(), ..full_layout }
}

/// Restricts the topics of a scene to a layout.
fn restrict_topics(mut topics: Topics, kind: SceneKind, layout: &Layout) -> Topics {
    if kind == SceneKind::Bodies {
        topics.contacts.retain(Option::is_some);
    }
    topics.fingers.truncate(layout.fingers.len());
    topics.bodies.truncate(layout.bodies.len());
    topics.contacts.truncate(layout.contacts.len());
    topics
}
