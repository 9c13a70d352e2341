//! First pass over a log: its schemas, channels and the positions of its messages, whose order is unknown.

use std::collections::{BTreeMap, HashSet};
use std::io::{Read, Seek, SeekFrom};

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::bytes::{self, Chunk, Cursor, MAX_RECORD_BYTES, MalformedData};
use super::chunk_search;
use super::record::{LogSink, Record};
use super::summary::{LogSummary, Loss, ReadError};
use crate::metadata::{ATTACHMENT_MEDIA_TYPE, METADATA_NAME, RECOVERED_NAME};

/// Maximum total size of schemas and channels.
const MAX_DEFINITION_BYTES: usize = MAX_RECORD_BYTES;
/// Maximum size of a segment of messages outside chunks.
const MAX_BARE_SEGMENT_BYTES: u64 = 1 << 18;

/// A part of the file that is read at once: a chunk, or consecutive messages outside chunks.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    pub offset: u64,
    pub bytes: u64,
    pub is_chunk: bool,
    /// Smallest log time of the messages.
    pub start_ns: u64,
    /// Largest log time of the messages.
    pub end_ns: u64,
    /// Whether the segment was found after damage.
    pub is_after_damage: bool,
}

/// Number of messages of a channel, and their smallest and largest sequence number.
#[derive(Clone, Copy, Debug)]
pub struct SequenceStats {
    pub messages: u64,
    pub min_sequence: u32,
    pub max_sequence: u32,
}

/// How the scan of a file ended.
pub enum ScanEnd {
    Complete,
    Truncated,
    Damaged(String),
    /// Unsupported compression of a chunk.
    UnsupportedCompression(String),
}

/// Results of the first pass.
pub struct Survey {
    pub summary: LogSummary,
    /// Whether the metadata record of phalanx was found.
    pub is_phalanx_log: bool,
    /// Opcode and body of schemas and channels in file order, each once.
    pub definitions: Vec<(u8, Vec<u8>)>,
    definition_ids: HashSet<(u8, u16)>,
    definition_bytes: usize,
    pub segments: Vec<Segment>,
    pub sequence_stats: BTreeMap<u16, SequenceStats>,
    latest_ns: u64,
    /// Reused buffer for the records of a chunk.
    decompressed: Vec<u8>,
}

impl Survey {
    pub fn new(bytes: u64) -> Self {
        Survey {
            summary: LogSummary { bytes, ..LogSummary::default() },
            is_phalanx_log: false,
            definitions: Vec::new(),
            definition_ids: HashSet::new(),
            definition_bytes: 0,
            segments: Vec::new(),
            sequence_stats: BTreeMap::new(),
            latest_ns: 0,
            decompressed: Vec::new(),
        }
    }

    /// Scans the records of the file. Returns the end of the file, or the start of the first invalid record. The sink
    /// receives metadata and attachments. `head_only`: skips chunks and stops once metadata and scene are known.
    pub fn records(
        &mut self,
        source: &mut impl Read,
        sink: &mut impl LogSink,
        head_only: bool,
    ) -> Result<(u64, ScanEnd), ReadError> {
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(MAX_RECORD_BYTES);
        let mut record_reader = LinearReader::new_with_options(options);
        let (mut offset, mut remaining_bytes) = (mcap::MAGIC.len() as u64, self.summary.bytes);
        let mut is_in_data_section = true;
        while let Some(event) = record_reader.next_event() {
            match event {
                Ok(LinearReadEvent::ReadRequest(requested)) => {
                    // Do not allocate for bytes that the file does not have.
                    if requested as u64 > remaining_bytes {
                        return Ok((offset, ScanEnd::Truncated));
                    }
                    source.read_exact(record_reader.insert(requested))?;
                    record_reader.notify_read(requested);
                    remaining_bytes -= requested as u64;
                }
                Ok(LinearReadEvent::Record { opcode: op::CHUNK | op::MESSAGE, data }) if head_only => {
                    if self.is_phalanx_log && self.summary.scene.is_some() {
                        return Ok((offset, ScanEnd::Complete));
                    }
                    offset += 9 + data.len() as u64;
                }
                Ok(LinearReadEvent::Record { opcode, data }) => {
                    is_in_data_section &= opcode != op::DATA_END;
                    if is_in_data_section {
                        match self.record(offset, opcode, data, sink)? {
                            Ok(None) => {}
                            Ok(Some(compression)) => return Ok((offset, ScanEnd::UnsupportedCompression(compression))),
                            Err(malformed) => return Ok((offset, ScanEnd::Damaged(malformed.to_string()))),
                        }
                    }
                    offset += 9 + data.len() as u64;
                }
                Err(error) => return Ok((offset, ScanEnd::Damaged(describe_error(&error)))),
            }
        }
        if remaining_bytes > 0 {
            return Ok((
                self.summary.bytes - remaining_bytes,
                ScanEnd::Damaged(format!("{remaining_bytes} more bytes follow the end of the log")),
            ));
        }
        Ok((self.summary.bytes, ScanEnd::Complete))
    }

    /// Handles one record of the data section. Returns the compression of a chunk if it is not supported.
    fn record(
        &mut self,
        offset: u64,
        opcode: u8,
        data: &[u8],
        sink: &mut impl LogSink,
    ) -> Result<Result<Option<String>, MalformedData>, ReadError> {
        match opcode {
            op::METADATA => match bytes::metadata(data) {
                Ok((name, entries)) => {
                    sink.record(&Record::Metadata { name, entries: &entries })?;
                    match name {
                        METADATA_NAME if !self.is_phalanx_log => {
                            self.is_phalanx_log = true;
                            self.summary.metadata = entries;
                        }
                        RECOVERED_NAME => self.summary.recovered = Some(entries),
                        _ => {}
                    }
                }
                Err(malformed) => return Ok(Err(malformed)),
            },
            op::ATTACHMENT => match bytes::attachment(data) {
                Ok(attachment) => {
                    sink.record(&Record::Attachment(attachment))?;
                    if attachment.media_type == ATTACHMENT_MEDIA_TYPE && self.summary.scene.is_none() {
                        let text = String::from_utf8_lossy(attachment.data).into_owned();
                        self.summary.scene = Some((attachment.name.to_string(), text));
                    }
                }
                // Samples do not depend on the attachment.
                Err(malformed) => {
                    self.summary.losses.push(Loss::Scene { at_byte: offset, reason: malformed.to_string() });
                }
            },
            op::CHUNK => return Ok(self.add_chunk(offset, data)),
            op::SCHEMA | op::CHANNEL => return Ok(self.add_definition(opcode, data).map(|()| None)),
            op::MESSAGE => return Ok(self.add_bare_message(offset, data).map(|()| None)),
            _ => {}
        }
        Ok(Ok(None))
    }

    fn add_chunk(&mut self, offset: u64, data: &[u8]) -> Result<Option<String>, MalformedData> {
        let chunk = Chunk::parse(data)?;
        if let Some(compression) = chunk.unknown_compression() {
            return Ok(Some(compression.chars().take(40).collect()));
        }
        let mut decompressed = std::mem::take(&mut self.decompressed);
        let added = chunk.records(MAX_RECORD_BYTES, &mut decompressed).and_then(|records| {
            let segment = Segment {
                offset,
                bytes: 9 + data.len() as u64,
                is_chunk: true,
                is_after_damage: false,
                ..EMPTY_SEGMENT
            };
            self.add_segment(segment, records)
        });
        self.decompressed = decompressed;
        added.map(|()| None)
    }

    /// Adds the records of a chunk, or none of them if one is invalid.
    fn add_segment(&mut self, mut segment: Segment, records: &[u8]) -> Result<(), MalformedData> {
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
                op::SCHEMA | op::CHANNEL => self.add_definition(opcode, data)?,
                op::MESSAGE => self.count_message(data)?,
                _ => {}
            }
        }
        self.summary.chunks += 1;
        // A chunk without messages is not read again.
        if segment.start_ns <= segment.end_ns {
            self.latest_ns = self.latest_ns.max(segment.end_ns);
            self.segments.push(segment);
        }
        Ok(())
    }

    /// Adds a message outside chunks.
    fn add_bare_message(&mut self, offset: u64, data: &[u8]) -> Result<(), MalformedData> {
        let log_time_ns = bytes::message(data)?.log_time_ns;
        self.count_message(data)?;
        self.latest_ns = self.latest_ns.max(log_time_ns);
        let bytes = 9 + data.len() as u64;
        if let Some(last) = self.segments.last_mut()
            && !last.is_chunk
            && last.offset + last.bytes == offset
            && last.bytes < MAX_BARE_SEGMENT_BYTES
            && last.end_ns <= log_time_ns
        {
            last.bytes += bytes;
            last.include(log_time_ns);
            return Ok(());
        }
        let mut segment = Segment { offset, bytes, ..EMPTY_SEGMENT };
        segment.include(log_time_ns);
        self.segments.push(segment);
        Ok(())
    }

    fn count_message(&mut self, data: &[u8]) -> Result<(), MalformedData> {
        let message = bytes::message(data)?;
        let sequence = message.sequence;
        let stats = self.sequence_stats.entry(message.channel).or_insert(SequenceStats {
            messages: 0,
            min_sequence: sequence,
            max_sequence: sequence,
        });
        stats.messages += 1;
        (stats.min_sequence, stats.max_sequence) = (stats.min_sequence.min(sequence), stats.max_sequence.max(sequence));
        Ok(())
    }

    /// Adds a schema or a channel; repetitions are ignored.
    fn add_definition(&mut self, opcode: u8, data: &[u8]) -> Result<(), MalformedData> {
        let id = if opcode == op::SCHEMA { bytes::schema(data)?.id } else { bytes::channel(data)?.id };
        if !self.definition_ids.insert((opcode, id)) {
            return Ok(());
        }
        self.definition_bytes += data.len();
        if self.definition_bytes > MAX_DEFINITION_BYTES {
            return Err(MalformedData("schemas and channels exceed the size limit"));
        }
        self.definitions.push((opcode, data.to_vec()));
        Ok(())
    }

    /// Reads schemas and channels from the index, for logs that have lost the chunk with them.
    pub fn read_definitions_from_index(&mut self, source: &mut (impl Read + Seek)) -> Result<(), ReadError> {
        let Some(index) = chunk_search::read_index(source, self.summary.bytes)? else { return Ok(()) };
        let mut found = Vec::new();
        let mut cursor = Cursor::new(&index);
        while let Ok((opcode, data)) = cursor.record() {
            let id = data.first_chunk().map_or(0, |id| u16::from_le_bytes(*id));
            if matches!(opcode, op::SCHEMA | op::CHANNEL) {
                found.push((opcode, id, data));
            }
        }
        // In the original order: schemas first, by id.
        found.sort_by_key(|&(opcode, id, _)| (opcode, id));
        for (opcode, _, data) in found {
            if self.add_definition(opcode, data).is_err() {
                break;
            }
        }
        Ok(())
    }

    /// Adds an intact chunk found after damage; returns `false` if it is not used. `indexed_offsets`: chunk offsets
    /// from the index of the log.
    pub fn add_chunk_after_damage(
        &mut self,
        offset: u64,
        chunk: &Chunk<'_>,
        records: &[u8],
        indexed_offsets: &[u64],
    ) -> bool {
        // A chunk without checksum, or one that goes back in time and is not in the index, is not part of this log.
        if !chunk.has_checksum() || (chunk.start_ns < self.latest_ns && !indexed_offsets.contains(&offset)) {
            return false;
        }
        let segment = Segment { offset, bytes: 0, is_chunk: true, is_after_damage: true, ..EMPTY_SEGMENT };
        self.add_segment(segment, records).is_ok()
    }
}

/// Returns the chunk offsets from the index of a log; empty if the index is missing or damaged.
pub fn indexed_chunk_offsets(source: &mut (impl Read + Seek), bytes: u64) -> Result<Vec<u64>, ReadError> {
    let mut offsets = Vec::new();
    let Some(index) = chunk_search::read_index(source, bytes)? else { return Ok(offsets) };
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

const EMPTY_SEGMENT: Segment =
    Segment { offset: 0, bytes: 0, is_chunk: false, start_ns: u64::MAX, end_ns: 0, is_after_damage: false };

impl Segment {
    fn include(&mut self, log_time_ns: u64) {
        (self.start_ns, self.end_ns) = (self.start_ns.min(log_time_ns), self.end_ns.max(log_time_ns));
    }

    /// Loads the records of the segment and verifies them again. `file_bytes` is a reused buffer.
    pub fn load(
        &self,
        source: &mut (impl Read + Seek),
        file_bytes: &mut Vec<u8>,
        records: &mut Vec<u8>,
    ) -> Result<(), ReadError> {
        let file_changed_error = || ReadError::Io(std::io::Error::other("the log changes while it is read"));
        source.seek(SeekFrom::Start(self.offset))?;
        records.clear();
        if !self.is_chunk {
            source.by_ref().take(self.bytes).read_to_end(records)?;
            return if records.len() as u64 == self.bytes { Ok(()) } else { Err(file_changed_error()) };
        }
        let mut record_header = [0; 9];
        source.read_exact(&mut record_header)?;
        let length = u64::from_le_bytes(std::array::from_fn(|i| record_header[1 + i]));
        file_bytes.clear();
        source.by_ref().take(length.min(MAX_RECORD_BYTES as u64)).read_to_end(file_bytes)?;
        let chunk = Chunk::parse(file_bytes).map_err(|_| file_changed_error())?;
        if chunk.is_compressed() {
            chunk.records(MAX_RECORD_BYTES, records).map_err(|_| file_changed_error())?;
        } else {
            let mut unused_buffer = Vec::new();
            records.extend_from_slice(
                chunk.records(MAX_RECORD_BYTES, &mut unused_buffer).map_err(|_| file_changed_error())?,
            );
        }
        Ok(())
    }
}

/// Describes an error of the MCAP framing.
fn describe_error(error: &McapError) -> String {
    match error {
        McapError::BadDataCrc { .. } => {
            "the checksum of the data section does not match, but all chunks are valid: the change is outside the chunks, \
             for example in the metadata"
                .to_string()
        }
        McapError::BadSummaryCrc { .. } => "the checksum of the index does not match".to_string(),
        McapError::BadMagic => "it does not end with the MCAP magic bytes".to_string(),
        McapError::RecordTooLarge { len, .. } => format!("a record claims {len} bytes"),
        McapError::ChunkTooLarge(len) => format!("a chunk claims {len} bytes"),
        other => other.to_string(),
    }
}
