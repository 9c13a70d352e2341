//! Result of reading a log: contents, losses, or an error.

use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;

use super::IntactChunks;
use crate::METADATA_NAME;
use phalanx_core::scene::Keyword;
use phalanx_core::scene::keywords::SceneKind;
use phalanx_core::trace::SinkError;

/// Contents and losses of a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogSummary {
    /// Size of the file, in bytes.
    pub bytes: u64,
    /// Versions, model and settings, see [`metadata`](crate::metadata()).
    pub metadata: BTreeMap<String, String>,
    /// Metadata record of a recovered log, see [`recover`](crate::recover()).
    pub recovered: Option<BTreeMap<String, String>>,
    /// Name and text of the attached scene.
    pub scene: Option<(String, String)>,
    pub samples: u64,
    pub events: u64,
    pub messages: u64,
    /// Channels unknown to phalanx.
    pub unknown_channels: u64,
    /// Messages on unknown channels.
    pub unknown_messages: u64,
    pub chunks: u64,
    /// Time of the first sample.
    pub first_s: Option<f64>,
    /// Time of the last sample.
    pub last_s: Option<f64>,
    /// How the run ended, if the log contains it.
    pub run_end: Option<RunEnd>,
    /// Missing and invalid parts; empty if the log is complete.
    pub losses: Vec<Loss>,
    /// Data that a log of such a run should contain.
    pub missing: Vec<MissingData>,
}

impl LogSummary {
    pub fn is_complete(&self) -> bool {
        self.losses.is_empty()
    }

    /// Whether the log contains all data for the class of the run and the fate of the grasped object.
    pub fn supports_verdict(&self) -> bool {
        self.samples > 0 && self.is_complete() && !self.missing.iter().any(|missing| missing.is_required_for_verdict)
    }

    /// Kind of the logged scene.
    pub fn kind(&self) -> SceneKind {
        kind(&self.metadata)
    }
}

/// Returns the kind of the logged scene. Returns `Finger` if the metadata has no valid `kind`.
pub(super) fn kind(metadata: &BTreeMap<String, String>) -> SceneKind {
    let kind = metadata
        .get("kind")
        .and_then(|kind_entry| SceneKind::ALL.into_iter().find(|scene_kind| scene_kind.keyword() == kind_entry));
    kind.unwrap_or(SceneKind::Finger)
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
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Loss {
    /// The file ends before the end of the log.
    #[error("the log is truncated at byte {at_byte} of {bytes}{}", format_readable_range(.last_s))]
    Truncated { at_byte: u64, bytes: u64, last_s: Option<f64> },
    /// The file contains invalid data.
    #[error("the log is damaged at byte {at_byte} of {bytes}: {reason}{}; {intact}", format_readable_range(.last_s))]
    Damaged { at_byte: u64, bytes: u64, reason: String, last_s: Option<f64>, intact: IntactChunks },
    /// A chunk has an unsupported compression.
    #[error(
        "the chunk at byte {at_byte} of {bytes} is compressed with {compression:?}, which is not supported (zstd, lz4 and no compression \
         are){}; {intact}; recompress the log: `mcap compress --compression zstd`",
        format_readable_range(.last_s)
    )]
    UnsupportedCompression { at_byte: u64, bytes: u64, compression: String, last_s: Option<f64>, intact: IntactChunks },
    /// The attached scene is damaged; samples are not affected.
    #[error("the log is damaged at byte {at_byte}: {reason}; its samples are not affected")]
    Scene { at_byte: u64, reason: String },
}

fn format_readable_range(last_s: &Option<f64>) -> String {
    match last_s {
        Some(time_s) => format!("; it is readable up to {:.6} ms", time_s * 1e3),
        None => "; it has no sample before that".to_string(),
    }
}

/// A topic that is missing or lacks messages.
#[derive(Clone, Debug, PartialEq)]
pub struct MissingData {
    pub topic: String,
    /// Predicate of a sentence about the topic, such as "has no message".
    pub defect: String,
    pub subject: TopicSubject,
    /// Whether the class of the run and the fate of the grasped object depend on it.
    pub is_required_for_verdict: bool,
}

/// Subject of a topic. Indices are those of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TopicSubject {
    Finger(usize),
    Body(usize),
    Contact(usize),
    Energy,
    /// The whole run.
    Run,
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
    #[error("the log is truncated before its metadata: it has only {bytes} bytes")]
    Empty { bytes: u64 },
    #[error("sorting its messages by time needs more than {limit_mib} MiB of memory; sort the log first: `mcap sort`")]
    OutOfOrder { limit_mib: usize },
    #[error("cannot read: {0}")]
    Io(#[from] io::Error),
    #[error(transparent)]
    Sink(#[from] SinkError),
}
