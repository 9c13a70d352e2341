//! Output files appear whole or not at all: written beside their place, then moved into it.

use std::fs::{self, OpenOptions};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

/// Writes a file with `fill`, in place of what was there.
///
/// Until everything is on the disk the older file stays as it is, and after an error too. What is not a regular file (a
/// device, a pipe) cannot be replaced: it is written directly. A link stays a link; what it points to is replaced.
pub fn replace(path: &Path, fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>) -> io::Result<()> {
    if fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        let mut out = BufWriter::new(OpenOptions::new().write(true).open(path)?);
        fill(&mut out)?;
        return out.flush();
    }
    let target = match path.is_symlink() {
        true => fs::canonicalize(path)?,
        false => path.to_path_buf(),
    };
    let mut out = BufWriter::new(beside(&target)?);
    fill(&mut out)?;
    let file = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.as_file().sync_all()?;
    file.persist(&target).map_err(|error| error.error)?;
    Ok(())
}

/// The bytes of a file; `None` if there are more than `most`: a device may never end.
pub fn read_at_most(path: &Path, most: u64) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    fs::File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
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
    let mut file = fs::File::open(path)?.take(most);
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

/// Whether a file could be written there, without touching one that is there.
pub fn probe(path: &Path) -> io::Result<()> {
    beside(path).map(drop)
}

/// A file of another name in the same directory, gone again unless it is given the name.
fn beside(target: &Path) -> io::Result<tempfile::NamedTempFile> {
    let directory = target.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = target.file_name().map(PathBuf::from).unwrap_or_default();
    let mut builder = tempfile::Builder::new();
    let prefix = format!(".{}.", name.display());
    builder.prefix(&prefix).suffix(".tmp");
    // Results are for everyone whom the umask lets read them; temporary files are for their maker alone otherwise.
    #[cfg(unix)]
    let permissions = std::os::unix::fs::PermissionsExt::from_mode(0o666);
    #[cfg(unix)]
    builder.permissions(permissions);
    builder.tempfile_in(directory).map_err(own_words)
}

/// The error without the name of the temporary file, which nobody asked for.
fn own_words(error: io::Error) -> io::Error {
    let inner = error.get_ref().and_then(|outer| outer.source()?.downcast_ref::<io::Error>());
    match inner.and_then(io::Error::raw_os_error) {
        Some(code) => io::Error::from_raw_os_error(code),
        None => error.kind().into(),
    }
}
