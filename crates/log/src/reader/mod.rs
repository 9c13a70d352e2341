//! Reading a log back, as far as it goes, whatever has happened to it.
//!
//! A [`Sink`] gets the samples and events of the log in order of time, up to the first byte that is missing or wrong: of a log in the
//! order in which it was written, that is always a prefix of what was written. What was lost is said, and what lies behind the damage is
//! counted; so is what the log of such a run has besides ([`Missing`]).
//!
//! The order of messages in the file says nothing (the specification of MCAP leaves it open): a first pass finds where messages are, the
//! second takes them in order of log time, and puts together those of one log time whatever their order.
//!
//! Nothing in the file is trusted: chunks and attachments must match their checksums before anything of them is used,
//! lengths are compared with what is there, and nothing larger than [`LARGEST_RECORD`] is held at once, unless chunks overlap in
//! time. So a log of any length needs no more memory than a chunk, and a few bytes for each chunk.
//!
//! | file | job |
//! |---|---|
//! | `bytes` | records of an MCAP file |
//! | `reading` | what was found, what is lost |
//! | `record` | those records, and who takes them |
//! | `wire` | messages of protobuf |
//! | `survey` | the first pass: what is announced, where messages are |
//! | `merge` | messages in order of log time |
//! | `channels` | what a channel carries |
//! | `group` | samples and events of the messages of one log time |
//! | `assemble` | messages → samples and events |
//! | `missing` | what the log lacks |
//! | `behind` | chunks that can still be read behind a damage |
//!
//! The framing of the file, its end, and the checksums of its sections are left to the `mcap` crate; its parser of single
//! records is not used, because it panics on attachments shorter than their checksum.

mod assemble;
mod behind;
mod bytes;
mod channels;
mod group;
mod merge;
mod missing;
mod reading;
mod record;
mod survey;
mod wire;

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use mcap::records::op;

use self::assemble::{Assembler, Found};
pub use self::behind::Behind;
pub use self::bytes::LARGEST_RECORD;
use self::bytes::Malformed;
pub(super) use self::bytes::{channel, message, metadata, schema};
use self::channels::{Channels, part};
use self::merge::{Taken, merge};
use self::missing::{expected, repeats};
use self::reading::kind;
pub use self::reading::{Concerns, Ended, Loss, Missing, ReadError, Reading};
use self::record::Fingers;
pub use self::record::{AttachmentRecord, ChannelRecord, LogSink, MessageRecord, Record, SchemaRecord};
use self::survey::{End, Segment, Survey, listed};
use super::channels::{Topics, topics};
use super::file::partial_name;
use phalanx_core::scene::words::SceneKind;
use phalanx_core::scene::{System, parse_any};
use phalanx_core::trace::{Layout, Sink, SinkError};

/// Reads the log file of a finger into a sink.
///
/// # Errors
/// [`ReadError`] if it is not a log of phalanx or cannot be read, or if the sink refuses. A log that is cut short or
/// damaged is no error: [`Reading::losses`] says so.
pub fn read_file(path: &Path, sink: &mut impl Sink) -> Result<Reading, ReadError> {
    read(open_log(path)?, sink)
}

/// Reads a log file of any kind, see [`read_file`].
pub fn read_any_file(path: &Path, sink: &mut impl LogSink) -> Result<Reading, ReadError> {
    read_any(open_log(path)?, sink)
}

/// Opens a log file for reading.
pub fn open_log(path: &Path) -> Result<BufReader<File>, ReadError> {
    let not_a_file = |what| ReadError::NotAFile { path: path.to_path_buf(), what };
    match std::fs::metadata(path) {
        Ok(found) if found.is_dir() => return Err(not_a_file("a directory")),
        Ok(found) if !found.is_file() => return Err(not_a_file("not a regular file")),
        Ok(_) => {}
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let partial = partial_name(path);
            let hint = match partial.exists() {
                true => {
                    format!(", but there is {}, the log of a run that has not finished: name that", partial.display())
                }
                false => "; check the path".to_string(),
            };
            return Err(ReadError::Missing { path: path.to_path_buf(), hint });
        }
        Err(error) => return Err(error.into()),
    }
    Ok(BufReader::with_capacity(1 << 16, File::open(path)?))
}

/// Reads of a log file only metadata and scene. Nothing is said of losses.
///
/// # Errors
/// As [`read_file`].
pub fn read_head(path: &Path) -> Result<Reading, ReadError> {
    go_through(open_log(path)?, &mut (), Extent::Head)
}

/// Reads the log of one finger into a sink, see [`read_file`].
pub fn read(source: impl Read + Seek, sink: &mut impl Sink) -> Result<Reading, ReadError> {
    read_any(source, &mut Fingers { sink, are_there: true })
}

/// Reads a log of any kind into a sink, see [`read_file`].
pub fn read_any(source: impl Read + Seek, sink: &mut impl LogSink) -> Result<Reading, ReadError> {
    go_through(source, sink, Extent::Prefix)
}

/// Reads a log as [`read_any`] does, and goes on with the whole chunks behind a damage: what is missing in between is for
/// the sink to see, from times and sequence numbers.
pub fn read_pieces(source: impl Read + Seek, sink: &mut impl LogSink) -> Result<Reading, ReadError> {
    go_through(source, sink, Extent::Pieces)
}

/// How much of a log is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Extent {
    /// Metadata and scene.
    Head,
    /// Up to the first thing that is missing or wrong.
    Prefix,
    /// And whole chunks behind that.
    Pieces,
}

fn go_through(mut source: impl Read + Seek, sink: &mut impl LogSink, extent: Extent) -> Result<Reading, ReadError> {
    let bytes = source.seek(SeekFrom::End(0))?;
    source.rewind()?;
    let mut head = Vec::with_capacity(mcap::MAGIC.len());
    source.by_ref().take(mcap::MAGIC.len() as u64).read_to_end(&mut head)?;
    if !mcap::MAGIC.starts_with(&head) || bytes == 0 {
        return Err(ReadError::NotMcap);
    }
    source.rewind()?;
    let mut survey = Survey::new(bytes);
    let (at_byte, end) = survey.records(&mut source, sink, extent == Extent::Head)?;
    if !survey.identified {
        return Err(if matches!(end, End::Cut) { ReadError::Empty { bytes } } else { ReadError::NotPhalanx });
    }
    if extent == Extent::Head {
        return Ok(survey.reading);
    }
    let mut lost = match end {
        End::Whole => None,
        end => Some((at_byte, end, pieces(&mut source, &mut survey, at_byte, extent)?)),
    };
    let mut reader = Reader::new(sink, &mut survey)?;
    let mut left = None;
    merge(&mut source, &survey.segments, |segment, body| {
        reader.enter(segment)?;
        Ok(match reader.message(body)? {
            Ok(()) => Taken::Next,
            Err(malformed) => {
                left.get_or_insert((segment.at, malformed));
                reader.piece_of = None;
                if extent == Extent::Pieces { Taken::LeaveSegment } else { Taken::Stop }
            }
        })
    })?;
    if left.is_none()
        && let Err(malformed) = reader.end()?
    {
        left = survey.segments.last().map(|segment| (segment.at, malformed));
    }
    if let Some((at_byte, malformed)) = left {
        let behind = behind::search(&mut source, at_byte + 1, bytes, |_, _, _| Ok::<_, ReadError>(true))?;
        let used = extent == Extent::Pieces && behind.chunks > 0;
        lost = Some((at_byte, End::Wrong(malformed.to_string()), Behind { used, ..behind }));
    }
    let last_s = reader.reading.last_s;
    let loss = lost.and_then(|(at_byte, end, behind)| {
        Some(match end {
            // A record that reaches beyond the end is a cut, unless there is more behind its beginning.
            End::Cut if behind.chunks == 0 => Loss::Truncated { at_byte, bytes, last_s },
            End::Cut => {
                let reason = "a record claims more bytes than the file has".to_string();
                Loss::Damaged { at_byte, bytes, reason, last_s, behind }
            }
            End::Wrong(reason) => Loss::Damaged { at_byte, bytes, reason, last_s, behind },
            End::Compressed(compression) => Loss::Compressed { at_byte, bytes, compression, last_s, behind },
            End::Whole => return None,
        })
    });
    reader.reading.losses.extend(loss);
    Ok(reader.finish(&survey))
}

/// What lies behind a damage; where pieces are read, the survey takes them up.
fn pieces(
    source: &mut (impl Read + Seek),
    survey: &mut Survey,
    at_byte: u64,
    extent: Extent,
) -> Result<Behind, ReadError> {
    let bytes = survey.reading.bytes;
    if extent != Extent::Pieces {
        return behind::search(source, at_byte + 1, bytes, |_, _, _| Ok(true));
    }
    if survey.reading.chunks == 0 {
        survey.names_from_index(source)?;
    }
    let listed = listed(source, bytes)?;
    let behind = behind::search(source, at_byte + 1, bytes, |at, chunk, records| {
        Ok::<_, ReadError>(survey.piece(at, chunk, records, &listed))
    })?;
    Ok(Behind { used: behind.chunks > 0, ..behind })
}

/// The second pass.
struct Reader<'a, S> {
    sink: &'a mut S,
    assembler: Assembler,
    expected: Vec<(String, channels::Carries)>,
    /// The sink knows what samples consist of.
    named: bool,
    /// Where the segment begins whose messages follow those before without a gap, as far as is known.
    piece_of: Option<u64>,
    reading: Reading,
}

impl<'a, S: LogSink> Reader<'a, S> {
    /// Takes what the survey has read, and announces schemas and channels to the sink.
    fn new(sink: &'a mut S, survey: &mut Survey) -> Result<Self, ReadError> {
        let mut reading = std::mem::take(&mut survey.reading);
        let kind = kind(&reading.metadata);
        let scene = reading.scene.as_ref().filter(|(_, text)| text.len() < LARGEST_RECORD);
        let scene = scene.and_then(|(name, text)| parse_any(text, name).ok()).filter(|scene| scene.kind() == kind);
        let system = scene.as_ref().map(|scene| &scene.system);
        let mut channels = Channels::new(kind, layout(kind, system));
        for (opcode, data) in &survey.announced {
            if *opcode == op::SCHEMA
                && let Ok(schema) = bytes::schema(data)
            {
                channels.schema(&schema);
                sink.record(&Record::Schema(schema))?;
            } else if let Ok(channel) = bytes::channel(data) {
                reading.unknown_channels += u64::from(channels.channel(&channel));
                sink.record(&Record::Channel(channel))?;
            }
        }
        let topics = system.map(|system| in_layout(topics(system), kind, channels.layout()));
        let expected = expected(kind, topics.as_ref());
        let has_messages = |(id, ..): &&(u16, String, channels::Carries)| survey.numbers.contains_key(id);
        let with_messages = channels.topics().iter().filter(has_messages);
        let mut parts: Vec<usize> =
            with_messages.filter_map(|(.., carries)| part(channels.layout(), *carries)).collect();
        parts.sort_unstable();
        parts.dedup();
        let wanted: Vec<usize> = expected.iter().filter_map(|(_, carries)| part(channels.layout(), *carries)).collect();
        let of_engine = reading.metadata.get("model").is_some_and(|model| model == "engine");
        let assembler = Assembler::new(channels, of_engine, parts, &wanted, repeats(&survey.numbers));
        Ok(Reader { sink, assembler, expected, named: false, piece_of: Some(0), reading })
    }

    /// A message of this segment follows: behind a damage something may be missing before it.
    fn enter(&mut self, segment: &Segment) -> Result<(), SinkError> {
        let goes_on = self.piece_of.is_some_and(|at| at == segment.at || !segment.behind);
        self.piece_of = Some(segment.at);
        if goes_on { Ok(()) } else { self.sink.piece() }
    }

    /// The body of a message.
    fn message(&mut self, body: &[u8]) -> Result<Result<(), Malformed>, ReadError> {
        let message = match bytes::message(body) {
            Ok(message) => message,
            Err(malformed) => return Ok(Err(malformed)),
        };
        self.reading.messages += 1;
        self.sink.record(&Record::Message(message))?;
        self.name()?;
        let Reader { sink, assembler, reading, .. } = self;
        Ok(assembler.message(&message, &mut |found: Found<'_>| take(*sink, reading, found))?)
    }

    /// Once all messages have come.
    fn end(&mut self) -> Result<Result<(), Malformed>, ReadError> {
        let Reader { sink, assembler, reading, .. } = self;
        Ok(assembler.end(&mut |found: Found<'_>| take(*sink, reading, found))?)
    }

    /// The sink hears what samples consist of, once.
    fn name(&mut self) -> Result<(), SinkError> {
        match std::mem::replace(&mut self.named, true) {
            true => Ok(()),
            false => self.sink.layout(self.assembler.layout()),
        }
    }

    /// What was read, with what is missing in it.
    fn finish(self, survey: &Survey) -> Reading {
        let Reader { mut assembler, expected, mut reading, .. } = self;
        reading.missing = assembler.missing(&reading, &expected, &survey.numbers);
        reading
    }
}

/// What is found goes to the sink, and is counted.
fn take(sink: &mut impl LogSink, reading: &mut Reading, found: Found<'_>) -> Result<(), SinkError> {
    match found {
        Found::Unknown => reading.unknown_messages += 1,
        Found::Ended(ended) => reading.ended = Some(ended),
        Found::Event(event) => {
            reading.events += 1;
            sink.event(&event)?;
        }
        Found::Sample(sample) => {
            sink.sample(sample)?;
            reading.samples += 1;
            reading.first_s.get_or_insert(sample.time_s);
            reading.last_s = Some(sample.time_s);
        }
    }
    Ok(())
}

/// What the samples of a scene consist of in its log, which names no contact that nothing can touch. What discs there are only a scene
/// says, or else the channels.
fn layout(kind: SceneKind, system: Option<&System>) -> Layout {
    let Some(system) = system.filter(|_| kind == SceneKind::Bodies) else { return Layout::of_kind(kind) };
    let all = Layout::of(system);
    let touched = topics(system).contacts.into_iter().map(|of| of.is_some());
    let contacts = all.contacts.into_iter().zip(touched).filter(|(_, touched)| *touched).map(|(place, _)| place);
    Layout { contacts: contacts.collect(), ..all }
}

/// The topics of a scene in the order of that layout.
fn in_layout(mut topics: Topics, kind: SceneKind, layout: &Layout) -> Topics {
    if kind == SceneKind::Bodies {
        topics.contacts.retain(Option::is_some);
    }
    topics.fingers.truncate(layout.fingers.len());
    topics.bodies.truncate(layout.bodies.len());
    topics.contacts.truncate(layout.contacts.len());
    topics
}
