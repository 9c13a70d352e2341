//! First pass over a log: metadata, scene, schemas, channels, and the positions of the messages, whose order is unknown.

use std::collections::{BTreeMap, HashSet};
use std::io::Read;
use std::sync::Arc;

use mcap::records::{ChunkHeader, ChunkIndex, MessageHeader, Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, parse_record};

use super::summary::{Defect, LogSummary, Loss, LossKind, ReadError};
use crate::metadata::{ATTACHMENT_MEDIA_TYPE, METADATA_NAME, SUBJECTS_RECORD};

/// Maximum size of a record or chunk, compressed or not. It is sixty times the size that phalanx writes.
pub const MAX_RECORD_BYTES: usize = 16 << 20;
/// Maximum total size of schemas and channels.
const MAX_DEFINITION_BYTES: usize = MAX_RECORD_BYTES;
/// Maximum size of a range of messages outside chunks that is read at once.
const MAX_BARE_BYTES: u64 = 1 << 18;
/// Opcode and length of a record.
const RECORD_HEAD: usize = 1 + 8;

/// Number of messages of a channel, and their smallest and largest sequence number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SequenceStats {
    pub messages: u64,
    pub min_sequence: u32,
    pub max_sequence: u32,
}

/// Results of the first pass.
pub(crate) struct Scan {
    pub summary: LogSummary,
    /// Whether the metadata record of phalanx was found.
    pub is_phalanx_log: bool,
    /// List of all subjects, if the log has one.
    pub subjects: Option<String>,
    /// Position of the attached scene.
    pub scene_offset: u64,
    /// Schemas, channels and chunks. A range of messages outside chunks is listed as an uncompressed chunk.
    pub index: mcap::Summary,
    /// Data offsets of the ranges of messages outside chunks, as computed from the index.
    pub bare_ranges: HashSet<u64>,
    /// End of the last range of messages outside chunks.
    bare_end: u64,
    pub sequences: BTreeMap<u16, SequenceStats>,
    definition_bytes: usize,
    /// Position of the first unusable byte and the reason; `None` if the file is complete.
    pub damage: Option<(u64, Defect)>,
}

impl Scan {
    /// Scans a file of `bytes` bytes to its end or to the first unusable byte. With `head_only`, chunks are skipped,
    /// and the scan stops once metadata and scene are known.
    pub fn new(source: &mut impl Read, bytes: u64, head_only: bool) -> Result<Self, ReadError> {
        let mut scan = Scan {
            summary: LogSummary { bytes, ..LogSummary::default() },
            is_phalanx_log: false,
            subjects: None,
            scene_offset: 0,
            index: mcap::Summary::default(),
            bare_ranges: HashSet::new(),
            bare_end: 0,
            sequences: BTreeMap::new(),
            definition_bytes: 0,
            damage: None,
        };
        let options = LinearReaderOptions::default().with_record_length_limit(MAX_RECORD_BYTES);
        let chunk_options = options.clone().with_skip_start_magic(true).with_skip_end_magic(true);
        let mut chunk_reader = LinearReader::new_with_options(chunk_options.with_prevalidate_chunk_crcs(true));
        let file_options = options.with_emit_chunks(true).with_validate_data_section_crc(true);
        let mut reader = LinearReader::new_with_options(file_options.with_validate_summary_section_crc(true));
        let (mut offset, mut remaining_bytes) = (mcap::MAGIC.len() as u64, bytes);
        let mut is_in_data_section = true;
        while let Some(event) = reader.next_event() {
            let defect = match event {
                // Do not allocate for bytes that the file does not have.
                Ok(LinearReadEvent::ReadRequest(requested)) if requested as u64 > remaining_bytes => {
                    Some(Defect { kind: LossKind::Truncated, reason: String::new() })
                }
                Ok(LinearReadEvent::ReadRequest(requested)) => {
                    source.read_exact(reader.insert(requested))?;
                    reader.notify_read(requested);
                    remaining_bytes -= requested as u64;
                    None
                }
                Ok(LinearReadEvent::Record { opcode, data }) => {
                    is_in_data_section &= opcode != op::DATA_END;
                    let is_skipped = head_only && matches!(opcode, op::CHUNK | op::MESSAGE);
                    if is_skipped && scan.is_phalanx_log && scan.summary.scene.is_some() {
                        return Ok(scan);
                    }
                    let defect = match is_in_data_section && !is_skipped {
                        true => scan.record(offset, opcode, data, &mut chunk_reader).err(),
                        false => None,
                    };
                    if defect.is_none() {
                        offset += (RECORD_HEAD + data.len()) as u64;
                    }
                    defect
                }
                Err(error) => Some(error.into()),
            };
            if let Some(defect) = defect {
                scan.damage = Some((offset, defect));
                return Ok(scan);
            }
        }
        if remaining_bytes > 0 {
            let reason = format!("{remaining_bytes} more bytes follow the end of the log");
            scan.damage = Some((bytes - remaining_bytes, Defect::damaged(reason)));
        }
        Ok(scan)
    }

    /// Processes a record outside chunks.
    fn record(&mut self, offset: u64, opcode: u8, data: &[u8], chunk_reader: &mut LinearReader) -> Result<(), Defect> {
        match parse(opcode, data) {
            Ok(Record::Metadata(mut found)) => {
                if found.name == METADATA_NAME && !self.is_phalanx_log {
                    self.is_phalanx_log = true;
                    self.summary.metadata = found.metadata;
                } else if found.name == SUBJECTS_RECORD.0 && self.subjects.is_none() {
                    self.subjects = found.metadata.remove(SUBJECTS_RECORD.1);
                }
            }
            Ok(Record::Attachment { header, data, .. }) => {
                if header.media_type == ATTACHMENT_MEDIA_TYPE && self.summary.scene.is_none() {
                    self.summary.scene = Some((header.name, String::from_utf8_lossy(&data).into_owned()));
                    self.scene_offset = offset;
                }
            }
            // Samples do not depend on the attachment.
            Err(defect) if opcode == op::ATTACHMENT => {
                let reason = format!("the log is damaged at byte {offset}: {}", defect.reason);
                self.summary.losses.push(Loss::of_scene(offset, &reason));
            }
            Ok(Record::Chunk { header, .. }) => self.chunk(offset, &header, data, chunk_reader)?,
            Ok(Record::Message { header, .. }) => {
                self.count(&header);
                self.add_bare_message(offset, (RECORD_HEAD + data.len()) as u64, header.log_time);
            }
            Ok(definition) => self.add_definition(definition, data.len())?,
            Err(defect) => return Err(defect),
        }
        Ok(())
    }

    /// Validates a chunk completely and adds it to the index.
    fn chunk(
        &mut self,
        offset: u64,
        header: &ChunkHeader,
        body: &[u8],
        reader: &mut LinearReader,
    ) -> Result<(), Defect> {
        if header.uncompressed_size > MAX_RECORD_BYTES as u64 {
            return Err(McapError::ChunkTooLarge(header.uncompressed_size).into());
        }
        let mut chunk = empty_chunk(offset);
        chunk.chunk_length = (RECORD_HEAD + body.len()) as u64;
        chunk.compression.clone_from(&header.compression);
        (chunk.compressed_size, chunk.uncompressed_size) = (header.compressed_size, header.uncompressed_size);
        let target = reader.insert(RECORD_HEAD + body.len());
        target[0] = op::CHUNK;
        target[1..RECORD_HEAD].copy_from_slice(&(body.len() as u64).to_le_bytes());
        target[RECORD_HEAD..].copy_from_slice(body);
        reader.notify_read(RECORD_HEAD + body.len());
        let mut size = 0;
        while let Some(LinearReadEvent::Record { opcode, data }) = reader.next_event().transpose()? {
            size += (RECORD_HEAD + data.len()) as u64;
            match parse(opcode, data)? {
                Record::Message { header, .. } => {
                    self.count(&header);
                    include(&mut chunk, header.log_time);
                }
                definition => self.add_definition(definition, data.len())?,
            }
        }
        // The reader has asked for the next record.
        if size != header.uncompressed_size {
            return Err(Defect::damaged("a chunk does not have the size that it claims"));
        }
        self.summary.chunks += 1;
        // A chunk without messages is not read again.
        if chunk.message_start_time <= chunk.message_end_time {
            self.index.chunk_indexes.push(chunk);
        }
        Ok(())
    }

    fn add_bare_message(&mut self, offset: u64, length: u64, log_time_ns: u64) {
        let chunks = &mut self.index.chunk_indexes;
        let is_full = chunks.last().is_none_or(|last| last.chunk_length >= MAX_BARE_BYTES);
        if self.bare_end != offset || is_full {
            let range = empty_chunk(offset);
            self.bare_ranges.extend(range.compressed_data_offset());
            chunks.push(range);
        }
        if let Some(range) = chunks.last_mut() {
            range.chunk_length += length;
            (range.compressed_size, range.uncompressed_size) = (range.chunk_length, range.chunk_length);
            include(range, log_time_ns);
        }
        self.bare_end = offset + length;
    }

    fn count(&mut self, message: &MessageHeader) {
        let (channel, sequence) = (message.channel_id, message.sequence);
        let first = SequenceStats { messages: 0, min_sequence: sequence, max_sequence: sequence };
        let stats = self.sequences.entry(channel).or_insert(first);
        stats.messages += 1;
        (stats.min_sequence, stats.max_sequence) = (stats.min_sequence.min(sequence), stats.max_sequence.max(sequence));
    }

    /// Adds a schema or a channel; repetitions and other records are ignored.
    fn add_definition(&mut self, definition: Record<'_>, bytes: usize) -> Result<(), Defect> {
        let mcap::Summary { schemas, channels, .. } = &mut self.index;
        match definition {
            Record::Schema { header, data } if !schemas.contains_key(&header.id) => {
                let (name, encoding) = (header.name, header.encoding);
                let schema = mcap::Schema { id: header.id, name, encoding, data: data.into_owned().into() };
                schemas.insert(header.id, Arc::new(schema));
            }
            Record::Channel(found) if !channels.contains_key(&found.id) => {
                let channel = mcap::Channel {
                    id: found.id,
                    topic: found.topic,
                    schema: schemas.get(&found.schema_id).cloned(),
                    message_encoding: found.message_encoding,
                    metadata: found.metadata,
                };
                channels.insert(found.id, Arc::new(channel));
            }
            _ => return Ok(()),
        }
        self.definition_bytes += bytes;
        match self.definition_bytes > MAX_DEFINITION_BYTES {
            true => Err(Defect::damaged("schemas and channels exceed the size limit")),
            false => Ok(()),
        }
    }
}

fn empty_chunk(offset: u64) -> ChunkIndex {
    ChunkIndex {
        message_start_time: u64::MAX,
        message_end_time: 0,
        chunk_start_offset: offset,
        chunk_length: 0,
        message_index_offsets: BTreeMap::new(),
        message_index_length: 0,
        compression: String::new(),
        compressed_size: 0,
        uncompressed_size: 0,
    }
}

fn include(chunk: &mut ChunkIndex, log_time_ns: u64) {
    chunk.message_start_time = chunk.message_start_time.min(log_time_ns);
    chunk.message_end_time = chunk.message_end_time.max(log_time_ns);
}

/// Parses a record of an untrusted file. Records that are not used, such as the header and indexes, may be invalid.
fn parse(opcode: u8, data: &[u8]) -> Result<Record<'_>, Defect> {
    use op::{ATTACHMENT, CHANNEL, CHUNK, MESSAGE, METADATA, SCHEMA};
    match has_valid_lengths(opcode, data) {
        _ if ![ATTACHMENT, CHANNEL, CHUNK, MESSAGE, METADATA, SCHEMA].contains(&opcode) => {
            Ok(Record::Unknown { opcode, data: data.into() })
        }
        true => Ok(parse_record(opcode, data)?),
        false => Err(Defect::damaged("a field extends beyond its record")),
    }
}

/// Whether the strings of a record end within it. The parser of the crate reserves memory for a string before it reads
/// it, and panics on an attachment shorter than its checksum.
fn has_valid_lengths(opcode: u8, data: &[u8]) -> bool {
    // Offset and number of the strings, and number of the bytes required after them. A map is a length and strings.
    let (offset, strings, rest) = match opcode {
        op::SCHEMA => (2, 2, 4),
        op::CHANNEL => (4, 2, 4),
        op::CHUNK => (28, 1, 8),
        op::ATTACHMENT => (16, 2, 8 + 4),
        op::METADATA => (0, 1, 4),
        _ => return true,
    };
    let skip_string = |remaining: &[u8]| {
        let (length, after) = remaining.split_first_chunk()?;
        after.get(u32::from_le_bytes(*length) as usize..).map(<[u8]>::len)
    };
    let mut remaining = data.get(offset..).unwrap_or_default();
    for _ in 0..strings {
        let Some(length) = skip_string(remaining) else { return false };
        remaining = &data[data.len() - length..];
    }
    if remaining.len() < rest {
        return false;
    }
    if matches!(opcode, op::CHANNEL | op::METADATA) {
        remaining = &remaining[4..];
        while !remaining.is_empty() {
            let Some(length) = skip_string(remaining) else { return false };
            remaining = &data[data.len() - length..];
        }
    }
    // The reader of chunks must not take bytes after the records for records.
    opcode != op::CHUNK || remaining[..8] == ((remaining.len() - 8) as u64).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rejects_lengths_beyond_the_data() {
        // A string of 4 GiB, an attachment of 2^60 bytes, a metadata map of 4 GiB, records that are too short.
        let mut attachment = vec![0; 24];
        attachment.extend((1u64 << 60).to_le_bytes());
        for (opcode, data) in [
            (op::METADATA, &[255; 8][..]),
            (op::METADATA, &[0, 0, 0, 0, 255, 255, 255, 255]),
            (op::ATTACHMENT, &attachment),
            (op::ATTACHMENT, &[]),
            (op::SCHEMA, &[0; 3]),
            (op::CHUNK, &[0; 39]),
        ] {
            assert!(parse(opcode, data).is_err(), "{opcode} {data:?}");
        }
        attachment.extend([0; 4]);
        assert!(parse(op::ATTACHMENT, &attachment).is_err());
        attachment[24..32].fill(0);
        assert!(matches!(parse(op::ATTACHMENT, &attachment), Ok(Record::Attachment { .. })));
    }

    #[test]
    fn rejects_a_chunk_larger_than_its_claimed_size_in_little_memory() {
        let mut out = mcap::WriteOptions::new().create(std::io::Cursor::new(Vec::new())).expect("started");
        let in_chunk = mcap::write::PrivateRecordOptions::IncludeInChunks;
        out.write_private_record(0x80, &vec![0; (1 << 20) - RECORD_HEAD], in_chunk.into()).expect("written");
        out.finish().expect("finished");
        let bytes = out.into_inner().into_inner();
        let scan = |bytes: &[u8]| Scan::new(&mut &*bytes, bytes.len() as u64, false).expect("readable");
        assert!(scan(&bytes).damage.is_none());
        let size = bytes.windows(4).position(|part| part == b"zstd").expect("a chunk") - 16;
        for claimed in [1 << 60, 100, (1 << 20) + 9] {
            let mut changed = bytes.clone();
            changed[size..size + 8].copy_from_slice(&u64::to_le_bytes(claimed));
            assert!(scan(&changed).damage.is_some(), "{claimed}");
        }
    }
}
