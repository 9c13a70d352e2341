//! The first pass over a log: what it announces, and where its messages are. Nothing is known of their order before it.

use std::collections::{BTreeMap, HashSet};
use std::io::{Read, Seek, SeekFrom};

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::behind;
use super::bytes::{self, Chunk, Cursor, LARGEST_RECORD, Malformed};
use super::reading::{Loss, ReadError, Reading};
use super::record::{LogSink, Record};
use crate::metadata::{ATTACHMENT_MEDIA_TYPE, METADATA_NAME, RECOVERED_NAME};

/// Schemas and channels take no more than this.
const MOST_ANNOUNCED: usize = LARGEST_RECORD;
/// Messages outside chunks are read together up to this many bytes.
const BARE_BYTES: u64 = 1 << 18;

/// A part of the file that is read at once: a chunk, or messages outside chunks that follow each other.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    pub at: u64,
    pub bytes: u64,
    pub is_chunk: bool,
    /// Log times of the first and the last message.
    pub start_ns: u64,
    pub end_ns: u64,
    /// Found behind a damage.
    pub behind: bool,
}

/// The messages of one channel: how many, and their least and largest sequence number.
#[derive(Clone, Copy, Debug)]
pub struct Numbers {
    pub messages: u64,
    pub least: u32,
    pub largest: u32,
}

/// How far the records of a file go.
pub enum End {
    Whole,
    Cut,
    Wrong(String),
    /// A chunk is compressed in this way.
    Compressed(String),
}

/// What the first pass has found.
pub struct Survey {
    pub reading: Reading,
    /// The metadata record has been seen.
    pub identified: bool,
    /// Schemas and channels in the order of the file: opcode and body, each once.
    pub announced: Vec<(u8, Vec<u8>)>,
    known: HashSet<(u8, u16)>,
    announced_bytes: usize,
    pub segments: Vec<Segment>,
    pub numbers: BTreeMap<u16, Numbers>,
    latest_ns: u64,
    /// Room for the records of a chunk, reused.
    room: Vec<u8>,
}

impl Survey {
    pub fn new(bytes: u64) -> Self {
        Survey {
            reading: Reading { bytes, ..Reading::default() },
            identified: false,
            announced: Vec::new(),
            known: HashSet::new(),
            announced_bytes: 0,
            segments: Vec::new(),
            numbers: BTreeMap::new(),
            latest_ns: 0,
            room: Vec::new(),
        }
    }

    /// Goes through the records of the file; returns where it ends, or where the first one begins that could not be used. The sink
    /// gets metadata and attachments. `head_only`: chunks are passed over, and the end is where metadata and scene are known.
    pub fn records(
        &mut self,
        source: &mut impl Read,
        sink: &mut impl LogSink,
        head_only: bool,
    ) -> Result<(u64, End), ReadError> {
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
                Ok(LinearReadEvent::Record { opcode: op::CHUNK | op::MESSAGE, data }) if head_only => {
                    if self.identified && self.reading.scene.is_some() {
                        return Ok((at, End::Whole));
                    }
                    at += 9 + data.len() as u64;
                }
                Ok(LinearReadEvent::Record { opcode, data }) => {
                    in_data &= opcode != op::DATA_END;
                    if in_data {
                        match self.record(at, opcode, data, sink)? {
                            Ok(None) => {}
                            Ok(Some(compression)) => return Ok((at, End::Compressed(compression))),
                            Err(malformed) => return Ok((at, End::Wrong(malformed.to_string()))),
                        }
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

    /// One record of the data section; how a chunk is compressed if that is unknown.
    fn record(
        &mut self,
        at: u64,
        opcode: u8,
        data: &[u8],
        sink: &mut impl LogSink,
    ) -> Result<Result<Option<String>, Malformed>, ReadError> {
        match opcode {
            op::METADATA => match bytes::metadata(data) {
                Ok((name, entries)) => {
                    sink.record(&Record::Metadata { name, entries: &entries })?;
                    match name {
                        METADATA_NAME if !self.identified => {
                            self.identified = true;
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
                    sink.record(&Record::Attachment(attachment))?;
                    if attachment.media_type == ATTACHMENT_MEDIA_TYPE && self.reading.scene.is_none() {
                        let text = String::from_utf8_lossy(attachment.data).into_owned();
                        self.reading.scene = Some((attachment.name.to_string(), text));
                    }
                }
                // The samples do not need it.
                Err(malformed) => {
                    self.reading.losses.push(Loss::Scene { at_byte: at, reason: malformed.to_string() });
                }
            },
            op::CHUNK => return Ok(self.chunk(at, data)),
            op::SCHEMA | op::CHANNEL => return Ok(self.announce(opcode, data).map(|()| None)),
            op::MESSAGE => return Ok(self.bare(at, data).map(|()| None)),
            _ => {}
        }
        Ok(Ok(None))
    }

    fn chunk(&mut self, at: u64, data: &[u8]) -> Result<Option<String>, Malformed> {
        let chunk = Chunk::parse(data)?;
        if let Some(compression) = chunk.unknown_compression() {
            return Ok(Some(compression.chars().take(40).collect()));
        }
        let mut room = std::mem::take(&mut self.room);
        let taken = chunk.records(LARGEST_RECORD, &mut room).and_then(|records| {
            let segment = Segment { at, bytes: 9 + data.len() as u64, is_chunk: true, behind: false, ..EMPTY };
            self.segment(segment, records)
        });
        self.room = room;
        taken.map(|()| None)
    }

    /// The records of a chunk: all of them are of use, or none.
    fn segment(&mut self, mut segment: Segment, records: &[u8]) -> Result<(), Malformed> {
        let mut cursor = Cursor::new(records);
        while !cursor.is_empty() {
            match cursor.record()? {
                (op::SCHEMA, data) => _ = bytes::schema(data)?,
                (op::CHANNEL, data) => _ = bytes::channel(data)?,
                (op::MESSAGE, data) => segment.include(bytes::message(data)?.log_time_ns),
                _ => {}
            }
        }
        let mut cursor = Cursor::new(records);
        while let Ok((opcode, data)) = cursor.record() {
            match opcode {
                op::SCHEMA | op::CHANNEL => self.announce(opcode, data)?,
                op::MESSAGE => self.count(data)?,
                _ => {}
            }
        }
        self.reading.chunks += 1;
        // One that has no message says nothing more.
        if segment.start_ns <= segment.end_ns {
            self.latest_ns = self.latest_ns.max(segment.end_ns);
            self.segments.push(segment);
        }
        Ok(())
    }

    /// A message outside chunks.
    fn bare(&mut self, at: u64, data: &[u8]) -> Result<(), Malformed> {
        let log_time_ns = bytes::message(data)?.log_time_ns;
        self.count(data)?;
        self.latest_ns = self.latest_ns.max(log_time_ns);
        let bytes = 9 + data.len() as u64;
        if let Some(last) = self.segments.last_mut()
            && !last.is_chunk
            && last.at + last.bytes == at
            && last.bytes < BARE_BYTES
            && last.end_ns <= log_time_ns
        {
            last.bytes += bytes;
            last.include(log_time_ns);
            return Ok(());
        }
        let mut segment = Segment { at, bytes, ..EMPTY };
        segment.include(log_time_ns);
        self.segments.push(segment);
        Ok(())
    }

    fn count(&mut self, data: &[u8]) -> Result<(), Malformed> {
        let message = bytes::message(data)?;
        let sequence = message.sequence;
        let numbers =
            self.numbers.entry(message.channel).or_insert(Numbers { messages: 0, least: sequence, largest: sequence });
        numbers.messages += 1;
        (numbers.least, numbers.largest) = (numbers.least.min(sequence), numbers.largest.max(sequence));
        Ok(())
    }

    /// A schema or a channel. One that is announced again says what it said before.
    fn announce(&mut self, opcode: u8, data: &[u8]) -> Result<(), Malformed> {
        let id = if opcode == op::SCHEMA { bytes::schema(data)?.id } else { bytes::channel(data)?.id };
        if !self.known.insert((opcode, id)) {
            return Ok(());
        }
        self.announced_bytes += data.len();
        if self.announced_bytes > MOST_ANNOUNCED {
            return Err(Malformed("schemas and channels take more than any log of phalanx has of them"));
        }
        self.announced.push((opcode, data.to_vec()));
        Ok(())
    }

    /// Schemas and channels from the index, where the chunk that has them is lost.
    pub fn names_from_index(&mut self, source: &mut (impl Read + Seek)) -> Result<(), ReadError> {
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
            if self.announce(opcode, data).is_err() {
                break;
            }
        }
        Ok(())
    }

    /// A whole chunk behind a damage; false if it is of no use here. `listed`: where chunks are by the index of the log.
    pub fn piece(&mut self, at: u64, chunk: &Chunk<'_>, records: &[u8], listed: &[u64]) -> bool {
        // What goes back in time and is in no index, or has nothing to vouch for it, is no part of this log.
        if !chunk.is_sealed() || (chunk.start_ns < self.latest_ns && !listed.contains(&at)) {
            return false;
        }
        let segment = Segment { at, bytes: 0, is_chunk: true, behind: true, ..EMPTY };
        self.segment(segment, records).is_ok()
    }
}

/// Where the chunks of a log are by its index, if that is whole.
pub fn listed(source: &mut (impl Read + Seek), bytes: u64) -> Result<Vec<u64>, ReadError> {
    let mut offsets = Vec::new();
    let Some(index) = behind::index(source, bytes)? else { return Ok(offsets) };
    let mut cursor = Cursor::new(&index);
    while let Ok((opcode, data)) = cursor.record() {
        // Two times, then the offset.
        if opcode == op::CHUNK_INDEX
            && let Some(offset) = data.get(16..24).and_then(|bytes| bytes.first_chunk())
        {
            offsets.push(u64::from_le_bytes(*offset));
        }
    }
    Ok(offsets)
}

const EMPTY: Segment = Segment { at: 0, bytes: 0, is_chunk: false, start_ns: u64::MAX, end_ns: 0, behind: false };

impl Segment {
    fn include(&mut self, log_time_ns: u64) {
        (self.start_ns, self.end_ns) = (self.start_ns.min(log_time_ns), self.end_ns.max(log_time_ns));
    }

    /// Its records, checked once more: `raw` is room for the bytes of the file.
    pub fn load(
        &self,
        source: &mut (impl Read + Seek),
        raw: &mut Vec<u8>,
        records: &mut Vec<u8>,
    ) -> Result<(), ReadError> {
        let changed = || ReadError::Io(std::io::Error::other("the log changes while it is read"));
        source.seek(SeekFrom::Start(self.at))?;
        records.clear();
        if !self.is_chunk {
            source.by_ref().take(self.bytes).read_to_end(records)?;
            return if records.len() as u64 == self.bytes { Ok(()) } else { Err(changed()) };
        }
        let mut head = [0; 9];
        source.read_exact(&mut head)?;
        let length = u64::from_le_bytes(std::array::from_fn(|i| head[1 + i]));
        raw.clear();
        source.by_ref().take(length.min(LARGEST_RECORD as u64)).read_to_end(raw)?;
        let chunk = Chunk::parse(raw).map_err(|_| changed())?;
        if chunk.is_compressed() {
            chunk.records(LARGEST_RECORD, records).map_err(|_| changed())?;
        } else {
            let mut none = Vec::new();
            records.extend_from_slice(chunk.records(LARGEST_RECORD, &mut none).map_err(|_| changed())?);
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
