//! Output files appear whole or not at all: written beside their place, then moved into it.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf, absolute, is_separator};

use fs4::{FileExt, TryLockError};

use crate::log::{behind_link, is_at};

/// How names of temporary files and directories go on: a mark, six letters by chance, and an ending.
const TEMPORARY: (&str, &str) = (".phalanx-", ".tmp");

/// Writes a file with `fill`, in place of what was there.
///
/// Until everything is on the disk the older file stays as it is, and after an error too. What is not a regular file (a
/// device, a pipe) cannot be replaced: it is written directly. A link stays a link; what it points to is replaced.
pub fn replace(path: &Path, fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>) -> io::Result<()> {
    if is_special(path) {
        let mut out = BufWriter::new(OpenOptions::new().write(true).open(path)?);
        fill(&mut out)?;
        return out.flush();
    }
    let target = behind_link(path)?;
    let mut out = BufWriter::new(beside(&target)?);
    fill(&mut out).map_err(own_words)?;
    let file = out.into_inner().map_err(|error| own_words(error.into_error()))?;
    file.as_file().sync_all()?;
    file.persist(&target).map_err(|error| error.error)?;
    Ok(())
}

/// The bytes of a file; `None` if there are more than `most`: a device may never end.
pub fn read_at_most(path: &Path, most: u64) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= most).then_some(bytes))
}

/// Passes bytes on and keeps their checksum (CRC-32), so that nobody has to read what he has just written.
pub struct Summed<'a> {
    out: &'a mut (dyn Write + Send),
    crc: crc32fast::Hasher,
    bytes: u64,
}

impl<'a> Summed<'a> {
    pub fn new(out: &'a mut (dyn Write + Send)) -> Self {
        Summed { out, crc: crc32fast::Hasher::new(), bytes: 0 }
    }

    /// How many bytes there have been.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The checksum of all that has been written.
    pub fn crc(&self) -> u32 {
        self.crc.clone().finalize()
    }
}

impl Write for Summed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = self.out.write(bytes)?;
        self.crc.update(&bytes[..taken]);
        self.bytes += taken as u64;
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// The checksum (CRC-32) of the first `most` bytes of a file, and how many there were; read piece by piece.
pub fn checksum(path: &Path, most: u64) -> io::Result<(u32, u64)> {
    let mut hasher = crc32fast::Hasher::new();
    let mut file = File::open(path)?.take(most);
    let mut piece = vec![0; 1 << 16];
    let mut read = 0;
    loop {
        match file.read(&mut piece) {
            Ok(0) => return Ok((hasher.finalize(), read)),
            Ok(count) => {
                hasher.update(&piece[..count]);
                read += count as u64;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

/// Says why no file can be written there, without touching one that is there.
///
/// # Errors
/// The reason and the remedy.
pub fn place(path: &Path) -> Result<(), String> {
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
    let made = behind_link(path).and_then(|target| beside(&target).map(drop));
    made.map_err(|error| format!("{error}; give a file in a directory where you may write"))
}

/// Whether two paths are one file, or would be: by their resolved paths, by the file itself (hard links), and regardless of case
/// where the file system is. Pipes and devices are not overwritten, so they are never the same.
pub fn same(one: &Path, other: &Path) -> bool {
    if is_special(one) || is_special(other) {
        return false;
    }
    let [one, other] = [one, other].map(resolved);
    let lower = |path: &Path| path.to_string_lossy().to_lowercase();
    let cased = || {
        beside(&one).is_ok_and(|made| {
            let name = made.path().file_name().unwrap_or_default().to_string_lossy().to_uppercase();
            made.path().with_file_name(name).exists()
        })
    };
    one == other
        || cfg!(unix) && File::open(&one).is_ok_and(|file| is_at(&file, &other))
        || one.parent() == other.parent() && lower(&one) == lower(&other) && cased()
}

/// A path without links and dots, as far as it exists.
fn resolved(path: &Path) -> PathBuf {
    let path = absolute(path).unwrap_or_else(|_| path.to_path_buf());
    fs::canonicalize(&path).unwrap_or_else(|_| match (path.parent(), path.file_name()) {
        (Some(parent), Some(name)) => resolved(parent).join(name),
        _ => path,
    })
}

/// Whether a path is a pipe or a device.
pub fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

/// A file of another name in the same directory, gone again unless it is given the name.
fn beside(target: &Path) -> io::Result<tempfile::NamedTempFile> {
    let directory = target.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = target.file_name().map(PathBuf::from).unwrap_or_default();
    let prefix = format!(".{}{}", name.display(), TEMPORARY.0);
    remove_stale(directory, &prefix);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(TEMPORARY.1);
    // Results are for everyone whom the umask lets read them; temporary files are for their maker alone otherwise.
    #[cfg(unix)]
    let permissions = std::os::unix::fs::PermissionsExt::from_mode(0o666);
    #[cfg(unix)]
    builder.permissions(permissions);
    loop {
        let made = builder.tempfile_in(directory).map_err(own_words)?;
        if is_claimed(made.as_file(), made.path()) {
            return Ok(made);
        }
    }
}

/// A directory for files until they are moved to their places. It is locked while it exists, and removed with its contents.
#[derive(Debug)]
pub struct Staging {
    directory: tempfile::TempDir,
    /// Dropped after the directory is removed.
    _lock: Option<File>,
}

impl Staging {
    pub fn within(directory: &Path) -> io::Result<Self> {
        remove_stale(directory, TEMPORARY.0);
        loop {
            let made = tempfile::Builder::new().prefix(TEMPORARY.0).suffix(TEMPORARY.1).tempdir_in(directory)?;
            let lock = File::open(made.path()).ok();
            if lock.as_ref().is_none_or(|lock| is_claimed(lock, made.path())) {
                return Ok(Staging { directory: made, _lock: lock });
            }
        }
    }

    pub fn path(&self) -> &Path {
        self.directory.path()
    }
}

/// Locks a new temporary file until its process ends, however that ends. False if another process took it for a stale one just
/// before. A file system without locks never takes one for stale.
fn is_claimed(file: &File, path: &Path) -> bool {
    !matches!(FileExt::try_lock(file), Err(TryLockError::WouldBlock)) && is_at(file, path)
}

/// Removes temporary files and directories that a killed process left behind: those that can be locked.
fn remove_stale(directory: &Path, prefix: &str) {
    for entry in fs::read_dir(directory).into_iter().flatten().flatten() {
        let (name, path) = (entry.file_name(), entry.path());
        let between = name.to_str().and_then(|name| name.strip_prefix(prefix)?.strip_suffix(TEMPORARY.1));
        let ours = between.is_some_and(|random| random.len() == 6 && random.chars().all(char::is_alphanumeric));
        let Some(kind) = entry.file_type().ok().filter(|kind| ours && !kind.is_symlink()) else { continue };
        let Ok(file) = File::open(&path) else { continue };
        if FileExt::try_lock(&file).is_ok() {
            // It may be gone already, and one that stays harms nothing.
            let _ = if kind.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
        }
    }
}

/// The error without the name of the temporary file, which nobody asked for.
pub fn own_words(error: io::Error) -> io::Error {
    let inner = error.get_ref().and_then(|outer| outer.source()?.downcast_ref::<io::Error>());
    inner.and_then(io::Error::raw_os_error).map_or(error, io::Error::from_raw_os_error)
}
