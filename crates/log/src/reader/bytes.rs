//! Records of an MCAP file, read from bytes that nobody vouches for: every length is checked against what is there, and
//! nothing is allocated for a length that is only claimed.

use std::collections::BTreeMap;
use std::io::Read;

use lz4_flex::frame::FrameDecoder;

use super::record::{AttachmentRecord, ChannelRecord, MessageRecord, SchemaRecord};

/// Bytes that are not what they should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Malformed(pub &'static str);

const SHORT: Malformed = Malformed("a field reaches beyond its record");

/// A place in some bytes.
#[derive(Clone, Copy, Debug)]
pub struct Cursor<'a> {
    rest: &'a [u8],
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Cursor { rest: bytes }
    }

    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }

    pub fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    pub fn take(&mut self, count: u64) -> Result<&'a [u8], Malformed> {
        let count = usize::try_from(count).map_err(|_| SHORT)?;
        let (head, rest) = self.rest.split_at_checked(count).ok_or(SHORT)?;
        self.rest = rest;
        Ok(head)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        let (head, rest) = self.rest.split_first_chunk().ok_or(SHORT)?;
        self.rest = rest;
        Ok(*head)
    }

    pub fn u8(&mut self) -> Result<u8, Malformed> {
        self.array::<1>().map(|[byte]| byte)
    }

    pub fn u16(&mut self) -> Result<u16, Malformed> {
        self.array().map(u16::from_le_bytes)
    }

    pub fn u32(&mut self) -> Result<u32, Malformed> {
        self.array().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Result<u64, Malformed> {
        self.array().map(u64::from_le_bytes)
    }

    pub fn f64(&mut self) -> Result<f64, Malformed> {
        self.array().map(f64::from_le_bytes)
    }

    fn text(&mut self) -> Result<&'a str, Malformed> {
        let length = self.u32()?;
        std::str::from_utf8(self.take(length.into())?).map_err(|_| Malformed("a text is not UTF-8"))
    }

    /// A map of texts.
    fn entries(&mut self) -> Result<BTreeMap<String, String>, Malformed> {
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
    pub fn record(&mut self) -> Result<(u8, &'a [u8]), Malformed> {
        let opcode = self.u8()?;
        let length = self.u64()?;
        Ok((opcode, self.take(length)?))
    }
}

/// Name and entries of a metadata record.
pub fn metadata(body: &[u8]) -> Result<(&str, BTreeMap<String, String>), Malformed> {
    let mut cursor = Cursor::new(body);
    Ok((cursor.text()?, cursor.entries()?))
}

/// An attachment whose checksum is right.
pub fn attachment(body: &[u8]) -> Result<AttachmentRecord<'_>, Malformed> {
    let mut cursor = Cursor::new(body);
    let (log_time_ns, create_time_ns) = (cursor.u64()?, cursor.u64()?);
    let (name, media_type) = (cursor.text()?, cursor.text()?);
    let length = cursor.u64()?;
    let data = cursor.take(length)?;
    let covered = body.len() - cursor.rest().len();
    let saved = cursor.u32()?;
    if saved != 0 && saved != crc32fast::hash(&body[..covered]) {
        return Err(Malformed("the checksum of the attached scene does not match"));
    }
    Ok(AttachmentRecord { log_time_ns, create_time_ns, name, media_type, data })
}

pub fn schema(body: &[u8]) -> Result<SchemaRecord<'_>, Malformed> {
    let mut cursor = Cursor::new(body);
    let (id, name, encoding) = (cursor.u16()?, cursor.text()?, cursor.text()?);
    let length = cursor.u32()?;
    Ok(SchemaRecord { id, name, encoding, data: cursor.take(length.into())? })
}

pub fn channel(body: &[u8]) -> Result<ChannelRecord<'_>, Malformed> {
    let mut cursor = Cursor::new(body);
    let (id, schema, topic, encoding) = (cursor.u16()?, cursor.u16()?, cursor.text()?, cursor.text()?);
    Ok(ChannelRecord { id, schema, topic, encoding, metadata: cursor.entries()? })
}

pub fn message(body: &[u8]) -> Result<MessageRecord<'_>, Malformed> {
    let mut cursor = Cursor::new(body);
    Ok(MessageRecord {
        channel: cursor.u16()?,
        sequence: cursor.u32()?,
        log_time_ns: cursor.u64()?,
        publish_time_ns: cursor.u64()?,
        data: cursor.rest(),
    })
}

/// A chunk as it stands in the file.
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
    /// How it is compressed, if that is none of the ways that are read here.
    pub fn unknown_compression(&self) -> Option<&'a str> {
        (!["", "zstd", "lz4"].contains(&self.compression)).then_some(self.compression)
    }

    pub fn is_compressed(&self) -> bool {
        !self.compression.is_empty()
    }

    /// Whether there is a checksum that says what was written.
    pub fn is_sealed(&self) -> bool {
        self.crc != 0
    }

    pub fn parse(body: &'a [u8]) -> Result<Self, Malformed> {
        let mut cursor = Cursor::new(body);
        let (start_ns, end_ns, uncompressed_size) = (cursor.u64()?, cursor.u64()?, cursor.u64()?);
        let (crc, compression) = (cursor.u32()?, cursor.text()?);
        let length = cursor.u64()?;
        Ok(Chunk { start_ns, end_ns, uncompressed_size, crc, compression, data: cursor.take(length)? })
    }

    /// Its records, checked against its checksum. `out` is room to decompress into, reused; what needs more than `limit`
    /// is refused before it is tried.
    pub fn records<'b>(&self, limit: usize, out: &'b mut Vec<u8>) -> Result<&'b [u8], Malformed>
    where
        'a: 'b,
    {
        let size = usize::try_from(self.uncompressed_size).ok().filter(|&size| size <= limit);
        let size = size.ok_or(Malformed("a chunk claims to hold more than any chunk of phalanx does"))?;
        let records: &[u8] = match self.compression {
            "" => self.data,
            "zstd" => {
                out.clear();
                out.reserve(size);
                // The capacity may exceed the size; what comes out is compared with it below.
                zstd::bulk::Decompressor::new()
                    .and_then(|mut zstd| zstd.decompress_to_buffer(self.data, out))
                    .map_err(|_| Malformed("a chunk cannot be decompressed"))?;
                out
            }
            "lz4" => {
                out.clear();
                FrameDecoder::new(self.data)
                    .take(size as u64 + 1)
                    .read_to_end(out)
                    .map_err(|_| Malformed("a chunk cannot be decompressed"))?;
                out
            }
            _ => return Err(Malformed("a chunk is compressed in a way that phalanx does not read")),
        };
        if records.len() != size {
            return Err(Malformed("a chunk is not of the size that it claims"));
        }
        if self.crc != 0 && self.crc != crc32fast::hash(records) {
            return Err(Malformed("the checksum of a chunk does not match"));
        }
        Ok(records)
    }
}

/// No record or chunk of a log is larger, compressed or not: sixty times what phalanx writes.
pub const LARGEST_RECORD: usize = 16 << 20;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_that_are_only_claimed_are_refused() {
        assert_eq!(Cursor::new(&[0; 3]).u32(), Err(SHORT));
        assert_eq!(Cursor::new(&[1; 16]).take(1 << 60), Err(SHORT));
        // A text of 4 GiB, an attachment of 2^60 bytes, a metadata map of 4 GiB.
        assert_eq!(metadata(&[255; 8]), Err(SHORT));
        let mut body = vec![0; 24];
        body.extend((1u64 << 60).to_le_bytes());
        assert!(attachment(&body).is_err());
        assert!(attachment(&[]).is_err());
        assert_eq!(metadata(&[0, 0, 0, 0, 255, 255, 255, 255]), Err(SHORT));
    }

    #[test]
    fn a_chunk_that_grows_beyond_its_claim_is_refused() {
        let bomb = zstd::bulk::compress(&vec![0; 1 << 20], 1).expect("compressed");
        let chunk = |claim| Chunk {
            start_ns: 0,
            end_ns: 0,
            uncompressed_size: claim,
            crc: 0,
            compression: "zstd",
            data: &bomb,
        };
        let mut out = Vec::new();
        assert!(chunk(1 << 60).records(1 << 24, &mut out).is_err());
        assert!(chunk(100).records(1 << 24, &mut out).is_err());
        assert!(out.capacity() < 1 << 16, "{}", out.capacity());
        assert_eq!(chunk(1 << 20).records(1 << 24, &mut out).map(<[u8]>::len), Ok(1 << 20));
    }
}
