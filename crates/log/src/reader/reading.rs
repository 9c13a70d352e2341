//! What reading a log came to: what was found, what is lost, or why there is nothing to read.

use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;

use super::Behind;
use crate::METADATA_NAME;
use phalanx_core::scene::Words;
use phalanx_core::scene::words::SceneKind;
use phalanx_core::trace::SinkError;

/// What was found in a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// Size of the file.
    pub bytes: u64,
    /// Versions, model and settings, see [`metadata`](crate::metadata()).
    pub metadata: BTreeMap<String, String>,
    /// What a log that was recovered from a damaged one says of that, see [`recover`](crate::recover()).
    pub recovered: Option<BTreeMap<String, String>>,
    /// Name and text of the attached scene.
    pub scene: Option<(String, String)>,
    pub samples: u64,
    pub events: u64,
    pub messages: u64,
    /// Channels that phalanx does not know, and messages on them.
    pub unknown_channels: u64,
    pub unknown_messages: u64,
    pub chunks: u64,
    /// Times of the first and last sample.
    pub first_s: Option<f64>,
    pub last_s: Option<f64>,
    /// How the run ended, if the log got to say.
    pub ended: Option<Ended>,
    /// Empty if the log is whole.
    pub losses: Vec<Loss>,
    /// What the log of such a run has besides.
    pub missing: Vec<Missing>,
}

impl Reading {
    pub fn is_whole(&self) -> bool {
        self.losses.is_empty()
    }

    /// Whether all is there by which the run is judged: its class, and what became of what it grasps.
    pub fn can_be_judged(&self) -> bool {
        self.samples > 0 && self.is_whole() && !self.missing.iter().any(|missing| missing.is_judged_by)
    }

    /// Of which kind the scene of the log is.
    pub fn kind(&self) -> SceneKind {
        kind(&self.metadata)
    }
}

/// A log that does not say is of a finger.
pub(super) fn kind(metadata: &BTreeMap<String, String>) -> SceneKind {
    let said = metadata.get("kind").and_then(|said| SceneKind::ALL.into_iter().find(|kind| kind.word() == said));
    said.unwrap_or(SceneKind::Finger)
}

/// How the run of a log ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    pub time_s: f64,
    /// `None` if it was completed.
    pub stopped: Option<String>,
}

impl Ended {
    pub(super) fn new(time_s: f64, line: String) -> Self {
        let stopped = match line.strip_prefix("stopped: ") {
            Some(reason) => Some(reason.to_string()),
            None if line == "completed" => None,
            None => Some(line),
        };
        Ended { time_s, stopped }
    }
}

/// Something that is not there, or not as it was written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Loss {
    /// The file ends before the log does.
    #[error("the log is truncated: it breaks off at byte {at_byte} of {bytes}{}", up_to(.last_s))]
    Truncated { at_byte: u64, bytes: u64, last_s: Option<f64> },
    /// Something is wrong; nothing behind it was used.
    #[error("the log is damaged at byte {at_byte} of {bytes}: {reason}{}; {behind}", up_to(.last_s))]
    Damaged { at_byte: u64, bytes: u64, reason: String, last_s: Option<f64>, behind: Behind },
    /// A chunk is compressed in a way that is not read; nothing behind it was used.
    #[error(
        "the chunk at byte {at_byte} of {bytes} is compressed with {compression:?}, which is not supported (zstd, lz4 and no compression \
         are){}; {behind}; compress the log anew: `mcap compress --compression zstd`",
        up_to(.last_s)
    )]
    Compressed { at_byte: u64, bytes: u64, compression: String, last_s: Option<f64>, behind: Behind },
    /// The samples are not concerned.
    #[error("the log is damaged at byte {at_byte}: {reason}; its samples are not concerned")]
    Scene { at_byte: u64, reason: String },
}

fn up_to(last_s: &Option<f64>) -> String {
    match last_s {
        Some(time_s) => format!("; it can be read up to {:.6} ms", time_s * 1e3),
        None => "; there is no sample before that".to_string(),
    }
}

/// A topic that is missing, or messages of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    pub topic: String,
    /// In words.
    pub what: String,
    pub concerns: Concerns,
    /// Whether the run cannot be judged without it: neither its class, nor what became of what it grasps.
    pub is_judged_by: bool,
}

/// What a topic says something about. Indices are those of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Concerns {
    Finger(usize),
    Body(usize),
    Contact(usize),
    Energy,
    /// The run as a whole.
    Run,
}

/// Why there is nothing to read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    #[error("there is no log {path}{hint}")]
    Missing { path: PathBuf, hint: String },
    #[error("{path} is {what}; name a log file (.mcap)")]
    NotAFile { path: PathBuf, what: &'static str },
    #[error("not an MCAP file: it does not begin as one")]
    NotMcap,
    #[error("an MCAP file, but not a log of phalanx: it has no metadata record `{METADATA_NAME}`")]
    NotPhalanx,
    #[error("a log that breaks off before it says what it is of: only {bytes} bytes are there")]
    Empty { bytes: u64 },
    #[error(
        "its messages are so far out of order that to sort them takes more than {most_mib} MiB of memory; sort the log first: `mcap sort`"
    )]
    OutOfOrder { most_mib: usize },
    #[error("cannot read: {0}")]
    Io(#[from] io::Error),
    #[error(transparent)]
    Sink(#[from] SinkError),
}
