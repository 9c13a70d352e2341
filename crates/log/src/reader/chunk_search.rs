//! Search for intact chunks after damage, byte by byte.

use std::fmt;
use std::io::{self, Read, Seek, SeekFrom};

use mcap::records::op;

use super::bytes::MAX_RECORD_BYTES;
use super::bytes::{Chunk, Cursor};

/// Intact chunks after damage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IntactChunks {
    pub chunks: u64,
    pub messages: u64,
    /// Time of the first message in these chunks.
    pub first_s: f64,
    /// Time of the last message in these chunks.
    pub last_s: f64,
    /// Whether these chunks were read.
    pub used: bool,
}

impl fmt::Display for IntactChunks {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (first, last) = (self.first_s * 1e3, self.last_s * 1e3);
        match self.chunks {
            0 => return write!(out, "nothing after that can be read"),
            1 => write!(out, "after that, one chunk is intact")?,
            count => write!(out, "after that, {count} chunks are intact")?,
        }
        let used = if self.used { "used" } else { "not used" };
        write!(out, " ({} messages from {first:.6} to {last:.6} ms; {used})", self.messages)
    }
}

/// Encoded compression names (length and string) in chunk records; used to recognize chunks.
const COMPRESSION_MARKERS: [&[u8]; 2] = [b"\x04\0\0\0zstd", b"\x03\0\0\0lz4"];
/// Length of the longer marker.
const MAX_MARKER_BYTES: usize = 8;
/// Bytes of a chunk record before its marker: opcode, length, two times, size and checksum.
const BYTES_BEFORE_MARKER: usize = 1 + 8 + 8 + 8 + 8 + 4;
/// Size of the part of the file that is searched at a time.
const WINDOW_BYTES: usize = 1 << 16;

/// Searches intact chunks from byte `from` on. `accept` receives the offset and contents of each and returns whether it
/// counts.
///
/// A malicious file can contain many chunks that fail only after much work, so the total work is limited in proportion
/// to the file size.
pub fn find_intact_chunks<E: From<io::Error>>(
    source: &mut (impl Read + Seek),
    from: u64,
    bytes: u64,
    mut accept: impl FnMut(u64, &Chunk<'_>, &[u8]) -> Result<bool, E>,
) -> Result<IntactChunks, E> {
    let mut found = IntactChunks::default();
    let mut work_budget = bytes.saturating_mul(20).saturating_add(4 * MAX_RECORD_BYTES as u64);
    let mut window = Vec::with_capacity(WINDOW_BYTES);
    let (mut body, mut decompressed) = (Vec::new(), Vec::new());
    let mut offset = from;
    while offset < bytes {
        source.seek(SeekFrom::Start(offset))?;
        window.clear();
        source.by_ref().take(WINDOW_BYTES as u64).read_to_end(&mut window)?;
        let is_marker = |offset: &usize| COMPRESSION_MARKERS.iter().any(|marker| window[*offset..].starts_with(marker));
        let Some(marker_index) = (0..window.len()).find(is_marker) else {
            if window.len() < WINDOW_BYTES {
                break;
            }
            offset += (WINDOW_BYTES - MAX_MARKER_BYTES) as u64;
            continue;
        };
        let marker = offset + marker_index as u64;
        // Continue after this marker unless an intact chunk is found.
        offset = marker + 1;
        let Some(start) = marker.checked_sub(BYTES_BEFORE_MARKER as u64).filter(|&start| start >= from) else {
            continue;
        };
        source.seek(SeekFrom::Start(start))?;
        let mut head = [0; 9];
        source.read_exact(&mut head)?;
        let length = u64::from_le_bytes(std::array::from_fn(|i| head[1 + i]));
        if head[0] != op::CHUNK || length > MAX_RECORD_BYTES as u64 || length > bytes - start - 9 {
            continue;
        }
        body.clear();
        source.by_ref().take(length).read_to_end(&mut body)?;
        let Ok(chunk) = Chunk::parse(&body) else { continue };
        let cost = length.saturating_add(chunk.uncompressed_size);
        if cost > work_budget {
            break;
        }
        work_budget -= cost;
        let Ok(records) = chunk.records(MAX_RECORD_BYTES, &mut decompressed) else { continue };
        if !accept(start, &chunk, records)? {
            continue;
        }
        let (start_s, end_s) = (chunk.start_ns as f64 * 1e-9, chunk.end_ns as f64 * 1e-9);
        found.first_s = if found.chunks == 0 { start_s } else { found.first_s.min(start_s) };
        found.last_s = found.last_s.max(end_s);
        found.chunks += 1;
        found.messages += count_messages(records);
        offset = start + 9 + length;
    }
    Ok(found)
}

/// Reads the records of the index at the end of a file, which repeats schemas and channels. Returns `None` if it is
/// missing or its checksum does not match.
pub fn read_index(source: &mut (impl Read + Seek), bytes: u64) -> io::Result<Option<Vec<u8>>> {
    // Opcode, length, start of the index, start of its offsets, checksum.
    const FOOTER: u64 = 1 + 8 + 8 + 8 + 4;
    let Some(offset) = bytes.checked_sub(FOOTER + mcap::MAGIC.len() as u64) else { return Ok(None) };
    source.seek(SeekFrom::Start(offset))?;
    let mut footer = [0; FOOTER as usize];
    source.read_exact(&mut footer)?;
    let mut cursor = Cursor::new(&footer);
    let Ok((op::FOOTER, body)) = cursor.record() else { return Ok(None) };
    let mut cursor = Cursor::new(body);
    let (Ok(start), Ok(_), Ok(crc)) = (cursor.u64(), cursor.u64(), cursor.u32()) else { return Ok(None) };
    if start == 0 || start >= offset || offset - start > MAX_RECORD_BYTES as u64 {
        return Ok(None);
    }
    source.seek(SeekFrom::Start(start))?;
    let mut records = Vec::new();
    source.by_ref().take(offset - start).read_to_end(&mut records)?;
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&records);
    hasher.update(&footer[..footer.len() - 4]);
    Ok((crc != 0 && hasher.finalize() == crc).then_some(records))
}

fn count_messages(records: &[u8]) -> u64 {
    let mut cursor = Cursor::new(records);
    let mut count = 0;
    while let Ok((opcode, _)) = cursor.record() {
        count += u64::from(opcode == op::MESSAGE);
    }
    count
}
