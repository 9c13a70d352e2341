//! Output files of a command. All of them are checked together before any computation: no output may overwrite another
//! output, an input, or a file of another program. The files of a directory are written together.

use std::fmt::Display;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::Failure;
use super::output::escape_unsafe_chars;
pub use crate::files::FileKind;
use crate::files::{
    JSON_MARK, MARKDOWN_MARK, TEMPORARY_PREFIX, TEXT_MARK, cannot_write, check_result_file, check_target,
    refer_to_same_file, replace_file,
};
use crate::log::{ensure_replaceable, partial_name};
use crate::study::results::companion_files;

/// Page with two overlaid runs.
pub(super) const PAGE_FILE: &str = "page.html";

/// Kind of the file that a flag names; some kinds come with companion files.
#[derive(Clone, Copy, Debug)]
pub enum TargetKind {
    File(FileKind),
    /// A log with its unfinished file.
    Log,
    /// Results of a sweep with the files of its unfinished results and its study.
    Results,
}

/// A flag, its path, and the kind of file to write.
pub type Target<'a> = (&'a str, Option<&'a Path>, TargetKind);
/// A flag, its directory, and the names of files to write in it; `*` matches any text.
pub type Directory<'a> = (&'a str, Option<&'a Path>, &'a [&'a str]);

/// No directory.
pub const NO_DIRECTORY: Directory<'static> = ("", None, &[]);

/// Files written for one flag.
struct FlagFiles<'a> {
    flag: &'a str,
    path: &'a Path,
    files: Vec<PathBuf>,
    /// Name patterns of further files in the directory `path`.
    names: &'a [&'a str],
}

impl FlagFiles<'_> {
    /// Returns the first of `others` that is one of these files.
    fn find_conflict<'f>(&self, others: &'f [PathBuf]) -> Option<&'f PathBuf> {
        others.iter().find(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let is_inside = || path.parent().is_some_and(|parent| refer_to_same_file(self.path, &parent.join(".")));
            self.files.iter().any(|file| refer_to_same_file(file, path))
                || self.names.iter().any(|pattern| matches_pattern(pattern, &name)) && is_inside()
        })
    }
}

/// Checks the targets of a command and opens its output directory.
///
/// # Errors
/// Returns an error if two targets are the same file, a target is an input, a target cannot be written, or a target is
/// a file of another program. `inputs` lists the name of each input in messages and its files.
pub fn reserve(
    inputs: &[(&str, &[PathBuf])],
    targets: &[Target<'_>],
    directory: Directory<'_>,
) -> Result<Option<OutputDirectory>, Failure> {
    let mut all: Vec<FlagFiles<'_>> = Vec::new();
    for (flag, path, kind) in targets.iter().filter_map(|(flag, path, kind)| Some((*flag, (*path)?, kind))) {
        let mut files = vec![path.to_path_buf()];
        match kind {
            TargetKind::Log => files.push(partial_name(path)),
            TargetKind::Results => files.extend(companion_files(path)),
            TargetKind::File(_) => {}
        }
        all.push(FlagFiles { flag, path, files, names: &[] });
    }
    if let (flag, Some(path), names) = directory {
        let new_directories =
            path.ancestors().filter(|ancestor| !ancestor.as_os_str().is_empty() && !ancestor.is_dir());
        let exact_names = names.iter().filter(|name| !name.contains('*'));
        let files = exact_names.map(|name| path.join(name)).chain(new_directories.map(Path::to_path_buf)).collect();
        all.push(FlagFiles { flag, path, files, names });
    }
    for (index, output) in all.iter().enumerate() {
        let conflict_with_input = |(input, files): &(&str, &[PathBuf])| {
            Some((output.find_conflict(files)?.clone(), format!("{input} itself, which must not change")))
        };
        let conflict_with_output = |other: &FlagFiles<'_>| {
            let file = output.find_conflict(&other.files).or(other.find_conflict(&output.files))?;
            Some((file.clone(), format!("also the file of {} {}", other.flag, other.path.display())))
        };
        let conflict = inputs.iter().find_map(conflict_with_input);
        if let Some((file, owner)) = conflict.or_else(|| all[..index].iter().find_map(conflict_with_output)) {
            let writes = match refer_to_same_file(output.path, &file) {
                true => String::new(),
                false => format!("writes {}, which ", file.display()),
            };
            let (flag, path) = (output.flag, output.path.display());
            return Err(Failure::bad_input(format!("{flag} {path} {writes}is {owner}; give another file")));
        }
    }
    for (path, kind) in targets.iter().filter_map(|(_, path, kind)| Some(((*path)?, kind))) {
        let kind = match kind {
            TargetKind::File(kind) => *kind,
            TargetKind::Log => FileKind::Log,
            TargetKind::Results => FileKind::Results,
        };
        check_target(path, kind).map_err(Failure::bad_input)?;
        // The writer of logs replaces only logs, so --force removes another file beforehand.
        if kind == FileKind::Log && path.is_file() && ensure_replaceable(path, path).is_err() {
            fs::remove_file(path).map_err(|error| Failure::bad_input(cannot_write(path, error)))?;
        }
    }
    let (_, out, names) = directory;
    out.map(|out| OutputDirectory::open(out, names)).transpose()
}

/// Writable directory for the output files of a command.
#[derive(Debug)]
pub struct OutputDirectory {
    out: PathBuf,
    /// Directory of the files until all are complete.
    staging: tempfile::TempDir,
}

impl OutputDirectory {
    /// Creates the directory if needed. Called before any computation.
    fn open(out: &Path, names: &[&str]) -> Result<OutputDirectory, Failure> {
        let shown_path = out.display();
        if out.exists() && !out.is_dir() {
            return Err(Failure::bad_input(format!(
                "cannot write the results to {shown_path}: that is a file; remove it first or give another directory"
            )));
        }
        fs::create_dir_all(out).map_err(|error| {
            Failure::bad_input(format!(
                "cannot create the directory {shown_path}: {error}; give one where you may write"
            ))
        })?;
        let existing = list_files(out, false).unwrap_or_default();
        let mut replaced = existing.iter().filter(|file| names.iter().any(|name| matches_pattern(name, file)));
        replaced.try_for_each(|name| check_result_file(&out.join(name))).map_err(Failure::bad_input)?;
        let staging = tempfile::Builder::new().prefix(TEMPORARY_PREFIX).tempdir_in(out).map_err(|error| {
            Failure::bad_input(format!(
                "cannot write to {shown_path}: {}; give a directory where you may write",
                error.kind()
            ))
        })?;
        Ok(OutputDirectory { out: out.to_path_buf(), staging })
    }

    /// Calls `write` with a temporary directory and then moves all files to the output directory. An error of `write`
    /// leaves existing files unchanged.
    pub fn write_with(self, write: impl FnOnce(&Path) -> Result<(), Failure>) -> Result<(), Failure> {
        let staging = self.staging.path();
        let move_files = || {
            let names = list_files(staging, true).map_err(|error| write_failure(&self.out, error))?;
            // A file may have appeared during the computation.
            names.iter().try_for_each(|name| check_result_file(&self.out.join(name))).map_err(Failure::incomplete)?;
            names.iter().try_for_each(|name| {
                let target = self.out.join(name);
                move_file(&staging.join(name), &target).map_err(|error| write_failure(&target, error))
            })
        };
        // Messages name the output directory, because the temporary one is unknown to the user.
        write(staging).and_then(|()| move_files()).map_err(|Failure { message, status }| Failure {
            message: message.replace(&staging.display().to_string(), &self.out.display().to_string()),
            status,
        })
    }

    /// Writes each text to the file of its name.
    pub fn write(self, names: &[&str], texts: &[String]) -> Result<(), Failure> {
        self.write_with(|staging| names.iter().zip(texts).try_for_each(|(name, text)| save(&staging.join(name), text)))
    }
}

/// Returns whether a name matches `pattern`, in which one `*` matches any text.
fn matches_pattern(pattern: &str, name: &str) -> bool {
    pattern == name
        || pattern.split_once('*').is_some_and(|(start, end)| name.starts_with(start) && name.ends_with(end))
}

/// Moves a file to its target. If the target is a link or a pipe, the data are written through it.
fn move_file(new: &Path, target: &Path) -> io::Result<()> {
    target.parent().map_or(Ok(()), fs::create_dir_all)?;
    match fs::symlink_metadata(target) {
        Ok(found) if !found.is_file() => replace_file(target, |out| io::copy(&mut fs::File::open(new)?, out).map(drop)),
        _ => fs::rename(new, target),
    }
}

/// Lists the files of a directory, and of its subdirectories if requested, by their relative paths.
fn list_files(directory: &Path, with_subdirectories: bool) -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(directory)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        match with_subdirectories && entry.file_type()?.is_dir() {
            true => names.extend(list_files(&entry.path(), true)?.iter().map(|file| format!("{name}/{file}"))),
            false => names.push(name),
        }
    }
    names.sort();
    Ok(names)
}

/// Writes a text file atomically. Reports get the mark of phalanx. Text and JSON files are escaped like printed output,
/// because terminals may show them; pages and pictures already escape untrusted names.
pub(super) fn save(path: &Path, text: &str) -> Result<(), Failure> {
    let text = match path.extension().and_then(|extension| extension.to_str()) {
        Some("txt") => format!("{TEXT_MARK}{}", escape_unsafe_chars(text)).into(),
        Some("md") => format!("{MARKDOWN_MARK}{}", escape_unsafe_chars(text)).into(),
        Some("json") => escape_unsafe_chars(text).replacen('{', JSON_MARK, 1).into(),
        _ => std::borrow::Cow::Borrowed(text),
    };
    replace_file(path, |out| out.write_all(text.as_bytes())).map_err(|error| write_failure(path, error))
}

/// Returns the failure of a file that cannot be written.
pub(super) fn write_failure(path: &Path, error: impl Display) -> Failure {
    Failure::incomplete(cannot_write(path, error))
}
