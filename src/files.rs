//! Output files: written to a temporary file beside the target, synced and renamed. An existing file is replaced only if
//! its first bytes show that phalanx wrote it.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf, absolute, is_separator};
use std::sync::atomic::{AtomicBool, Ordering};

use parquet::file::reader::{FileReader, SerializedFileReader};

use crate::log::{ensure_replaceable, is_same_file, resolve_link};
use crate::trace::schema::are_sample_columns;

/// Number of bytes at the start of a file that contain its mark: the header of a table with a thousand contacts.
const HEAD_BYTES: u64 = 1 << 20;

/// Mark in the head of every page.
const PAGE_MARK: &str = "<meta name=\"generator\" content=\"phalanx\">";
/// First line of every MuJoCo model.
pub(crate) const MODEL_MARK: &str = "<!-- MuJoCo model by phalanx -->\n";
/// First line of the text reports in a directory of results.
pub(crate) const TEXT_MARK: &str = "Report by phalanx\n\n";
/// First line of the Markdown reports in a directory of results.
pub(crate) const MARKDOWN_MARK: &str = "<!-- Report by phalanx -->\n\n";
/// Start of the JSON reports in a directory of results.
pub(crate) const JSON_MARK: &str = "{\n  \"generator\": \"phalanx\",";
/// Line in the head of every manual page.
const MANUAL_MARK: &str = "\n.TH phalanx";

/// First columns of the tables that phalanx writes, apart from samples.
const TABLE_HEADS: [&str; 9] = [
    "run,design,",
    "place,r_wc,",
    "base_m,mu_static,",
    "offset_m,form_closed_there,",
    "offset_x_m,offset_y_m,",
    "load,direction_rad,",
    "formulation,rtol,",
    "step_s,stiffness_factor,",
    "time_s,q11_rad,",
];

/// Kind of an output file, which its first bytes identify.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileKind {
    Page,
    Picture,
    /// A log, which is written to its unfinished file first.
    Log,
    Table,
    /// Results of a sweep, a table with the files of its unfinished results and its study.
    Results,
    /// A text, JSON or Markdown document in a directory of results.
    Report,
    /// A MuJoCo model.
    Model,
}

impl FileKind {
    /// Kind of a file in a directory of results, according to its extension.
    pub(crate) fn from_extension(path: &Path) -> FileKind {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("html") => FileKind::Page,
            Some("svg") => FileKind::Picture,
            Some("mcap") => FileKind::Log,
            Some("csv" | "parquet") => FileKind::Table,
            _ => FileKind::Report,
        }
    }

    /// Whether an existing file is of this kind and was written by phalanx.
    fn is_own_file(self, path: &Path) -> io::Result<bool> {
        let mut bytes = Vec::new();
        File::open(path)?.take(HEAD_BYTES).read_to_end(&mut bytes)?;
        let head = String::from_utf8_lossy(&bytes);
        Ok(match self {
            FileKind::Page => head.contains(PAGE_MARK),
            FileKind::Picture => head.starts_with("<svg") && head.contains(phalanx_show::plot::PICTURE_MARK),
            FileKind::Log => ensure_replaceable(path, path).is_ok(),
            FileKind::Table | FileKind::Results if bytes.starts_with(b"PAR1") => is_own_parquet(path),
            FileKind::Table | FileKind::Results => is_own_header(head.lines().next().unwrap_or_default()),
            FileKind::Model => head.starts_with(MODEL_MARK),
            FileKind::Report => {
                [TEXT_MARK, MARKDOWN_MARK, JSON_MARK].iter().any(|mark| head.starts_with(mark))
                    || head.contains(MANUAL_MARK)
            }
        })
    }
}

/// Whether phalanx wrote a table with this header line.
fn is_own_header(header: &str) -> bool {
    let is_comparison = header.starts_with("time_s,") && header.ends_with("_engine");
    let is_known = TABLE_HEADS.iter().any(|head| header.starts_with(head));
    is_known || is_comparison || are_sample_columns(&header.split(',').collect::<Vec<_>>())
}

/// Whether phalanx wrote a Parquet file. The root of its schema is the mark.
fn is_own_parquet(path: &Path) -> bool {
    let reader = File::open(path).ok().and_then(|file| SerializedFileReader::new(file).ok());
    reader.is_some_and(|reader| reader.metadata().file_metadata().schema().name() == "phalanx")
}

/// Whether files of other programs are replaced too (`--force`); set once, before a command starts.
pub(crate) static FORCE: AtomicBool = AtomicBool::new(false);

pub(crate) fn is_forced() -> bool {
    FORCE.load(Ordering::Relaxed)
}

/// Checks that a file of this kind can be written to a path, without changing an existing file.
///
/// # Errors
/// Returns an error if the path cannot be written, or contains a file of another kind or of another program, unless
/// [`FORCE`] is set.
pub(crate) fn check_target(path: &Path, kind: FileKind) -> Result<(), String> {
    let checked = check_writable(path).and_then(|()| check_replaceable(path, kind, "name"));
    checked.map_err(|reason| cannot_write(path, reason))
}

/// Like [`check_target`] for a table with these columns, which also replaces an older table with the same columns.
pub(crate) fn check_table_target(path: &Path, columns: &[&str]) -> Result<(), String> {
    let has_same_columns = || read_header(path).is_ok_and(|header| header == columns.join(","));
    check_target(path, FileKind::Table).or_else(|reason| if has_same_columns() { Ok(()) } else { Err(reason) })
}

/// Returns the first line of a file.
fn read_header(path: &Path) -> io::Result<String> {
    let mut bytes = Vec::new();
    File::open(path)?.take(HEAD_BYTES).read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).lines().next().unwrap_or_default().to_string())
}

/// Like [`check_target`] for a file in a directory of results, whose kind follows from its extension.
pub(crate) fn check_result_file(path: &Path) -> Result<(), String> {
    match path.is_dir() {
        true => Err("that is a directory; give another --out, or move it away".to_string()),
        false => check_replaceable(path, FileKind::from_extension(path), "--out"),
    }
    .map_err(|reason| cannot_write(path, reason))
}

/// Message for a path that cannot be written.
pub(crate) fn cannot_write(path: &Path, reason: impl std::fmt::Display) -> String {
    format!("cannot write {}: {reason}", path.display())
}

/// Checks that an existing file may be replaced. Empty files may be, and pipes and devices are written directly. Messages
/// recommend another `choice`.
fn check_replaceable(path: &Path, kind: FileKind, choice: &str) -> Result<(), String> {
    if !fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() > 0) || is_forced() {
        return Ok(());
    }
    match kind.is_own_file(path) {
        Ok(true) => Ok(()),
        Ok(false) => Err(format!(
            "the existing file is not a {} written by phalanx, so it is not replaced; give another {choice}, or replace it \
             with --force",
            if kind == FileKind::Results { "table".to_string() } else { format!("{kind:?}").to_lowercase() }
        )),
        Err(error) => Err(format!("the existing file cannot be read ({error}); give another {choice}")),
    }
}

/// Checks that a path is in an existing, writable directory and not a directory itself.
fn check_writable(path: &Path) -> Result<(), String> {
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
    if is_special(path) {
        return Ok(());
    }
    let created = resolve_link(path).and_then(|target| create_temporary(&target).map(drop));
    created.map_err(|error| format!("{error}; give a file in a directory where you may write"))
}

/// Writes a file with `fill` and replaces an existing file atomically.
///
/// An existing file stays unchanged until the new one is completely on disk, and after an error. Devices and pipes
/// cannot be replaced and are written directly. A link remains; its target is replaced.
pub(crate) fn replace_file(
    path: &Path,
    fill: impl FnOnce(&mut (dyn Write + Send)) -> io::Result<()>,
) -> io::Result<()> {
    let mut file = NewFile::create(path)?;
    fill(&mut file.out)?;
    file.commit()
}

/// A file that replaces an existing one when it is complete; see [`replace_file`].
pub(crate) struct NewFile {
    pub out: BufWriter<File>,
    /// The temporary file and its target; `None` for devices and pipes.
    replacement: Option<(tempfile::TempPath, PathBuf)>,
}

impl NewFile {
    pub(crate) fn create(path: &Path) -> io::Result<Self> {
        if is_special(path) {
            return Ok(NewFile { out: BufWriter::new(OpenOptions::new().write(true).open(path)?), replacement: None });
        }
        let target = resolve_link(path)?;
        let (file, temporary) = create_temporary(&target)?.into_parts();
        Ok(NewFile { out: BufWriter::new(file), replacement: Some((temporary, target)) })
    }

    /// Moves the complete file to its place.
    pub(crate) fn commit(mut self) -> io::Result<()> {
        self.out.flush()?;
        let Some((temporary, target)) = self.replacement else { return Ok(()) };
        self.out.get_ref().sync_all()?;
        temporary.persist(target).map_err(|error| error.error)
    }
}

/// Reads a file; `None` if it is larger than `max_bytes`. The limit also stops endless devices.
pub(crate) fn read_at_most(path: &Path, max_bytes: u64) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(max_bytes + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= max_bytes).then_some(bytes))
}

/// Whether two paths refer to the same file, existing or not. Compares resolved paths and file identities (hard links).
/// Pipes and devices are not overwritten and never count as the same.
pub(crate) fn refer_to_same_file(first: &Path, second: &Path) -> bool {
    if is_special(first) || is_special(second) {
        return false;
    }
    let [first, second] = [first, second].map(canonical_path);
    first == second || cfg!(unix) && File::open(&first).is_ok_and(|file| is_same_file(&file, &second))
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
    let prefix = format!(".{}.phalanx-", name.display());
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".tmp");
    // Temporary files are private by default; results get the permissions of the umask.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // The error contains the path of the temporary file, which means nothing to a user.
    builder.tempfile_in(directory).map_err(|error| {
        let inner = error.get_ref().and_then(|outer| outer.source()?.downcast_ref::<io::Error>());
        inner.and_then(io::Error::raw_os_error).map_or(error, io::Error::from_raw_os_error)
    })
}
