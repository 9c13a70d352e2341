//! Atomic output files: written to a temporary file in the same directory, then renamed.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf, absolute, is_separator};

use fs4::{FileExt, TryLockError};

use crate::log::{is_same_file, resolve_link};

/// Affixes of the names of temporary files and directories, with six random characters between them.
const TEMPORARY_AFFIXES: (&str, &str) = (".phalanx-", ".tmp");

/// Writes a file with `fill` and replaces an existing file atomically.
///
/// An existing file stays unchanged until the new one is completely on disk, and after an error. Devices and pipes
/// cannot be replaced and are written directly. A link remains; its target is replaced.
pub fn replace_file(path: &Path, fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>) -> io::Result<()> {
    if is_special(path) {
        let mut out = BufWriter::new(OpenOptions::new().write(true).open(path)?);
        fill(&mut out)?;
        return out.flush();
    }
    let target = resolve_link(path)?;
    let mut out = BufWriter::new(create_temporary(&target)?);
    fill(&mut out).map_err(without_temporary_path)?;
    let file = out.into_inner().map_err(|error| without_temporary_path(error.into_error()))?;
    file.as_file().sync_all()?;
    file.persist(&target).map_err(|error| error.error)?;
    Ok(())
}

/// Reads a file; `None` if it is larger than `max_bytes`. The limit also stops endless devices.
pub fn read_at_most(path: &Path, max_bytes: u64) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(max_bytes + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= max_bytes).then_some(bytes))
}

/// A writer that computes the checksum (CRC-32) of the written bytes, which avoids reading the file again.
pub struct ChecksumWriter<'a> {
    out: &'a mut (dyn Write + Send),
    crc: crc32fast::Hasher,
    bytes: u64,
}

impl<'a> ChecksumWriter<'a> {
    pub fn new(out: &'a mut (dyn Write + Send)) -> Self {
        ChecksumWriter { out, crc: crc32fast::Hasher::new(), bytes: 0 }
    }

    /// Returns the number of written bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Returns the checksum of all written bytes.
    pub fn crc(&self) -> u32 {
        self.crc.clone().finalize()
    }
}

impl Write for ChecksumWriter<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.crc.update(&bytes[..count]);
        self.bytes += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Returns the checksum (CRC-32) of the first `max_bytes` bytes of a file, and the number of bytes read.
pub fn checksum(path: &Path, max_bytes: u64) -> io::Result<(u32, u64)> {
    let mut hasher = crc32fast::Hasher::new();
    let mut file = File::open(path)?.take(max_bytes);
    let mut buffer = vec![0; 1 << 16];
    let mut read = 0;
    loop {
        match file.read(&mut buffer) {
            Ok(0) => return Ok((hasher.finalize(), read)),
            Ok(count) => {
                hasher.update(&buffer[..count]);
                read += count as u64;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

/// Checks that a file can be written to a path, without changing an existing file.
///
/// # Errors
/// Returns an error if the path is a directory, its directory does not exist, or the directory is not writable.
pub fn check_writable(path: &Path) -> Result<(), String> {
    let text = path.to_string_lossy();
    if path.is_dir() || text.ends_with(is_separator) || text.ends_with("/.") || path.file_name().is_none() {
        return Err("that is a directory; give the name of a file in it".to_string());
    }
    if let Some(directory) = path.parent().filter(|parent| !parent.as_os_str().is_empty() && !parent.exists()) {
        let directory = directory.display();
        return Err(format!(
            "the directory {directory} does not exist; create it first (mkdir -p {directory}) or give another path"
        ));
    }
    // Pipes and devices are written directly.
    if is_special(path) {
        return Ok(());
    }
    let created = resolve_link(path).and_then(|target| create_temporary(&target).map(drop));
    created.map_err(|error| format!("{error}; give a file in a directory where you may write"))
}

/// Whether two paths refer to the same file, existing or not. Compares resolved paths and file identities (hard links),
/// and ignores case on case-insensitive file systems. Pipes and devices are not overwritten and never count as the
/// same.
pub fn refer_to_same_file(first: &Path, second: &Path) -> bool {
    if is_special(first) || is_special(second) {
        return false;
    }
    let [first, second] = [first, second].map(canonical_path);
    let lower = |path: &Path| path.to_string_lossy().to_lowercase();
    let ignores_case = || {
        create_temporary(&first).is_ok_and(|temporary| {
            let name = temporary.path().file_name().unwrap_or_default().to_string_lossy().to_uppercase();
            temporary.path().with_file_name(name).exists()
        })
    };
    first == second
        || cfg!(unix) && File::open(&first).is_ok_and(|file| is_same_file(&file, &second))
        || first.parent() == second.parent() && lower(&first) == lower(&second) && ignores_case()
}

/// Resolves links and dots in the existing part of a path.
fn canonical_path(path: &Path) -> PathBuf {
    let path = absolute(path).unwrap_or_else(|_| path.to_path_buf());
    fs::canonicalize(&path).unwrap_or_else(|_| match (path.parent(), path.file_name()) {
        (Some(parent), Some(name)) => canonical_path(parent).join(name),
        _ => path,
    })
}

/// Whether a path is a pipe or a device.
pub fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

/// Creates a temporary file in the directory of `target`. It is removed unless it is renamed to `target`.
fn create_temporary(target: &Path) -> io::Result<tempfile::NamedTempFile> {
    let directory = target.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = target.file_name().map(PathBuf::from).unwrap_or_default();
    let prefix = format!(".{}{}", name.display(), TEMPORARY_AFFIXES.0);
    remove_stale(directory, &prefix);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(TEMPORARY_AFFIXES.1);
    // Temporary files are private by default; results get the permissions of the umask.
    #[cfg(unix)]
    let permissions = std::os::unix::fs::PermissionsExt::from_mode(0o666);
    #[cfg(unix)]
    builder.permissions(permissions);
    loop {
        let file = builder.tempfile_in(directory).map_err(without_temporary_path)?;
        if is_claimed(file.as_file(), file.path()) {
            return Ok(file);
        }
    }
}

/// A directory for files until they are moved to their targets. It is locked while it exists and removed with its
/// contents.
#[derive(Debug)]
pub struct StagingDirectory {
    directory: tempfile::TempDir,
    /// Dropped after the directory is removed.
    _lock: Option<File>,
}

impl StagingDirectory {
    /// Creates a staging directory in `parent`.
    pub fn create_in(parent: &Path) -> io::Result<Self> {
        remove_stale(parent, TEMPORARY_AFFIXES.0);
        loop {
            let directory =
                tempfile::Builder::new().prefix(TEMPORARY_AFFIXES.0).suffix(TEMPORARY_AFFIXES.1).tempdir_in(parent)?;
            let lock = File::open(directory.path()).ok();
            if lock.as_ref().is_none_or(|lock| is_claimed(lock, directory.path())) {
                return Ok(StagingDirectory { directory, _lock: lock });
            }
        }
    }

    pub fn path(&self) -> &Path {
        self.directory.path()
    }
}

/// Locks a new temporary file until the process ends. Returns false if another process has removed it as stale in the
/// meantime. File systems without locks never report a file as stale.
fn is_claimed(file: &File, path: &Path) -> bool {
    !matches!(FileExt::try_lock(file), Err(TryLockError::WouldBlock)) && is_same_file(file, path)
}

/// Removes temporary files and directories of killed processes, which can be locked.
fn remove_stale(directory: &Path, prefix: &str) {
    for entry in fs::read_dir(directory).into_iter().flatten().flatten() {
        let (name, path) = (entry.file_name(), entry.path());
        let random = name.to_str().and_then(|name| name.strip_prefix(prefix)?.strip_suffix(TEMPORARY_AFFIXES.1));
        let is_temporary = random.is_some_and(|random| random.len() == 6 && random.chars().all(char::is_alphanumeric));
        let Some(kind) = entry.file_type().ok().filter(|kind| is_temporary && !kind.is_symlink()) else { continue };
        let Ok(file) = File::open(&path) else { continue };
        if FileExt::try_lock(&file).is_ok() {
            // It may have been removed already, and a remaining file is harmless.
            let _ = if kind.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
        }
    }
}

/// Removes the path of the temporary file from an error.
pub fn without_temporary_path(error: io::Error) -> io::Error {
    let inner = error.get_ref().and_then(|outer| outer.source()?.downcast_ref::<io::Error>());
    inner.and_then(io::Error::raw_os_error).map_or(error, io::Error::from_raw_os_error)
}
