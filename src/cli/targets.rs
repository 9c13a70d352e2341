//! Output files of a command. All of them are checked together before any computation: no output may overwrite another
//! output, an input, or a file of another program. The files of a directory are written together.

use std::fmt::Display;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::Failure;
use super::output::escape_unsafe_chars;
pub(crate) use crate::files::FileKind;
use crate::files::{
    JSON_MARK, MARKDOWN_MARK, TEXT_MARK, cannot_write, check_result_file, check_target, refer_to_same_file,
    replace_file,
};
use crate::log::{ensure_replaceable, partial_name};
use crate::study::results::companion_files;

/// Page with two overlaid runs.
pub(super) const PAGE_FILE: &str = "page.html";

/// Kind of the file that a flag names; some kinds come with companion files.
#[derive(Clone, Copy, Debug)]
pub(crate) enum TargetKind {
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
pub(crate) const NO_DIRECTORY: Directory<'static> = ("", None, &[]);

/// Checks the targets of a command and opens its output directory.
///
/// # Errors
/// Returns an error if two targets are the same file, a target is an input, a target cannot be written, or a target is
/// a file of another program. `inputs` lists the name of each input in messages and its files.
pub(crate) fn reserve(
    inputs: &[(&str, &[PathBuf])],
    targets: &[Target<'_>],
    directory: Directory<'_>,
) -> Result<OutputDirectory, Failure> {
    // Flag, its path, and each file that it writes.
    let mut outputs: Vec<(&str, &Path, PathBuf)> = Vec::new();
    for (flag, path, kind) in targets.iter().filter_map(|(flag, path, kind)| Some((*flag, (*path)?, kind))) {
        outputs.push((flag, path, path.to_path_buf()));
        match kind {
            TargetKind::Log => outputs.push((flag, path, partial_name(path))),
            TargetKind::Results => outputs.extend(companion_files(path).map(|file| (flag, path, file))),
            TargetKind::File(_) => {}
        }
    }
    if let (flag, Some(path), names) = directory {
        let new_directories =
            path.ancestors().filter(|ancestor| !ancestor.as_os_str().is_empty() && !ancestor.is_dir());
        let files = names.iter().map(|name| path.join(name)).chain(new_directories.map(Path::to_path_buf));
        outputs.extend(files.map(|file| (flag, path, file)));
    }
    for (index, (flag, path, file)) in outputs.iter().enumerate() {
        let is_input = |(_, files): &&(&str, &[PathBuf])| files.iter().any(|input| refer_to_same_file(input, file));
        let is_output =
            |(other, _, output): &&(&str, &Path, PathBuf)| other != flag && refer_to_same_file(output, file);
        let input = inputs.iter().find(is_input).map(|(input, _)| format!("{input} itself, which must not change"));
        let output = || outputs[..index].iter().find(is_output);
        let owner =
            input.or_else(|| output().map(|(other, path, _)| format!("also the file of {other} {}", path.display())));
        if let Some(owner) = owner {
            let writes = if *path == file { String::new() } else { format!("writes {}, which ", file.display()) };
            let path = path.display();
            return Err(Failure::bad_input(format!("{flag} {path} {writes}is {owner}; give another file")));
        }
    }
    for (path, kind) in targets.iter().filter_map(|(_, path, kind)| Some(((*path)?, kind))) {
        let kind = match kind {
            TargetKind::File(kind) => *kind,
            TargetKind::Log => FileKind::Log,
            TargetKind::Results => FileKind::Table,
        };
        check_target(path, kind).map_err(Failure::bad_input)?;
        remove_foreign_log(path, kind)?;
    }
    let (_, out, names) = directory;
    OutputDirectory::open(out, names)
}

/// Removes an accepted file where a log is written: the writer of logs replaces only logs, also with `--force`.
fn remove_foreign_log(path: &Path, kind: FileKind) -> Result<(), Failure> {
    match kind == FileKind::Log && path.is_file() && ensure_replaceable(path, path).is_err() {
        true => fs::remove_file(path).map_err(|error| Failure::bad_input(cannot_write(path, error))),
        false => Ok(()),
    }
}

/// Writable directory for the output files of a command; `None` if no directory was given, so nothing is written.
#[derive(Debug)]
pub(crate) struct OutputDirectory(Option<PathBuf>);

impl OutputDirectory {
    /// Creates the directory if needed. Called before any computation.
    fn open(out: Option<&Path>, names: &[&str]) -> Result<OutputDirectory, Failure> {
        let Some(out) = out else { return Ok(OutputDirectory(None)) };
        let shown_path = out.display();
        if out.exists() && !out.is_dir() {
            return Err(Failure::bad_input(format!(
                "cannot write the results to {shown_path}: that is a file; remove it first or give another directory"
            )));
        }
        let refused = |error: io::Error| {
            let help = "give one where you may write";
            Failure::bad_input(format!("cannot create the directory {shown_path} or a file in it: {error}; {help}"))
        };
        fs::create_dir_all(out).and_then(|()| tempfile::tempfile_in(out)).map_err(refused)?;
        for name in names {
            let (start, end) = name.split_once('*').unwrap_or((name, ""));
            let start = out.join(start);
            let entries = fs::read_dir(start.parent().unwrap_or(out)).into_iter().flatten().flatten();
            let matches = |path: &PathBuf| {
                let (text, start) = (path.to_string_lossy(), start.to_string_lossy());
                text == start || name.contains('*') && text.starts_with(&*start) && text.ends_with(end)
            };
            let mut existing = entries.map(|entry| entry.path()).filter(matches);
            existing.try_for_each(|path| {
                check_result_file(&path).map_err(Failure::bad_input)?;
                remove_foreign_log(&path, FileKind::from_extension(&path))
            })?;
        }
        Ok(OutputDirectory(Some(out.to_path_buf())))
    }

    /// Calls `write` with the directory.
    pub(crate) fn write_with(self, write: impl FnOnce(&Path) -> Result<(), Failure>) -> Result<(), Failure> {
        self.0.as_deref().map_or(Ok(()), write)
    }

    /// Writes each text to the file of its name.
    pub fn write<const N: usize>(self, names: [&str; N], texts: impl FnOnce() -> [String; N]) -> Result<(), Failure> {
        self.write_with(|out| names.iter().zip(texts()).try_for_each(|(name, text)| save(&out.join(name), &text)))
    }
}

/// Writes a text file atomically. Reports get the mark of phalanx. Text and JSON files are escaped like printed output,
/// because terminals may show them; pages and pictures already escape untrusted names.
pub(super) fn save(path: &Path, text: &str) -> Result<(), Failure> {
    let extension = path.extension().and_then(|extension| extension.to_str());
    // A page or a picture may have any name.
    let text = match extension.filter(|_| !text.starts_with('<')) {
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
