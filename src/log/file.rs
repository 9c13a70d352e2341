//! Opening a log file: refusals come before a simulation starts, not after it.

use std::fs::{File, OpenOptions};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::finger::FingerChannels;
use super::metadata::{Logged, RunInfo};
use super::writer::Writer;
use crate::trace::SinkError;

/// A log that goes to a file.
pub type FileWriter<C = FingerChannels> = Writer<File, C>;

/// Why a log could not be started.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    #[error(
        "cannot write the log {path}: the directory {directory} does not exist; create it first (mkdir -p {directory}) or \
         give another path"
    )]
    NoDirectory { path: PathBuf, directory: PathBuf },
    #[error("cannot write the log {path}: that is a directory; give the name of a file in it, such as {suggestion}")]
    IsDirectory { path: PathBuf, suggestion: PathBuf },
    #[error(
        "cannot write the log {path}: that file exists and is not an MCAP log, so it is left alone; remove it first or give \
         another path"
    )]
    NotALog { path: PathBuf },
    #[error("cannot write the log {path}: {source}; give a path where you may write, or free the one you gave")]
    Create {
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    #[error(transparent)]
    Start(#[from] SinkError),
}

/// Starts a log in a file, in place: it grows as the run goes on and can be read meanwhile. An older log of that name is
/// replaced; any other file is refused.
///
/// # Errors
/// [`LogError`] with the path, the reason and the way out.
pub fn create<S: Logged>(path: &Path, run: &RunInfo<'_, S>) -> Result<Writer<File, S::Channels>, LogError> {
    if path.is_dir() {
        return Err(LogError::IsDirectory { path: path.to_path_buf(), suggestion: path.join("run.mcap") });
    }
    if let Some(directory) = path.parent().filter(|parent| !parent.as_os_str().is_empty() && !parent.exists()) {
        return Err(LogError::NoDirectory { path: path.to_path_buf(), directory: directory.to_path_buf() });
    }
    let failed = |source| LogError::Create { path: path.to_path_buf(), source };
    if path.is_file() && !is_log_or_empty(path).map_err(failed)? {
        return Err(LogError::NotALog { path: path.to_path_buf() });
    }
    let file = OpenOptions::new().write(true).create(true).truncate(true).open(path).map_err(failed)?;
    Ok(Writer::new(file, &format!("the log {}", path.display()), run)?)
}

fn is_log_or_empty(path: &Path) -> io::Result<bool> {
    let mut head = Vec::with_capacity(mcap::MAGIC.len());
    File::open(path)?.take(mcap::MAGIC.len() as u64).read_to_end(&mut head)?;
    Ok(head.is_empty() || head == mcap::MAGIC)
}
