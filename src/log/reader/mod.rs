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
//! | `wire` | messages of protobuf |
//! | `assemble` | messages → samples and events |
//! | `behind` | chunks that can still be read behind a damage |
//!
//! The framing of the file, its end, and the checksums of its sections are left to the `mcap` crate; its parser of single
//! records is not used, because it panics on attachments shorter than their checksum.

mod assemble;
mod behind;
mod bytes;
mod wire;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use self::assemble::{Assembler, Found};
pub use self::behind::Behind;
use self::bytes::{Chunk, Malformed};
use super::file::partial_name;
use super::metadata::{ATTACHMENT_MEDIA_TYPE, METADATA_NAME};
use crate::trace::{Sink, SinkError};

/// No record or chunk of a log is larger, compressed or not: sixty times what phalanx writes.
pub const LARGEST_RECORD: usize = 16 << 20;

/// What was found in a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// Size of the file.
    pub bytes: u64,
    /// Versions, model and settings, see [`metadata`](super::metadata()).
    pub metadata: BTreeMap<String, String>,
    /// Name and text of the attached scene.
    pub scene: Option<(String, String)>,
    pub samples: u64,
    pub events: u64,
    pub messages: u64,
    /// Channels that phalanx does not know, and messages on them.
    pub unknown_channels: u64,
    pub unknown_messages: u64,
    pub chunks: u64,
    /// Times of the first and last sample.
    pub first_s: Option<f64>,
    pub last_s: Option<f64>,
    /// How the run ended, if the log got to say.
    pub ended: Option<Ended>,
    /// Empty if the log is whole.
    pub losses: Vec<Loss>,
}

impl Reading {
    pub fn is_whole(&self) -> bool {
        self.losses.is_empty()
    }
}

/// How the run of a log ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    pub time_s: f64,
    /// `None` if it was completed.
    pub stopped: Option<String>,
}

impl Ended {
    fn new(time_s: f64, line: String) -> Self {
        let stopped = match line.strip_prefix("stopped: ") {
            Some(reason) => Some(reason.to_string()),
            None if line == "completed" => None,
            None => Some(line),
        };
        Ended { time_s, stopped }
    }
}

/// Something that is not there, or not as it was written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Loss {
    /// The file ends before the log does.
    #[error("the log is truncated: it breaks off at byte {at_byte} of {bytes}{}", up_to(.last_s))]
    Truncated { at_byte: u64, bytes: u64, last_s: Option<f64> },
    /// Something is wrong; nothing behind it was used.
    #[error("the log is damaged at byte {at_byte} of {bytes}: {reason}{}; {behind}", up_to(.last_s))]
    Damaged { at_byte: u64, bytes: u64, reason: String, last_s: Option<f64>, behind: Behind },
    /// The samples are not concerned.
    #[error("the log is damaged at byte {at_byte}: {reason}; its samples are not concerned")]
    Scene { at_byte: u64, reason: String },
}

fn up_to(last_s: &Option<f64>) -> String {
    match last_s {
        Some(time_s) => format!("; it can be read up to {:.6} ms", time_s * 1e3),
        None => "; there is no sample before that".to_string(),
    }
}

/// Why there is nothing to read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    #[error("there is no log {path}{hint}")]
    Missing { path: PathBuf, hint: String },
    #[error("{path} is {what}; name a log file (.mcap)")]
    NotAFile { path: PathBuf, what: &'static str },
    #[error("not an MCAP file: it does not begin as one")]
    NotMcap,
    #[error("an MCAP file, but not a log of phalanx: it has no metadata record `{METADATA_NAME}` before its messages")]
    NotPhalanx,
    #[error("a log that breaks off before it says what it is of: only {bytes} bytes are there")]
    Empty { bytes: u64 },
    #[error("cannot read: {0}")]
    Io(#[from] io::Error),
    #[error(transparent)]
    Sink(#[from] SinkError),
}

/// Reads a log file into a sink.
///
/// # Errors
/// [`ReadError`] if it is not a log of phalanx or cannot be read, or if the sink refuses. A log that is cut short or
/// damaged is no error: [`Reading::losses`] says so.
pub fn read_file(path: &Path, sink: &mut impl Sink) -> Result<Reading, ReadError> {
    read(open(path)?, sink)
}

fn open(path: &Path) -> Result<BufReader<File>, ReadError> {
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
    go_through(open(path)?, &mut (), true)
}

/// Reads a log into a sink, see [`read_file`].
pub fn read(source: impl Read + Seek, sink: &mut impl Sink) -> Result<Reading, ReadError> {
    go_through(source, sink, false)
}

fn go_through(mut source: impl Read + Seek, sink: &mut impl Sink, head_only: bool) -> Result<Reading, ReadError> {
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
        assembler: Assembler::new(),
        room: Vec::new(),
        identified: false,
        head_only,
        reading: Reading { bytes, ..Reading::default() },
    };
    let (at_byte, end) = reader.records(&mut source)?;
    let Reader { mut reading, identified, .. } = reader;
    if !identified {
        return Err(if matches!(end, End::Cut) { ReadError::Empty { bytes } } else { ReadError::NotPhalanx });
    }
    let last_s = reading.last_s;
    let behind = match end {
        _ if head_only => return Ok(reading),
        End::Whole => return Ok(reading),
        _ => behind::search(&mut source, at_byte + 1, bytes)?,
    };
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
    /// Stop before the first chunk.
    head_only: bool,
    reading: Reading,
}

impl<S: Sink> Reader<'_, S> {
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
                Ok((METADATA_NAME, entries)) if !self.identified => {
                    self.identified = true;
                    self.reading.metadata = entries;
                }
                Ok(_) => {}
                Err(malformed) => return Ok(Err(malformed)),
            },
            op::ATTACHMENT => match bytes::attachment(data) {
                Ok((name, ATTACHMENT_MEDIA_TYPE, text)) if self.reading.scene.is_none() => {
                    self.reading.scene = Some((name.to_string(), String::from_utf8_lossy(text).into_owned()));
                }
                Ok(_) => {}
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

    fn chunk(&mut self, records: &[u8]) -> Result<Result<(), Malformed>, ReadError> {
        let mut cursor = bytes::Cursor::new(records);
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
        let outcome = match opcode {
            op::SCHEMA => bytes::schema(data).map(|(id, name, encoding)| {
                self.assembler.schema(id, name, encoding);
                Found::Nothing
            }),
            op::CHANNEL => bytes::channel(data).map(|(id, schema, topic, encoding)| {
                self.reading.unknown_channels += u64::from(self.assembler.channel(id, schema, topic, encoding));
                Found::Nothing
            }),
            op::MESSAGE if !self.identified => return Err(ReadError::NotPhalanx),
            op::MESSAGE => {
                self.reading.messages += 1;
                bytes::message(data).and_then(|(channel, time, payload)| self.assembler.message(channel, time, payload))
            }
            _ => Ok(Found::Nothing),
        };
        match outcome {
            Err(malformed) => return Ok(Err(malformed)),
            Ok(Found::Nothing) => {}
            Ok(Found::Unknown) => self.reading.unknown_messages += 1,
            Ok(Found::Sample(sample)) => {
                self.sink.sample(&sample)?;
                self.reading.samples += 1;
                self.reading.first_s.get_or_insert(sample.time_s);
                self.reading.last_s = Some(sample.time_s);
            }
            Ok(Found::Event(event)) => {
                self.sink.event(&event)?;
                self.reading.events += 1;
            }
            Ok(Found::Ended(ended)) => self.reading.ended = Some(ended),
        }
        Ok(Ok(()))
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
