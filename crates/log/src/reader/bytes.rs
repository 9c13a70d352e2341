//! Parser of MCAP records for untrusted bytes: every length is checked against the available data before memory is
//! allocated.

use std::collections::BTreeMap;
use std::io::Read;

use lz4_flex::frame::FrameDecoder;

use super::record::{AttachmentRecord, ChannelRecord, MessageRecord, SchemaRecord};

/// Error for invalid data; contains the reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct MalformedData(pub &'static str);

const FIELD_OUT_OF_BOUNDS: MalformedData = MalformedData("a field extends beyond its record");

/// Position in a byte slice.
#[derive(Clone, Copy, Debug)]
pub struct Cursor<'a> {
    remaining: &'a [u8],
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Cursor { remaining: bytes }
    }

    pub fn remaining(&self) -> &'a [u8] {
        self.remaining
    }

    pub fn is_empty(&self) -> bool {
        self.remaining.is_empty()
    }

    pub fn take(&mut self, count: u64) -> Result<&'a [u8], MalformedData> {
        let count = usize::try_from(count).map_err(|_| FIELD_OUT_OF_BOUNDS)?;
        let (head, remaining) = self.remaining.split_at_checked(count).ok_or(FIELD_OUT_OF_BOUNDS)?;
        self.remaining = remaining;
        Ok(head)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], MalformedData> {
        let (head, remaining) = self.remaining.split_first_chunk().ok_or(FIELD_OUT_OF_BOUNDS)?;
        self.remaining = remaining;
        Ok(*head)
    }

    pub fn u8(&mut self) -> Result<u8, MalformedData> {
        self.array::<1>().map(|[byte]| byte)
    }

    pub fn u16(&mut self) -> Result<u16, MalformedData> {
        self.array().map(u16::from_le_bytes)
    }

    pub fn u32(&mut self) -> Result<u32, MalformedData> {
        self.array().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Result<u64, MalformedData> {
        self.array().map(u64::from_le_bytes)
    }

    pub fn f64(&mut self) -> Result<f64, MalformedData> {
        self.array().map(f64::from_le_bytes)
    }

    fn text(&mut self) -> Result<&'a str, MalformedData> {
        let length = self.u32()?;
        std::str::from_utf8(self.take(length.into())?).map_err(|_| MalformedData("a string is not UTF-8"))
    }

    /// Reads a map of strings.
    fn entries(&mut self) -> Result<BTreeMap<String, String>, MalformedData> {
        let length = self.u32()?;
        let mut list = Cursor::new(self.take(length.into())?);
        let mut entries = BTreeMap::new();
        while !list.is_empty() {
            let key = list.text()?;
            entries.insert(key.to_string(), list.text()?.to_string());
        }
        Ok(entries)
    }

    /// One record within a chunk: its opcode and body.
    pub fn record(&mut self) -> Result<(u8, &'a [u8]), MalformedData> {
        let opcode = self.u8()?;
        let length = self.u64()?;
        Ok((opcode, self.take(length)?))
    }
}

/// Parses the name and entries of a metadata record.
pub fn metadata(body: &[u8]) -> Result<(&str, BTreeMap<String, String>), MalformedData> {
    let mut cursor = Cursor::new(body);
    Ok((cursor.text()?, cursor.entries()?))
}

/// Parses an attachment and verifies its checksum.
pub fn attachment(body: &[u8]) -> Result<AttachmentRecord<'_>, MalformedData> {
    let mut cursor = Cursor::new(body);
    let (log_time_ns, create_time_ns) = (cursor.u64()?, cursor.u64()?);
    let (name, media_type) = (cursor.text()?, cursor.text()?);
    let length = cursor.u64()?;
    let data = cursor.take(length)?;
    let covered = body.len() - cursor.remaining().len();
    let stored_crc = cursor.u32()?;
    if stored_crc != 0 && stored_crc != crc32fast::hash(&body[..covered]) {
        return Err(MalformedData("the checksum of the attached scene does not match"));
    }
    Ok(AttachmentRecord { log_time_ns, create_time_ns, name, media_type, data })
}

pub fn schema(body: &[u8]) -> Result<SchemaRecord<'_>, MalformedData> {
    let mut cursor = Cursor::new(body);
    let (id, name, encoding) = (cursor.u16()?, cursor.text()?, cursor.text()?);
    let length = cursor.u32()?;
    Ok(SchemaRecord { id, name, encoding, data: cursor.take(length.into())? })
}

pub fn channel(body: &[u8]) -> Result<ChannelRecord<'_>, MalformedData> {
    let mut cursor = Cursor::new(body);
    let (id, schema, topic, encoding) = (cursor.u16()?, cursor.u16()?, cursor.text()?, cursor.text()?);
    Ok(ChannelRecord { id, schema, topic, encoding, metadata: cursor.entries()? })
}

pub fn message(body: &[u8]) -> Result<MessageRecord<'_>, MalformedData> {
    let mut cursor = Cursor::new(body);
    Ok(MessageRecord {
        channel: cursor.u16()?,
        sequence: cursor.u32()?,
        log_time_ns: cursor.u64()?,
        publish_time_ns: cursor.u64()?,
        data: cursor.remaining(),
    })
}

/// A chunk record, not yet decompressed.
#[derive(Clone, Copy, Debug)]
pub struct Chunk<'a> {
    pub start_ns: u64,
    pub end_ns: u64,
    pub uncompressed_size: u64,
    crc: u32,
    compression: &'a str,
    data: &'a [u8],
}

impl<'a> Chunk<'a> {
    /// Returns the compression if it is not supported.
    pub fn unknown_compression(&self) -> Option<&'a str> {
        (!["", "zstd", "lz4"].contains(&self.compression)).then_some(self.compression)
    }

    pub fn is_compressed(&self) -> bool {
        !self.compression.is_empty()
    }

    /// Whether the chunk has a checksum.
    pub fn has_checksum(&self) -> bool {
        self.crc != 0
    }

    pub fn parse(body: &'a [u8]) -> Result<Self, MalformedData> {
        let mut cursor = Cursor::new(body);
        let (start_ns, end_ns, uncompressed_size) = (cursor.u64()?, cursor.u64()?, cursor.u64()?);
        let (crc, compression) = (cursor.u32()?, cursor.text()?);
        let length = cursor.u64()?;
        Ok(Chunk { start_ns, end_ns, uncompressed_size, crc, compression, data: cursor.take(length)? })
    }

    /// Returns the decompressed records after verifying the checksum. `buffer` is a reused buffer. A chunk of more than
    /// `limit` bytes is rejected before decompression.
    pub fn records<'b>(&self, limit: usize, buffer: &'b mut Vec<u8>) -> Result<&'b [u8], MalformedData>
    where
        'a: 'b,
    {
        let size = usize::try_from(self.uncompressed_size).ok().filter(|&size| size <= limit);
        let size = size.ok_or(MalformedData("a chunk claims a larger size than phalanx writes"))?;
        let records: &[u8] = match self.compression {
            "" => self.data,
            "zstd" => {
                buffer.clear();
                buffer.reserve(size);
                // The capacity may exceed the size; the result is compared with the size below.
                zstd::bulk::Decompressor::new()
                    .and_then(|mut zstd| zstd.decompress_to_buffer(self.data, buffer))
                    .map_err(|_| MalformedData("a chunk cannot be decompressed"))?;
                buffer
            }
            "lz4" => {
                buffer.clear();
                FrameDecoder::new(self.data)
                    .take(size as u64 + 1)
                    .read_to_end(buffer)
                    .map_err(|_| MalformedData("a chunk cannot be decompressed"))?;
                buffer
            }
            _ => return Err(MalformedData("a chunk has an unsupported compression")),
        };
        if records.len() != size {
            return Err(MalformedData("a chunk does not have the size that it claims"));
        }
        if self.crc != 0 && self.crc != crc32fast::hash(records) {
            return Err(MalformedData("the checksum of a chunk does not match"));
        }
        Ok(records)
    }
}

/// Maximum size of a record or chunk, compressed or not: sixty times what phalanx writes.
pub const MAX_RECORD_BYTES: usize = 16 << 20;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rejects_lengths_beyond_the_data() {
        assert_eq!(Cursor::new(&[0; 3]).u32(), Err(FIELD_OUT_OF_BOUNDS));
        assert_eq!(Cursor::new(&[1; 16]).take(1 << 60), Err(FIELD_OUT_OF_BOUNDS));
        // A string of 4 GiB, an attachment of 2^60 bytes, a metadata map of 4 GiB.
        assert_eq!(metadata(&[255; 8]), Err(FIELD_OUT_OF_BOUNDS));
        let mut body = vec![0; 24];
        body.extend((1u64 << 60).to_le_bytes());
        assert!(attachment(&body).is_err());
        assert!(attachment(&[]).is_err());
        assert_eq!(metadata(&[0, 0, 0, 0, 255, 255, 255, 255]), Err(FIELD_OUT_OF_BOUNDS));
    }

    #[test]
    fn rejects_a_chunk_larger_than_its_claimed_size() {
        let compressed = zstd::bulk::compress(&vec![0; 1 << 20], 1).expect("compressed");
        let chunk = |claimed_size| Chunk {
            start_ns: 0,
            end_ns: 0,
            uncompressed_size: claimed_size,
            crc: 0,
            compression: "zstd",
            data: &compressed,
        };
        let mut buffer = Vec::new();
        assert!(chunk(1 << 60).records(1 << 24, &mut buffer).is_err());
        assert!(chunk(100).records(1 << 24, &mut buffer).is_err());
        assert!(buffer.capacity() < 1 << 16, "{}", buffer.capacity());
        assert_eq!(chunk(1 << 20).records(1 << 24, &mut buffer).map(<[u8]>::len), Ok(1 << 20));
    }
}
