//! Checks all output files of a command together before any computation: no output may overwrite another output or an
//! input.

use std::path::{Path, PathBuf};

use super::Failure;
use super::output_directory::{CHECKSUM_FILE, OutputDirectory, matches_pattern};
use super::ownership::{FileKind, check_target};
use crate::files::refer_to_same_file;
use crate::log::partial_name;
use crate::study::store::companion_files;

/// Kind of the file that a flag names; some kinds come with companion files.
#[derive(Clone, Copy, Debug)]
pub enum TargetKind {
    File(FileKind),
    /// A log; the log writer checks which files it may replace.
    Log,
    /// Results of a sweep with the files of their checkpoint and study; their store checks which files it may replace.
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
/// a foreign file. `inputs` lists the name of each input in messages and its files.
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
        let exact_names = names.iter().chain(&[CHECKSUM_FILE]).filter(|name| !name.contains('*'));
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
    for (_, path, kind) in targets {
        if let (Some(path), TargetKind::File(kind)) = (path, kind) {
            check_target(path, *kind)?;
        }
    }
    let (_, out, names) = directory;
    out.map(|out| OutputDirectory::open(out, names)).transpose()
}
