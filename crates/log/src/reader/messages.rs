//! Second pass over a log: its messages in order of log time. Only chunks that overlap in time are
//! in memory: one or two of a log in order, all of a log sorted by topic.

use std::collections::HashSet;
use std::io::{self, Read, Seek, SeekFrom};

use mcap::records::MessageHeader;
use mcap::sans_io::indexed_reader::{IndexedReadEvent, IndexedReader, IndexedReaderOptions};

use super::scan::{MAX_RECORD_BYTES, Scan};
use super::summary::ReadError;

/// Maximum number of bytes of the chunks in memory, and also of the messages of one log time.
pub const MAX_OPEN_BYTES: usize = 1 << 29;

/// Reader of messages.
pub struct Messages<R> {
    source: R,
    reader: IndexedReader,
    bare_ranges: HashSet<u64>,
    buffer: Vec<u8>,
    /// Offset of the data of the most recently loaded chunk.
    pub chunk_offset: u64,
}

impl<R: Read + Seek> Messages<R> {
    /// Creates a reader of the messages that a scan has found.
    ///
    /// # Errors
    /// Returns [`ReadError::OutOfOrder`] if too many chunks overlap in time.
    pub fn new(source: R, scan: &Scan) -> Result<Self, ReadError> {
        let mut changes: Vec<(u64, bool, i64)> = Vec::new();
        for chunk in &scan.index.chunk_indexes {
            let bytes = chunk.uncompressed_size as i64;
            changes.extend([(chunk.message_start_time, true, bytes), (chunk.message_end_time, false, -bytes)]);
        }
        changes.sort_unstable();
        let mut open_bytes = 0;
        for (_, _, change) in changes {
            open_bytes += change;
            if open_bytes > MAX_OPEN_BYTES as i64 {
                return Err(too_much_memory());
            }
        }
        let options = IndexedReaderOptions::new().with_record_length_limit(MAX_RECORD_BYTES);
        let reader = IndexedReader::new_with_options(&scan.index, options).map_err(io::Error::other)?;
        let bare_ranges = scan.bare_ranges.clone();
        Ok(Messages { source, reader, bare_ranges, buffer: Vec::new(), chunk_offset: 0 })
    }

    /// Passes the next message to `receive`; returns `None` at the end.
    pub fn next<T>(&mut self, receive: impl FnOnce(&MessageHeader, &[u8]) -> T) -> Result<Option<T>, ReadError> {
        // All data was valid in the first pass.
        let file_changed = |_| io::Error::other("the log changes while it is read");
        while let Some(event) = self.reader.next_event() {
            match event.map_err(file_changed)? {
                IndexedReadEvent::Message { header, data } => return Ok(Some(receive(&header, data))),
                IndexedReadEvent::ReadChunkRequest { offset, length } => {
                    self.chunk_offset = match self.bare_ranges.contains(&offset) {
                        true => offset - CHUNK_HEAD,
                        false => offset,
                    };
                    self.source.seek(SeekFrom::Start(self.chunk_offset))?;
                    self.buffer.resize(length, 0);
                    self.source.read_exact(&mut self.buffer)?;
                    self.reader.insert_chunk_record_data(offset, &self.buffer).map_err(file_changed)?;
                }
            }
        }
        Ok(None)
    }
}

/// Bytes of an uncompressed chunk before its records: opcode, length, two times, size, checksum, name of the
/// compression, length of the records.
const CHUNK_HEAD: u64 = 1 + 8 + 8 + 8 + 8 + 4 + 4 + 8;

pub fn too_much_memory() -> ReadError {
    ReadError::OutOfOrder { limit_mib: MAX_OPEN_BYTES >> 20 }
}
