//! Reading a log back, as far as it goes, whatever has happened to it.
//!
//! A [`Sink`] gets the samples and events of the log in its order, up to the first byte that is missing or wrong: what it
//! gets is always a prefix of what was written. What was lost is said, and what lies behind the damage is counted.
//!
//! Nothing in the file is trusted: chunks and attachments must match their checksums before anything of them is used,
//! lengths are compared with what is there, and nothing larger than [`LARGEST_RECORD`] is ever held. So a log of any
//! length needs no more memory than a chunk.
//!
//! | file | job |
//! |---|---|
//! | `bytes` | records of an MCAP file |
//! | `reading` | what was found, what is lost |
//! | `record` | those records, and who takes them |
//! | `wire` | messages of protobuf |
//! | `channels` | what a channel carries |
//! | `assemble` | messages → samples and events |
//! | `behind` | chunks that can still be read behind a damage |
//!
//! The framing of the file, its end, and the checksums of its sections are left to the `mcap` crate; its parser of single
//! records is not used, because it panics on attachments shorter than their checksum.

mod assemble;
mod behind;
mod bytes;
mod channels;
mod reading;
mod record;
mod wire;

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use self::assemble::{Assembler, Found};
pub use self::behind::Behind;
pub use self::bytes::LARGEST_RECORD;
use self::bytes::{Chunk, Cursor, Malformed};
pub(super) use self::bytes::{channel, message, metadata, schema};
use self::reading::kind;
pub use self::reading::{Ended, Loss, ReadError, Reading};
use self::record::Fingers;
pub use self::record::{AttachmentRecord, ChannelRecord, LogSink, MessageRecord, Record, SchemaRecord};
use super::file::partial_name;
use super::metadata::RECOVERED_NAME;
use super::metadata::{ATTACHMENT_MEDIA_TYPE, METADATA_NAME};
use phalanx_core::scene::words::SceneKind;
use phalanx_core::trace::{Sink, SinkError};

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

/// Reads of a log file only what comes before its first chunk: metadata and scene. Nothing is said of losses.
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
    /// What comes before the first chunk.
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
    let mut reader = Reader {
        sink,
        assembler: Assembler::new(SceneKind::Finger),
        room: Vec::new(),
        identified: false,
        named: false,
        head_only: extent == Extent::Head,
        latest_ns: 0,
        reading: Reading { bytes, ..Reading::default() },
    };
    let (at_byte, end) = reader.records(&mut source)?;
    if !reader.identified {
        return Err(if matches!(end, End::Cut) { ReadError::Empty { bytes } } else { ReadError::NotPhalanx });
    }
    if extent == Extent::Head || matches!(end, End::Whole) {
        return Ok(reader.reading);
    }
    let last_s = reader.reading.last_s;
    if extent == Extent::Pieces && reader.reading.chunks == 0 {
        reader.names_from_index(&mut source)?;
    }
    let behind = behind::search(&mut source, at_byte + 1, bytes, |chunk, records| match extent {
        Extent::Pieces => reader.piece(chunk, records),
        Extent::Head | Extent::Prefix => Ok(true),
    })?;
    let behind = Behind { used: extent == Extent::Pieces && behind.chunks > 0, ..behind };
    let mut reading = reader.reading;
    reading.losses.push(match end {
        // A record that reaches beyond the end is a cut, unless there is more behind its beginning.
        End::Cut if behind.chunks == 0 => Loss::Truncated { at_byte, bytes, last_s },
        End::Cut => {
            let reason = "a record claims more bytes than the file has".to_string();
            Loss::Damaged { at_byte, bytes, reason, last_s, behind }
        }
        End::Wrong(reason) => Loss::Damaged { at_byte, bytes, reason, last_s, behind },
        End::Whole => return Ok(reading),
    });
    Ok(reading)
}

/// How far the records of a file go.
enum End {
    Whole,
    Cut,
    Wrong(String),
}

struct Reader<'a, S> {
    sink: &'a mut S,
    assembler: Assembler,
    /// Room for the records of a chunk, reused.
    room: Vec<u8>,
    /// The metadata record has been seen.
    identified: bool,
    /// The sink knows what samples consist of.
    named: bool,
    /// Stop before the first chunk.
    head_only: bool,
    /// Latest log time.
    latest_ns: u64,
    reading: Reading,
}

impl<S: LogSink> Reader<'_, S> {
    /// Goes through the records of the file; returns where it ends, or where the first one begins that could not be used.
    fn records(&mut self, source: &mut impl Read) -> Result<(u64, End), ReadError> {
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(LARGEST_RECORD);
        let mut framing = LinearReader::new_with_options(options);
        let (mut at, mut left) = (mcap::MAGIC.len() as u64, self.reading.bytes);
        let mut in_data = true;
        while let Some(event) = framing.next_event() {
            match event {
                Ok(LinearReadEvent::ReadRequest(need)) => {
                    // No room is made for what the file does not have.
                    if need as u64 > left {
                        return Ok((at, End::Cut));
                    }
                    source.read_exact(framing.insert(need))?;
                    framing.notify_read(need);
                    left -= need as u64;
                }
                Ok(LinearReadEvent::Record { opcode: op::CHUNK, .. }) if self.head_only => {
                    return Ok((at, End::Whole));
                }
                Ok(LinearReadEvent::Record { opcode, data }) => {
                    in_data &= opcode != op::DATA_END;
                    if in_data && let Err(malformed) = self.record(at, opcode, data)? {
                        return Ok((at, End::Wrong(malformed.to_string())));
                    }
                    at += 9 + data.len() as u64;
                }
                Err(error) => return Ok((at, End::Wrong(reason(&error)))),
            }
        }
        if left > 0 {
            return Ok((self.reading.bytes - left, End::Wrong(format!("{left} more bytes follow the end of the log"))));
        }
        Ok((self.reading.bytes, End::Whole))
    }

    /// One record of the data section.
    fn record(&mut self, at_byte: u64, opcode: u8, data: &[u8]) -> Result<Result<(), Malformed>, ReadError> {
        match opcode {
            op::METADATA => match bytes::metadata(data) {
                Ok((name, entries)) => {
                    self.sink.record(&Record::Metadata { name, entries: &entries })?;
                    match name {
                        METADATA_NAME if !self.identified => {
                            self.identified = true;
                            self.assembler = Assembler::new(kind(&entries));
                            self.reading.metadata = entries;
                        }
                        RECOVERED_NAME => self.reading.recovered = Some(entries),
                        _ => {}
                    }
                }
                Err(malformed) => return Ok(Err(malformed)),
            },
            op::ATTACHMENT => match bytes::attachment(data) {
                Ok(attachment) => {
                    self.sink.record(&Record::Attachment(attachment))?;
                    if attachment.media_type == ATTACHMENT_MEDIA_TYPE && self.reading.scene.is_none() {
                        let text = String::from_utf8_lossy(attachment.data).into_owned();
                        self.reading.scene = Some((attachment.name.to_string(), text));
                    }
                }
                // The samples do not need it.
                Err(malformed) => {
                    let reason = malformed.to_string();
                    self.reading.losses.push(Loss::Scene { at_byte, reason });
                }
            },
            op::CHUNK => {
                let mut room = std::mem::take(&mut self.room);
                let result = match Chunk::parse(data).and_then(|chunk| chunk.records(LARGEST_RECORD, &mut room)) {
                    Ok(records) => self.chunk(records),
                    Err(malformed) => Ok(Err(malformed)),
                };
                self.room = room;
                return result;
            }
            _ => return self.small(opcode, data),
        }
        Ok(Ok(()))
    }

    /// Schemas and channels from the index, where the first chunk, which has them too, is lost.
    fn names_from_index(&mut self, source: &mut (impl Read + Seek)) -> Result<(), ReadError> {
        let Some(index) = behind::index(source, self.reading.bytes)? else { return Ok(()) };
        let mut found = Vec::new();
        let mut cursor = Cursor::new(&index);
        while let Ok((opcode, data)) = cursor.record() {
            let id = data.first_chunk().map_or(0, |id| u16::from_le_bytes(*id));
            if matches!(opcode, op::SCHEMA | op::CHANNEL) {
                found.push((opcode, id, data));
            }
        }
        // In the order in which they were announced: schemas first, by their ids.
        found.sort_by_key(|&(opcode, id, _)| (opcode, id));
        for (opcode, _, data) in found {
            if self.small(opcode, data)?.is_err() {
                break;
            }
        }
        Ok(())
    }

    /// A whole chunk behind a damage; false if it is of no use here.
    fn piece(&mut self, chunk: &Chunk<'_>, records: &[u8]) -> Result<bool, ReadError> {
        // What goes back in time, or has nothing to vouch for it, is no part of this log.
        if !chunk.is_sealed() || chunk.start_ns < self.latest_ns {
            return Ok(false);
        }
        self.assembler.forget_parts();
        self.sink.piece()?;
        Ok(self.chunk(records)?.is_ok())
    }

    fn chunk(&mut self, records: &[u8]) -> Result<Result<(), Malformed>, ReadError> {
        let mut cursor = Cursor::new(records);
        while !cursor.is_empty() {
            let outcome = match cursor.record() {
                Ok((opcode, data)) => self.small(opcode, data)?,
                Err(malformed) => Err(malformed),
            };
            if outcome.is_err() {
                return Ok(outcome);
            }
        }
        self.reading.chunks += 1;
        Ok(Ok(()))
    }

    /// A schema, a channel or a message, in a chunk or outside.
    fn small(&mut self, opcode: u8, data: &[u8]) -> Result<Result<(), Malformed>, ReadError> {
        match opcode {
            op::SCHEMA => match bytes::schema(data) {
                Ok(schema) => {
                    self.assembler.schema(&schema);
                    self.sink.record(&Record::Schema(schema))?;
                }
                Err(malformed) => return Ok(Err(malformed)),
            },
            op::CHANNEL => match bytes::channel(data) {
                Ok(channel) => {
                    self.reading.unknown_channels += u64::from(self.assembler.channel(&channel));
                    self.sink.record(&Record::Channel(channel))?;
                }
                Err(malformed) => return Ok(Err(malformed)),
            },
            op::MESSAGE if !self.identified => return Err(ReadError::NotPhalanx),
            op::MESSAGE => {
                let understood = bytes::message(data)
                    .and_then(|message| self.assembler.message(&message).map(|found| (message, found)));
                match understood {
                    Ok((message, found)) => {
                        self.reading.messages += 1;
                        self.latest_ns = self.latest_ns.max(message.log_time_ns);
                        self.sink.record(&Record::Message(message))?;
                        self.found(found)?;
                    }
                    Err(malformed) => return Ok(Err(malformed)),
                }
            }
            _ => {}
        }
        Ok(Ok(()))
    }

    fn found(&mut self, found: Found) -> Result<(), SinkError> {
        if matches!(found, Found::Sample | Found::Event(_)) && !self.named {
            self.named = true;
            self.sink.layout(self.assembler.layout())?;
        }
        match found {
            Found::Nothing => {}
            Found::Unknown => self.reading.unknown_messages += 1,
            Found::Ended(ended) => self.reading.ended = Some(ended),
            Found::Event(event) => {
                self.reading.events += 1;
                self.sink.event(&event)?;
            }
            Found::Sample => {
                let sample = self.assembler.sample();
                self.sink.sample(sample)?;
                self.reading.samples += 1;
                self.reading.first_s.get_or_insert(sample.time_s);
                self.reading.last_s = Some(sample.time_s);
            }
        }
        Ok(())
    }
}

/// What the reader of the framing found wrong, in words that say what it means for the log.
fn reason(error: &McapError) -> String {
    match error {
        McapError::BadDataCrc { .. } => {
            "the checksum of all data does not match, though that of every chunk does: what has changed is outside the \
             chunks, such as the metadata"
                .to_string()
        }
        McapError::BadSummaryCrc { .. } => "the checksum of the index does not match".to_string(),
        McapError::BadMagic => "it does not end as an MCAP file does".to_string(),
        McapError::RecordTooLarge { len, .. } => format!("a record claims {len} bytes"),
        McapError::ChunkTooLarge(len) => format!("a chunk claims {len} bytes"),
        other => other.to_string(),
    }
}
