//! Reader of intact, truncated and damaged logs.
//!
//! A [`LogSink`] receives the samples and events of the log in order of time, up to the first missing or invalid byte.
//! If the log is in write order, this is a prefix of what was written. The summary reports what was lost, and lists
//! data that a log of such a run should contain but does not ([`MissingData`]).
//!
//! The order of messages in the file has no meaning (the MCAP specification leaves it open): the first pass validates
//! the file and locates messages, the second reads them in order of log time and reconstructs the order within one log
//! time. Framing, checksums, decompression, record parsing and the order by log time are the work of the `mcap` crate.
//!
//! The file is not trusted: lengths are compared with the available data, and at most [`MAX_RECORD_BYTES`] are loaded
//! at once unless chunks overlap in time. The reader therefore needs memory for one chunk plus about 100 bytes per
//! chunk, for a log of any length.
//!
//! | file | job |
//! |---|---|
//! | `scan` | first pass: metadata, schemas, channels and positions of messages |
//! | `messages` | second pass: messages in order of log time |
//! | `schema` | subjects of the samples |
//! | `assemble` | messages of one log time → samples and events |
//! | `missing` | data missing in the log |
//! | `summary` | contents and losses of a log, errors |

mod assemble;
mod messages;
mod missing;
mod scan;
mod schema;
mod summary;

use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::Path;

use self::assemble::Assembler;
use self::messages::Messages;
pub use self::scan::MAX_RECORD_BYTES;
use self::scan::Scan;
use self::summary::{Defect, Stop};
pub use self::summary::{LogSink, LogSummary, Loss, LossKind, MissingData, ReadError, RunEnd};
use super::file::partial_name;
use super::metadata::LOG_VERSION;

/// Reads a log file into a sink.
///
/// # Errors
/// Returns [`ReadError`] if the file is not a log of phalanx or cannot be read, or if the sink fails. A truncated or
/// damaged log is not an error: see [`LogSummary::losses`].
pub fn read_file(path: &Path, sink: &mut impl LogSink) -> Result<LogSummary, ReadError> {
    read(open_log(path)?, sink)
}

/// Opens a log file for reading.
pub fn open_log(path: &Path) -> Result<BufReader<File>, ReadError> {
    let not_a_file = |description| ReadError::NotAFile { path: path.to_path_buf(), description };
    match std::fs::metadata(path) {
        Ok(found) if found.is_dir() => return Err(not_a_file("a directory")),
        Ok(found) if !found.is_file() => return Err(not_a_file("not a regular file")),
        Ok(_) => {}
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let partial = partial_name(path);
            let hint = match partial.exists() {
                true => {
                    format!(", but there is {}, the log of an unfinished run; give that path", partial.display())
                }
                false => "; check the path".to_string(),
            };
            return Err(ReadError::NotFound { path: path.to_path_buf(), hint });
        }
        Err(error) => return Err(error.into()),
    }
    Ok(BufReader::with_capacity(1 << 16, File::open(path)?))
}

/// Reads only metadata and scene of a log file. Losses are not reported.
///
/// # Errors
/// See [`read_file`].
pub fn read_head(path: &Path) -> Result<LogSummary, ReadError> {
    Ok(scan(&mut open_log(path)?, true)?.summary)
}

/// Reads a log into a sink, see [`read_file`].
pub fn read(mut source: impl Read + Seek, sink: &mut impl LogSink) -> Result<LogSummary, ReadError> {
    let scan = scan(&mut source, false)?;
    let mut reader = SecondPass::new(source, scan)?;
    sink.schema(reader.assembler.schema())?;
    while reader.read_message(sink)? {}
    Ok(reader.assembler.finish(&reader.scan))
}

/// Second pass over a log: passes its samples and events to a sink, in order of time.
pub(super) struct SecondPass<R> {
    scan: Scan,
    messages: Messages<R>,
    pub assembler: Assembler,
}

impl<R: Read + Seek> SecondPass<R> {
    /// Creates a reader of the log that a scan has found.
    ///
    /// # Errors
    /// Returns [`ReadError::OutOfOrder`] if too many chunks overlap in time.
    pub fn new(source: R, mut scan: Scan) -> Result<Self, ReadError> {
        let assembler = Assembler::new(&mut scan);
        Ok(SecondPass { messages: Messages::new(source, &scan)?, assembler, scan })
    }

    /// Reads a message. The samples and events of a log time are passed on after the last message of this time. Returns
    /// false at the end of the log or at an invalid message.
    pub fn read_message(&mut self, sink: &mut impl LogSink) -> Result<bool, ReadError> {
        let result = self.messages.next(|header, data| self.assembler.message(header, data, &mut *sink))?;
        let is_end = result.is_none();
        match result.unwrap_or_else(|| self.assembler.end_group(sink)) {
            Ok(()) => Ok(!is_end),
            Err(Stop::Defect(defect)) => {
                self.scan.damage = Some((self.messages.chunk_offset, defect));
                Ok(false)
            }
            Err(Stop::Error(error)) => Err(error),
        }
    }
}

/// First pass over a log of phalanx.
pub(super) fn scan(source: &mut (impl Read + Seek), head_only: bool) -> Result<Scan, ReadError> {
    let bytes = source.seek(io::SeekFrom::End(0))?;
    source.rewind()?;
    let mut head = Vec::with_capacity(mcap::MAGIC.len());
    source.by_ref().take(mcap::MAGIC.len() as u64).read_to_end(&mut head)?;
    if !mcap::MAGIC.starts_with(&head) || bytes == 0 {
        return Err(ReadError::NotMcap);
    }
    source.rewind()?;
    let scan = Scan::new(source, bytes, head_only)?;
    let metadata = &scan.summary.metadata;
    match &scan.damage {
        _ if scan.is_phalanx_log && metadata.get(LOG_VERSION.0).is_none_or(|version| version != LOG_VERSION.1) => {
            let version = metadata.get("phalanx_version").map_or("unknown", String::as_str);
            Err(ReadError::OtherVersion { version: version.to_string() })
        }
        _ if scan.is_phalanx_log => Ok(scan),
        Some((_, Defect { kind: LossKind::Truncated, .. })) => Err(ReadError::Empty { bytes }),
        _ => Err(ReadError::NotPhalanx),
    }
}
