//! Log files: refusals come before a simulation starts, not after it; an older log gives way only to a whole one.
//!
//! A log grows as `NAME.partial` beside its target and takes the target's name when it is finished. What ends a run in
//! between (a kill, a full disk) leaves the older log as it was, and the partial one readable up to its last chunk.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use fs4::FileExt;
use fs4::TryLockError;

use super::beside::Beside;
use super::core::Feed;
use super::metadata::{METADATA_NAME, RunInfo};
use phalanx_core::trace::SinkError;

/// As much of a log as says whose it is.
const HEAD_BYTES: u64 = 4096;

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
        "cannot write the log {path}: {taken} exists and is not an MCAP log that phalanx wrote, so it is left alone; remove it first or give \
         another path"
    )]
    NotALog { path: PathBuf, taken: PathBuf },
    #[error(
        "cannot write the log {path}: another run is writing it (to {partial}); wait for that run or give another path"
    )]
    Busy { path: PathBuf, partial: PathBuf },
    #[error("cannot write the log {path}: {source}; give a path where you may write, or free the one you gave")]
    Create {
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    #[error(transparent)]
    Start(#[from] SinkError),
}

/// A file that a log is being written to.
#[derive(Debug)]
#[must_use = "a finished log takes the name it was meant for only by `keep`"]
pub struct LogFile {
    /// `None`: nowhere. A run that is only watched writes its log all the same, so that there is one way to do it.
    file: Option<File>,
    /// Where the bytes go until the log is finished, and where it belongs then; `None` for what cannot be replaced, such
    /// as a pipe or a device.
    place: Option<Place>,
    /// What has been asked for, for messages.
    name: String,
    /// A write has failed: nothing may follow what is missing.
    broken: bool,
}

#[derive(Debug)]
struct Place {
    partial: PathBuf,
    target: PathBuf,
}

impl LogFile {
    /// Opens a log's file for writing.
    ///
    /// A target that is not a regular file is written directly. A partial log that nobody writes any more is replaced; an
    /// advisory lock on it keeps two runs apart.
    ///
    /// # Errors
    /// [`LogError`] with the path, the reason and the way out.
    pub fn open(path: &Path) -> Result<Self, LogError> {
        if path.is_dir() || path.to_string_lossy().ends_with(std::path::is_separator) {
            return Err(LogError::IsDirectory { path: path.to_path_buf(), suggestion: path.join("run.mcap") });
        }
        if let Some(directory) = path.parent().filter(|parent| !parent.as_os_str().is_empty() && !parent.exists()) {
            return Err(LogError::NoDirectory { path: path.to_path_buf(), directory: directory.to_path_buf() });
        }
        let failed = |source| LogError::Create { path: path.to_path_buf(), source };
        let name = format!("the log {}", path.display());
        match fs::metadata(path) {
            Ok(found) if !found.is_file() => {
                let file = OpenOptions::new().write(true).open(path).map_err(failed)?;
                return Ok(LogFile { file: Some(file), place: None, name, broken: false });
            }
            Ok(_) => {
                // Who may not write the older log may not replace it either, whatever the directory allows.
                OpenOptions::new().write(true).open(path).map_err(failed)?;
                refuse_other_files(path, path)?;
            }
            Err(_) => {}
        }
        let target = behind_link(path).map_err(failed)?;
        let partial = partial_name(path);
        refuse_other_files(path, &partial)?;
        let file = claim(path, &partial)?;
        // A file that has been emptied is flushed when it is closed, on some file systems: a new one need not be.
        if file.metadata().map_err(failed)?.len() > 0 {
            file.set_len(0).map_err(failed)?;
        }
        Ok(LogFile { file: Some(file), place: Some(Place { partial, target }), name, broken: false })
    }

    /// A log that nobody keeps: what is written to it goes nowhere.
    pub fn nowhere() -> Self {
        LogFile { file: None, place: None, name: "the log".to_string(), broken: false }
    }

    /// Where the log is while it is not finished; `None` if it is written directly.
    pub fn partial(&self) -> Option<&Path> {
        self.place.as_ref().map(|place| place.partial.as_path())
    }

    /// Puts a finished log in its place. Before an older one gives way, the new one is on the disk for good.
    pub fn keep(self) -> Result<(), SinkError> {
        let (Some(file), Some(Place { partial, target })) = (&self.file, &self.place) else {
            return Ok(());
        };
        let kept = match target.exists() {
            true => file.sync_all().and_then(|()| fs::rename(partial, target)).and_then(|()| sync_directory(target)),
            false => fs::rename(partial, target),
        };
        kept.map_err(|source| SinkError { what: self.name, source })
    }
}

impl Write for LogFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.broken {
            return Err(io::Error::other("an earlier part of the log could not be written"));
        }
        let Some(file) = &mut self.file else {
            return Ok(bytes.len());
        };
        file.write(bytes).inspect_err(|error| self.broken = error.kind() != io::ErrorKind::Interrupted)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), File::flush)
    }
}

/// Starts a log in a file, see [`LogFile::open`].
///
/// # Errors
/// [`LogError`] with the path, the reason and the way out.
pub fn create(path: &Path, run: &RunInfo<'_>) -> Result<FileWriter, LogError> {
    create_with_feed(Some(path), run, None)
}

/// The same, with every message handed to a feed as well; without a path, to the feed alone.
///
/// # Errors
/// [`LogError`] with the path, the reason and the way out.
pub fn create_with_feed(
    path: Option<&Path>,
    run: &RunInfo<'_>,
    feed: Option<Box<dyn Feed>>,
) -> Result<FileWriter, LogError> {
    let file = path.map_or(Ok(LogFile::nowhere()), LogFile::open)?;
    let (name, partial) = (file.name.clone(), file.partial().map(Path::to_path_buf));
    // Not even the beginning of a log: nobody has a use for it.
    let unstarted = move || partial.into_iter().for_each(|partial| drop(fs::remove_file(partial)));
    FileWriter::start(file, &name, run, feed, unstarted).map_err(LogError::Start)
}

/// Name of a log that is not finished: `run.mcap.partial`.
pub fn partial_name(path: &Path) -> PathBuf {
    let mut name = OsString::from(behind_link(path).unwrap_or_else(|_| path.to_path_buf()));
    name.push(".partial");
    PathBuf::from(name)
}

/// A link stays a link: what it points to is replaced.
pub fn behind_link(path: &Path) -> io::Result<PathBuf> {
    if path.is_symlink() { fs::canonicalize(path) } else { Ok(path.to_path_buf()) }
}

/// A slip of the hand must not cost another file: only logs, or what is left of one, are replaced.
pub fn refuse_other_files(path: &Path, taken: &Path) -> Result<(), LogError> {
    let failed = |source| LogError::Create { path: path.to_path_buf(), source };
    let other = LogError::NotALog { path: path.to_path_buf(), taken: taken.to_path_buf() };
    match fs::metadata(taken) {
        Ok(found) if !found.is_file() => return Err(other),
        Ok(_) => {}
        Err(_) => return Ok(()),
    }
    let mut head = Vec::new();
    let file = File::open(taken).map_err(failed)?;
    file.take(HEAD_BYTES).read_to_end(&mut head).map_err(failed)?;
    if is_own(&head) { Ok(()) } else { Err(other) }
}

/// Whether a file begins as our logs do: with our name in the header. One that ends before that says nothing yet.
fn is_own(head: &[u8]) -> bool {
    let begins = head.starts_with(mcap::MAGIC) || mcap::MAGIC.starts_with(head);
    let named = head.windows(METADATA_NAME.len()).any(|part| part == METADATA_NAME.as_bytes());
    begins && (named || head.len() <= mcap::MAGIC.len())
}

/// Opens the partial file and locks it, so that it belongs to this run alone.
fn claim(path: &Path, partial: &Path) -> Result<File, LogError> {
    let failed = |source| LogError::Create { path: path.to_path_buf(), source };
    loop {
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(partial).map_err(failed)?;
        match FileExt::try_lock(&file) {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(LogError::Busy { path: path.to_path_buf(), partial: partial.to_path_buf() });
            }
            // A file system without locks: two runs cannot be told apart there.
            Err(TryLockError::Error(_)) => return Ok(file),
        }
        // Between opening and locking, another run may have finished and moved this very file to its place.
        if is_at(&file, partial) {
            return Ok(file);
        }
    }
}

/// Whether an open file is the one at this path, and not one that was there before.
#[cfg(unix)]
pub fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), fs::metadata(path)) {
        (Ok(open), Ok(there)) => (open.dev(), open.ino()) == (there.dev(), there.ino()),
        _ => false,
    }
}

/// Elsewhere an open file is not moved away.
#[cfg(not(unix))]
pub fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

/// Makes a rename last through a loss of power, where directories can be synced.
fn sync_directory(path: &Path) -> io::Result<()> {
    if cfg!(unix) {
        let directory = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        // Some file systems refuse this; the rename itself is done.
        let _ = File::open(directory).and_then(|directory| directory.sync_all());
    }
    Ok(())
}

/// A log that goes to a file.
pub type FileWriter = Beside<LogFile>;

impl FileWriter {
    /// Finishes the log and puts it in its place.
    pub fn keep(self) -> Result<(), SinkError> {
        self.finish()?.keep()
    }
}
