//! Detects by its contents whether phalanx wrote a file. Only such files are replaced, so that a mistyped path destroys
//! no other file.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use super::Failure;
use crate::files::check_writable;
use crate::plot::PICTURE_MARK;
use crate::report::samples::is_samples;
use crate::report::select::is_ranking;
use crate::{log, table};

/// Kind of an output file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    Page,
    Picture,
    Log,
    /// Table of the samples of a run.
    Samples,
    /// Table of selected designs.
    Ranking,
}

/// Marker in the head of every page.
const PAGE_MARKER: &str = "<meta name=\"generator\" content=\"phalanx\">";

/// Number of bytes at the start of a file that contain its marker.
const HEAD_BYTES: u64 = 4096;

impl FileKind {
    /// Name with its article, for messages.
    fn name(self) -> &'static str {
        match self {
            FileKind::Page => "a page",
            FileKind::Picture => "a picture",
            FileKind::Log => "a log",
            FileKind::Samples => "a table of samples",
            FileKind::Ranking => "a ranking",
        }
    }

    /// Returns the kind of a file whose contents identify its writer, according to its extension.
    pub fn from_file_name(name: &str) -> Option<FileKind> {
        match name.rsplit_once('.')?.1 {
            "html" => Some(FileKind::Page),
            "svg" => Some(FileKind::Picture),
            "mcap" => Some(FileKind::Log),
            _ => None,
        }
    }

    /// Returns whether the file was written by phalanx and is of this kind. Empty files may be replaced too.
    pub fn is_written_by_phalanx(self, path: &Path) -> io::Result<bool> {
        if fs::metadata(path)?.len() == 0 {
            return Ok(true);
        }
        let head = read_head(path)?;
        Ok(match self {
            FileKind::Page => head.contains(PAGE_MARKER),
            FileKind::Picture => head.contains(PICTURE_MARK),
            FileKind::Log => log::ensure_replaceable(path, path).is_ok(),
            FileKind::Samples => is_samples(head.lines().next().unwrap_or_default()),
            FileKind::Ranking => table::read(path).is_ok_and(|table| is_ranking(&table)),
        })
    }
}

fn read_head(path: &Path) -> io::Result<String> {
    let mut bytes = Vec::new();
    File::open(path)?.take(HEAD_BYTES).read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Checks before any computation that a file can be written and that no foreign file would be replaced.
pub fn check_target(target: &Path, kind: FileKind) -> Result<(), Failure> {
    let bad_input = |reason: String| Failure::bad_input(format!("cannot write {}: {reason}", target.display()));
    check_writable(target).map_err(bad_input)?;
    // Pipes and devices are written to directly and must not be read.
    let is_file = fs::metadata(target).is_ok_and(|metadata| metadata.is_file());
    let unreadable =
        |error: io::Error| bad_input(format!("the existing file cannot be read ({error}); give another name"));
    if is_file && !kind.is_written_by_phalanx(target).map_err(unreadable)? {
        return Err(bad_input(format!(
            "the existing file is not {} written by phalanx, so it is not replaced; give another name, or delete it first",
            kind.name()
        )));
    }
    Ok(())
}
