//! Log files. Invalid paths are rejected before a simulation starts. An older log is replaced only by a complete one.
//!
//! A log grows as `NAME.partial` next to its target and is renamed to the target when finished. If a run is interrupted
//! (killed, disk full), the older log is unchanged and the partial one is readable up to its last chunk.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use fs4::FileExt;
use fs4::TryLockError;

use super::metadata::{METADATA_NAME, RunInfo};
use super::threaded::ThreadedWriter;
use phalanx_core::trace::SinkError;

/// Bytes at the start of a log that identify its writer.
const HEAD_BYTES: u64 = 4096;

/// Error while creating a log file.
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
        "cannot write the log {path}: {existing} exists and is not an MCAP log written by phalanx, so it is not replaced; remove it first or give \
         another path"
    )]
    NotPhalanxLog { path: PathBuf, existing: PathBuf },
    #[error(
        "cannot write the log {path}: another run is writing it (to {partial}); wait for that run or give another path"
    )]
    Busy { path: PathBuf, partial: PathBuf },
    #[error("cannot write the log {path}: {source}; give a writable path, or make this one writable")]
    Create {
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    #[error(transparent)]
    Start(#[from] SinkError),
}

/// The file of a log that is being written.
#[derive(Debug)]
#[must_use = "a finished log gets its final name only by `commit`"]
pub struct LogFile {
    file: File,
    /// Partial and final path; `None` for a target that cannot be replaced, such as a pipe or a device.
    destination: Option<(PathBuf, PathBuf)>,
    /// Name for error messages.
    name: String,
    /// Whether a write has failed: nothing may be written after the missing bytes.
    has_failed: bool,
}

impl LogFile {
    /// Opens the file of a log for writing.
    ///
    /// A target that is not a regular file is written directly. An abandoned partial log is replaced. An advisory lock
    /// prevents two runs from writing the same log.
    ///
    /// # Errors
    /// Returns [`LogError`] with the path, the reason and a remedy.
    pub fn open(path: &Path) -> Result<Self, LogError> {
        if path.is_dir() || path.to_string_lossy().ends_with(std::path::is_separator) {
            return Err(LogError::IsDirectory { path: path.to_path_buf(), suggestion: path.join("run.mcap") });
        }
        if let Some(directory) = path.parent().filter(|parent| !parent.as_os_str().is_empty() && !parent.exists()) {
            return Err(LogError::NoDirectory { path: path.to_path_buf(), directory: directory.to_path_buf() });
        }
        let failed = |source| LogError::Create { path: path.to_path_buf(), source };
        let name = format!("the log {}", path.display());
        if let Ok(found) = fs::metadata(path) {
            // Without write permission the older log must not be replaced, even if the directory allows it.
            let file = OpenOptions::new().write(true).open(path).map_err(failed)?;
            if !found.is_file() {
                return Ok(LogFile { file, destination: None, name, has_failed: false });
            }
            ensure_replaceable(path, path)?;
        }
        let (partial, target) = (partial_name(path), resolve_link(path).map_err(failed)?);
        ensure_replaceable(path, &partial)?;
        let file = lock_partial(path, &partial)?;
        // Some file systems flush a truncated file when it is closed, but not a new one.
        if file.metadata().map_err(failed)?.len() > 0 {
            file.set_len(0).map_err(failed)?;
        }
        Ok(LogFile { file, destination: Some((partial, target)), name, has_failed: false })
    }

    /// Renames a finished log to its target. The new log is synced to disk before it replaces an older one.
    pub fn commit(self) -> Result<(), SinkError> {
        let Some((partial, target)) = &self.destination else { return Ok(()) };
        let replaces = target.exists();
        let synced = if replaces { self.file.sync_all() } else { Ok(()) };
        let renamed = synced.and_then(|()| fs::rename(partial, target));
        if replaces && cfg!(unix) {
            // Makes the rename survive a power failure. Some file systems refuse this; the rename itself is done.
            let directory = target.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
            let _ = File::open(directory).and_then(|directory| directory.sync_all());
        }
        renamed.map_err(|source| SinkError { target: self.name, source })
    }
}

impl Write for LogFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.has_failed {
            return Err(io::Error::other("an earlier part of the log could not be written"));
        }
        self.file.write(bytes).inspect_err(|error| self.has_failed = error.kind() != io::ErrorKind::Interrupted)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Copies a log to a file that is opened as by [`LogFile::open`]. A log that is copied to itself is unchanged.
///
/// # Errors
/// Returns an error if the log cannot be read or the copy cannot be written.
pub fn copy_log(log: &Path, copy: &Path) -> Result<(), CopyError> {
    let mut source = File::open(log).map_err(|error| CopyError::Read { path: log.to_path_buf(), source: error })?;
    if is_same_file(&source, copy) {
        return Ok(());
    }
    let mut file = LogFile::open(copy)?;
    let target = format!("the log {}", copy.display());
    io::copy(&mut source, &mut file).map_err(|source| SinkError { target, source })?;
    Ok(file.commit()?)
}

/// Error while copying a log.
#[derive(Debug, thiserror::Error)]
pub enum CopyError {
    #[error("cannot read the log {path}: {source}")]
    Read {
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    #[error(transparent)]
    Open(#[from] LogError),
    #[error(transparent)]
    Write(#[from] SinkError),
}

/// Starts a log in a file that is opened as by [`LogFile::open`].
///
/// # Errors
/// Returns [`LogError`] with the path, the reason and a remedy.
pub fn create(path: &Path, run: &RunInfo<'_>) -> Result<FileWriter, LogError> {
    let file = LogFile::open(path)?;
    let (name, partial) = (file.name.clone(), file.destination.as_ref().map(|(partial, _)| partial.clone()));
    // A file without the head of a log is useless.
    let remove_partial = move || partial.into_iter().for_each(|partial| drop(fs::remove_file(partial)));
    FileWriter::start(file, &name, run, remove_partial).map_err(LogError::Start)
}

/// Returns the name of an unfinished log, such as `run.mcap.partial`.
pub fn partial_name(path: &Path) -> PathBuf {
    let mut name = OsString::from(resolve_link(path).unwrap_or_else(|_| path.to_path_buf()));
    name.push(".partial");
    PathBuf::from(name)
}

/// Resolves a symbolic link, so that the file it points to is replaced and the link remains.
pub fn resolve_link(path: &Path) -> io::Result<PathBuf> {
    if path.is_symlink() { fs::canonicalize(path) } else { Ok(path.to_path_buf()) }
}

/// Checks that an existing file may be replaced: only logs and partial logs of phalanx are accepted, because a mistyped
/// path must not destroy another file.
pub fn ensure_replaceable(path: &Path, existing: &Path) -> Result<(), LogError> {
    let failed = |source| LogError::Create { path: path.to_path_buf(), source };
    let other = LogError::NotPhalanxLog { path: path.to_path_buf(), existing: existing.to_path_buf() };
    match fs::metadata(existing) {
        Ok(found) if !found.is_file() => return Err(other),
        Ok(_) => {}
        Err(_) => return Ok(()),
    }
    let mut head = Vec::new();
    let file = File::open(existing).map_err(failed)?;
    file.take(HEAD_BYTES).read_to_end(&mut head).map_err(failed)?;
    // The name of phalanx is in the header. A file that ends before the name also counts.
    let has_magic = head.starts_with(mcap::MAGIC) || mcap::MAGIC.starts_with(&head);
    let named = head.windows(METADATA_NAME.len()).any(|part| part == METADATA_NAME.as_bytes());
    if has_magic && (named || head.len() <= mcap::MAGIC.len()) { Ok(()) } else { Err(other) }
}

/// Opens and locks the partial file, so that no other run writes it.
fn lock_partial(path: &Path, partial: &Path) -> Result<File, LogError> {
    let failed = |source| LogError::Create { path: path.to_path_buf(), source };
    loop {
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(partial).map_err(failed)?;
        match FileExt::try_lock(&file) {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(LogError::Busy { path: path.to_path_buf(), partial: partial.to_path_buf() });
            }
            // The file system has no locks: concurrent runs cannot be detected.
            Err(TryLockError::Error(_)) => return Ok(file),
        }
        // Between opening and locking, another run may have finished and renamed this file.
        if is_same_file(&file, partial) {
            return Ok(file);
        }
    }
}

/// Whether an open file is the file currently at this path.
#[cfg(unix)]
pub fn is_same_file(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), fs::metadata(path)) {
        (Ok(open), Ok(there)) => (open.dev(), open.ino()) == (there.dev(), there.ino()),
        _ => false,
    }
}

/// Whether the path exists: on other systems, an open file cannot be renamed.
#[cfg(not(unix))]
pub fn is_same_file(_: &File, path: &Path) -> bool {
    path.exists()
}

/// Writer of a log to a file.
pub type FileWriter = ThreadedWriter<LogFile>;

impl FileWriter {
    /// Finishes the log and renames it to its target.
    pub fn commit(self) -> Result<(), SinkError> {
        self.finish()?.commit()
    }
}
