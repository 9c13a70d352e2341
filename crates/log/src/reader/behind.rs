//! Chunks that can still be read behind a damage, found by looking for their beginnings byte by byte.

use std::fmt;
use std::io::{self, Read, Seek, SeekFrom};

use mcap::records::op;

use super::bytes::LARGEST_RECORD;
use super::bytes::{Chunk, Cursor};

/// What lies behind a damage and is whole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Behind {
    pub chunks: u64,
    pub messages: u64,
    /// Time of the first and of the last message in them.
    pub first_s: f64,
    pub last_s: f64,
    /// Whether they were made use of.
    pub used: bool,
}

impl fmt::Display for Behind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (first, last) = (self.first_s * 1e3, self.last_s * 1e3);
        match self.chunks {
            0 => return write!(out, "nothing behind it can be read"),
            1 => write!(out, "behind it one chunk is whole")?,
            count => write!(out, "behind it {count} chunks are whole")?,
        }
        let used = if self.used { "which were used" } else { "which were not used" };
        write!(out, " ({} messages from {first:.6} to {last:.6} ms), {used}", self.messages)
    }
}

/// How the compression of a chunk is written: a text with its length. It tells chunks from other bytes.
const MARKS: [&[u8]; 2] = [b"\x04\0\0\0zstd", b"\x03\0\0\0lz4"];
/// Length of the longer one.
const LONGEST_MARK: usize = 8;
/// Bytes of a chunk record before its mark: opcode, length, two times, size and checksum.
const BEFORE_MARK: usize = 1 + 8 + 8 + 8 + 8 + 4;
const WINDOW: usize = 1 << 16;

/// Looks for whole chunks from byte `from` on, and shows each to `take`, with the byte where it begins; that says whether it has a use
/// for it.
///
/// Bytes can be laid out so that every one of them begins a chunk that fails only after much work: no more work is done
/// than is in proportion to the size of the file.
pub fn search<E: From<io::Error>>(
    source: &mut (impl Read + Seek),
    from: u64,
    bytes: u64,
    mut take: impl FnMut(u64, &Chunk<'_>, &[u8]) -> Result<bool, E>,
) -> Result<Behind, E> {
    let mut found = Behind::default();
    let mut work = bytes.saturating_mul(20).saturating_add(4 * LARGEST_RECORD as u64);
    let mut window = Vec::with_capacity(WINDOW);
    let (mut body, mut room) = (Vec::new(), Vec::new());
    let mut at = from;
    while at < bytes {
        source.seek(SeekFrom::Start(at))?;
        window.clear();
        source.by_ref().take(WINDOW as u64).read_to_end(&mut window)?;
        let is_mark = |at: &usize| MARKS.iter().any(|mark| window[*at..].starts_with(mark));
        let Some(place) = (0..window.len()).find(is_mark) else {
            if window.len() < WINDOW {
                break;
            }
            at += (WINDOW - LONGEST_MARK) as u64;
            continue;
        };
        let mark = at + place as u64;
        // Unless a chunk is there, go on behind this mark.
        at = mark + 1;
        let Some(start) = mark.checked_sub(BEFORE_MARK as u64).filter(|&start| start >= from) else { continue };
        source.seek(SeekFrom::Start(start))?;
        let mut head = [0; 9];
        source.read_exact(&mut head)?;
        let length = u64::from_le_bytes(std::array::from_fn(|i| head[1 + i]));
        if head[0] != op::CHUNK || length > LARGEST_RECORD as u64 || length > bytes - start - 9 {
            continue;
        }
        body.clear();
        source.by_ref().take(length).read_to_end(&mut body)?;
        let Ok(chunk) = Chunk::parse(&body) else { continue };
        let cost = length.saturating_add(chunk.uncompressed_size);
        if cost > work {
            break;
        }
        work -= cost;
        let Ok(records) = chunk.records(LARGEST_RECORD, &mut room) else { continue };
        if !take(start, &chunk, records)? {
            continue;
        }
        let (start_s, end_s) = (chunk.start_ns as f64 * 1e-9, chunk.end_ns as f64 * 1e-9);
        found.first_s = if found.chunks == 0 { start_s } else { found.first_s.min(start_s) };
        found.last_s = found.last_s.max(end_s);
        found.chunks += 1;
        found.messages += messages(records);
        at = start + 9 + length;
    }
    Ok(found)
}

/// The records of the index at the end of a file, if it is there and its checksum is right: schemas and channels stand in
/// it once more.
pub fn index(source: &mut (impl Read + Seek), bytes: u64) -> io::Result<Option<Vec<u8>>> {
    // Opcode, length, start of the index, start of its offsets, checksum; the magic of the end.
    const FOOTER: u64 = 1 + 8 + 8 + 8 + 4;
    let Some(at) = bytes.checked_sub(FOOTER + mcap::MAGIC.len() as u64) else { return Ok(None) };
    source.seek(SeekFrom::Start(at))?;
    let mut footer = [0; FOOTER as usize];
    source.read_exact(&mut footer)?;
    let mut cursor = Cursor::new(&footer);
    let Ok((op::FOOTER, body)) = cursor.record() else { return Ok(None) };
    let mut cursor = Cursor::new(body);
    let (Ok(start), Ok(_), Ok(crc)) = (cursor.u64(), cursor.u64(), cursor.u32()) else { return Ok(None) };
    if start == 0 || start >= at || at - start > LARGEST_RECORD as u64 {
        return Ok(None);
    }
    source.seek(SeekFrom::Start(start))?;
    let mut records = Vec::new();
    source.by_ref().take(at - start).read_to_end(&mut records)?;
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&records);
    hasher.update(&footer[..footer.len() - 4]);
    Ok((crc != 0 && hasher.finalize() == crc).then_some(records))
}

fn messages(records: &[u8]) -> u64 {
    let mut cursor = Cursor::new(records);
    let mut count = 0;
    while let Ok((opcode, _)) = cursor.record() {
        count += u64::from(opcode == op::MESSAGE);
    }
    count
}
