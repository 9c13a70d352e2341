//! Receiver of a log, and the result of reading it: contents, losses, or an error.

use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;

use mcap::McapError;
use prost::DecodeError;
use serde::Serialize;

use crate::METADATA_NAME;
use crate::channels::ChannelContent;
use phalanx_core::scene::Side;
use phalanx_core::trace::{Event, Recording, Sample, Schema, Sink, SinkError};

/// Receiver of the contents of a log in order of time, for all kinds of scenes.
pub trait LogSink {
    /// Receives the schema of the samples; called once, before the first sample or event.
    fn schema(&mut self, _: &Schema) -> Result<(), SinkError> {
        Ok(())
    }

    fn sample(&mut self, _: &Sample) -> Result<(), SinkError> {
        Ok(())
    }

    /// Receives an event; its contact is an index into the contacts of the schema.
    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

impl LogSink for () {}

/// Replaces the recording by the contents of the log.
impl LogSink for Recording {
    fn schema(&mut self, schema: &Schema) -> Result<(), SinkError> {
        *self = Recording::new(schema);
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        Sink::sample(self, sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        Sink::event(self, event)
    }
}

/// Contents and losses of a log.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LogSummary {
    /// Size of the file, in bytes.
    pub bytes: u64,
    /// Versions, model and settings, see [`metadata`](crate::metadata()).
    #[serde(rename = "settings")]
    pub metadata: BTreeMap<String, String>,
    /// Name and text of the attached scene.
    #[serde(skip)]
    pub scene: Option<(String, String)>,
    pub samples: u64,
    pub events: u64,
    pub messages: u64,
    /// Number of channels that are unknown to phalanx.
    pub unknown_channels: u64,
    /// Number of messages on unknown channels.
    pub unknown_messages: u64,
    #[serde(skip)]
    pub chunks: u64,
    /// Time of the first sample.
    pub first_s: Option<f64>,
    /// Time of the last sample.
    #[serde(rename = "end_s")]
    pub last_s: Option<f64>,
    /// How the run ended; `None` if the log does not contain its end.
    #[serde(skip)]
    pub run_end: Option<RunEnd>,
    /// Missing and invalid parts; empty if the log is complete.
    pub losses: Vec<Loss>,
    /// Data that a log of this kind of run should contain but does not.
    pub missing: Vec<MissingData>,
}

impl LogSummary {
    pub fn is_complete(&self) -> bool {
        self.losses.is_empty()
    }

    /// Whether the log was read to its end: only scene, metadata or index are lost.
    pub(super) fn is_read_to_end(&self) -> bool {
        self.losses.iter().all(|loss| matches!(loss.kind, LossKind::Scene | LossKind::Metadata))
    }

    /// Whether the log contains all data that determine the class of the run and the fate of the grasped object.
    pub fn supports_verdict(&self) -> bool {
        self.samples > 0 && self.is_complete() && !self.missing.iter().any(|missing| missing.is_required_for_verdict)
    }

    /// Whether the log contains all parts of its samples and all events, so that a page can draw it.
    pub fn is_drawable(&self) -> bool {
        self.missing.iter().all(|missing| missing.content == ChannelContent::Lines)
    }

    /// Number of five-bar fingers of the logged scene; 1 if the metadata has no valid number.
    pub fn finger_count(&self) -> usize {
        let count = self.metadata.get("fingers").and_then(|entry| entry.parse().ok());
        count.filter(|count| *count <= Side::BOTH.len()).unwrap_or(1)
    }
}

/// How the run of a log ended.
#[derive(Clone, Debug, PartialEq)]
pub struct RunEnd {
    pub time_s: f64,
    /// Reason for an early stop; `None` if the run was completed.
    pub stopped: Option<String>,
}

impl RunEnd {
    pub(super) fn new(time_s: f64, line: String) -> Self {
        let stopped = match line.strip_prefix("stopped: ") {
            Some(reason) => Some(reason.to_string()),
            None if line == "completed" => None,
            None => Some(line),
        };
        RunEnd { time_s, stopped }
    }
}

/// Missing or invalid part of a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Loss {
    /// Position in the file; 0 for a scene that is not in the log.
    pub at_byte: u64,
    #[serde(skip)]
    pub kind: LossKind,
    /// Sentence with position, reason and remedy.
    #[serde(rename = "what")]
    pub description: String,
}

/// Kind of a loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LossKind {
    /// The file ends before the end of the log.
    Truncated,
    /// The file contains invalid data.
    Damaged,
    /// Metadata or index are damaged; the samples are not affected.
    Metadata,
    /// A chunk has an unsupported compression.
    UnsupportedCompression,
    /// The attached scene is missing, damaged, or cannot be read; samples are not affected.
    Scene,
}

impl Loss {
    /// Describes the loss of the attached scene.
    pub(super) fn of_scene(at_byte: u64, reason: &str) -> Self {
        let description = format!(
            "{reason}; all samples and events are read, but the results that need the scene are omitted: class, criteria, \
             drawings, and a new simulation"
        );
        Loss { at_byte, kind: LossKind::Scene, description }
    }

    /// Describes a loss after samples up to `last_s`.
    pub(super) fn new(at_byte: u64, bytes: u64, defect: &Defect, last_s: Option<f64>) -> Self {
        let reason = &defect.reason;
        let readable = last_s.map_or("it has no sample before that".to_string(), |time_s| {
            format!("it is readable up to {:.6} ms", time_s * 1e3)
        });
        let description = match defect.kind {
            LossKind::Truncated => format!("the log is truncated at byte {at_byte} of {bytes}; {readable}"),
            LossKind::Damaged | LossKind::Scene => format!(
                "the log is damaged at byte {at_byte} of {bytes}: {reason}; {readable}; to extract intact parts after \
                 that: `mcap recover`"
            ),
            LossKind::Metadata => format!("the log is damaged at byte {at_byte} of {bytes}: {reason}; {readable}"),
            LossKind::UnsupportedCompression => format!(
                "the chunk at byte {at_byte} of {bytes} is compressed with {reason:?}, which is not supported (zstd, lz4 \
                 and no compression are); {readable}; recompress the log: `mcap compress --compression zstd`"
            ),
        };
        Loss { at_byte, kind: defect.kind, description }
    }
}

/// Reason why a part of a log cannot be used.
#[derive(Clone, Debug)]
pub(crate) struct Defect {
    pub kind: LossKind,
    pub reason: String,
}

impl Defect {
    pub fn damaged(reason: impl Into<String>) -> Self {
        Defect { kind: LossKind::Damaged, reason: reason.into() }
    }
}

/// Reason why reading ends early.
pub(crate) enum Stop {
    Defect(Defect),
    Error(ReadError),
}

impl From<Defect> for Stop {
    fn from(defect: Defect) -> Self {
        Stop::Defect(defect)
    }
}

impl From<DecodeError> for Stop {
    fn from(error: DecodeError) -> Self {
        Stop::Defect(Defect::damaged(format!("a message is not protobuf ({error})")))
    }
}

impl From<SinkError> for Stop {
    fn from(error: SinkError) -> Self {
        Stop::Error(error.into())
    }
}

impl From<McapError> for Defect {
    fn from(error: McapError) -> Self {
        match error {
            McapError::UnsupportedCompression(name) => {
                Defect { kind: LossKind::UnsupportedCompression, reason: name.chars().take(40).collect() }
            }
            McapError::BadDataCrc { .. } => Defect {
                kind: LossKind::Metadata,
                reason: "the checksum of the data section does not match, but all chunks are valid: the change is \
                         outside the chunks, for example in the metadata"
                    .to_string(),
            },
            McapError::BadSummaryCrc { .. } => {
                let reason = "the checksum of the index does not match".to_string();
                Defect { kind: LossKind::Metadata, reason }
            }
            McapError::BadChunkCrc { .. } => Defect::damaged("the checksum of a chunk does not match"),
            McapError::BadAttachmentCrc { .. } => Defect::damaged("the checksum of the attached scene does not match"),
            McapError::BadMagic => Defect::damaged("it does not end with the MCAP magic bytes"),
            McapError::RecordTooLarge { len, .. } => Defect::damaged(format!("a record claims {len} bytes")),
            McapError::ChunkTooLarge(len) => Defect::damaged(format!("a chunk claims {len} bytes")),
            McapError::DecompressionError(_) | McapError::Io(_) => Defect::damaged("a chunk cannot be decompressed"),
            McapError::Parse(_) => Defect::damaged("the fields of a record are invalid"),
            other => Defect::damaged(other.to_string()),
        }
    }
}

/// A topic that is missing or lacks messages.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MissingData {
    pub topic: String,
    /// Predicate of a sentence about the topic, such as "has no message".
    #[serde(rename = "what")]
    pub defect: String,
    #[serde(skip)]
    pub content: ChannelContent,
    /// Whether the class of the run or the fate of the grasped object depends on the topic.
    #[serde(rename = "withholds_criteria")]
    pub is_required_for_verdict: bool,
}

impl MissingData {
    /// Describes a topic with messages of phalanx that belong to no subject.
    pub(super) fn unreadable(topic: String) -> Self {
        let defect = "has messages of phalanx, but its name is not that of a subject; it is not read".to_string();
        MissingData { topic, defect, content: ChannelContent::Lines, is_required_for_verdict: true }
    }
}

/// Error while reading a log.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    #[error("there is no log {path}{hint}")]
    NotFound { path: PathBuf, hint: String },
    #[error("{path} is {description}; name a log file (.mcap)")]
    NotAFile { path: PathBuf, description: &'static str },
    #[error("not an MCAP file: it does not start with the MCAP magic bytes")]
    NotMcap,
    #[error("an MCAP file, but not a log of phalanx: it has no metadata record `{METADATA_NAME}`")]
    NotPhalanx,
    #[error(
        "a log of phalanx {version}, whose topics differ from those of this version ({}); read it with phalanx {version}, or \
         simulate its scene again",
        env!("CARGO_PKG_VERSION")
    )]
    OtherVersion { version: String },
    #[error("the log is truncated before its metadata: it has only {bytes} bytes")]
    Empty { bytes: u64 },
    #[error("sorting its messages by time needs more than {limit_mib} MiB of memory; sort the log first: `mcap sort`")]
    OutOfOrder { limit_mib: usize },
    #[error("cannot read: {0}")]
    Io(#[from] io::Error),
    #[error(transparent)]
    Sink(#[from] SinkError),
}
