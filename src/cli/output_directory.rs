//! The directory of `--out`. All files of a command are written together and replace only files that phalanx wrote.
//!
//! The files are first written to a staging directory inside it and moved when all are complete. The file `.phalanx`
//! contains the checksums of files whose contents do not identify their writer; edits by the user, such as notes in a
//! report, are therefore detected and not overwritten.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use super::Failure;
use super::ownership::FileKind;
use super::save::{save, write_failure};
use crate::files::{StagingDirectory, checksum as file_checksum, read_at_most, replace_file};
use crate::limits::MAX_SCENE_BYTES;

/// Name of the file with the checksums.
pub const CHECKSUM_FILE: &str = ".phalanx";

/// The latest and the previous checksum of each file, by name; after a killed process the file may match either.
type Checksums = BTreeMap<String, Vec<String>>;

/// Writable directory for the output files of a command.
#[derive(Debug)]
pub struct OutputDirectory {
    out: PathBuf,
    staging: StagingDirectory,
}

impl OutputDirectory {
    /// Creates the directory if needed. Called before any computation.
    ///
    /// # Errors
    /// Returns an error if the directory is not writable, or if one of the files to write exists and was not written by
    /// phalanx.
    pub fn open(out: &Path, names: &[&str]) -> Result<OutputDirectory, Failure> {
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
        let checksums = read_checksums(out).map_err(Failure::bad_input)?;
        let entries = fs::read_dir(out).into_iter().flatten().flatten();
        let file_names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        let mut replaced = file_names.filter(|file_name| names.iter().any(|name| matches_pattern(name, file_name)));
        replaced.try_for_each(|name| reject_foreign_file(out, &name, &checksums)).map_err(Failure::bad_input)?;
        let staging = StagingDirectory::create_in(out).map_err(|error| {
            Failure::bad_input(format!(
                "cannot write to {shown_path}: {}; give a directory where you may write",
                error.kind()
            ))
        })?;
        Ok(OutputDirectory { out: out.to_path_buf(), staging })
    }

    /// Calls `write` with the staging directory and then moves all files to the output directory. An error leaves
    /// existing files unchanged.
    pub fn write_with(self, write: impl FnOnce(&Path) -> Result<(), Failure>) -> Result<(), Failure> {
        // Messages name the output directory, because the staging directory is unknown to the user.
        let staging_path = self.staging.path().display().to_string();
        let name_output = |Failure { message, status }| Failure {
            message: message.replace(&staging_path, &self.out.display().to_string()),
            status,
        };
        write(self.staging.path()).and_then(|()| self.commit()).map_err(name_output)
    }

    /// Writes each text to the file of its name; writes all files or none.
    pub fn write(self, names: &[&str], texts: &[String]) -> Result<(), Failure> {
        self.write_with(|staging| names.iter().zip(texts).try_for_each(|(name, text)| save(&staging.join(name), text)))
    }

    fn commit(&self) -> Result<(), Failure> {
        let names = list_files(self.staging.path()).map_err(|error| write_failure(&self.out, error))?;
        let mut checksums = read_checksums(&self.out).map_err(Failure::incomplete)?;
        names
            .iter()
            .try_for_each(|name| reject_foreign_file(&self.out, name, &checksums))
            .map_err(Failure::incomplete)?;
        for name in names.iter().filter(|name| FileKind::from_file_name(name).is_none()) {
            let path = self.staging.path().join(name);
            let crc = hex_checksum(&path).map_err(|error| write_failure(&path, error))?;
            let known = checksums.entry(name.clone()).or_default();
            known.retain(|other| *other != crc);
            known.insert(0, crc);
            known.truncate(2);
        }
        let path = self.out.join(CHECKSUM_FILE);
        let text = serde_json::to_string_pretty(&checksums).map_err(|error| write_failure(&path, error))?;
        replace_file(&path, |out| writeln!(out, "{text}")).map_err(|error| write_failure(&path, error))?;
        self.move_files(&names)
    }

    /// Moves all files. If a move fails, the previous moves are undone.
    fn move_files(&self, names: &[String]) -> Result<(), Failure> {
        let backups = tempfile::Builder::new().prefix("older").tempdir_in(self.staging.path());
        let backups = backups.map_err(|error| write_failure(&self.out, error.kind()))?;
        let mut moved: Vec<(PathBuf, Option<PathBuf>)> = Vec::new();
        for (index, name) in names.iter().enumerate() {
            let (new, target) = (self.staging.path().join(name), self.out.join(name));
            let backup = backups.path().join(index.to_string());
            // A hard link as backup, so that the old file stays in place until the new file replaces it.
            let backup = fs::hard_link(&target, &backup).is_ok().then_some(backup);
            if let Err(error) = move_file(&new, &target) {
                for (target, backup) in moved.into_iter().rev() {
                    let _ = match backup {
                        Some(backup) => fs::rename(backup, target),
                        None => fs::remove_file(target),
                    };
                }
                return Err(write_failure(&target, format!("{error}; existing files are unchanged")));
            }
            moved.push((target, backup));
        }
        Ok(())
    }
}

/// Returns whether a name matches `pattern`, in which one `*` matches any text.
pub fn matches_pattern(pattern: &str, name: &str) -> bool {
    pattern == name
        || pattern.split_once('*').is_some_and(|(start, end)| name.starts_with(start) && name.ends_with(end))
}

/// Moves a file to its target. If the target is not a regular file (a link or a pipe), the data are written through it.
fn move_file(new: &Path, target: &Path) -> io::Result<()> {
    if let Some(parent) = target.parent() {
        fs::create_dir_all(parent)?;
    }
    match fs::symlink_metadata(target) {
        Ok(metadata) if !metadata.is_file() => {
            replace_file(target, |out| io::copy(&mut File::open(new)?, out).map(drop))
        }
        Ok(_) => File::open(new)?.sync_all().and_then(|()| fs::rename(new, target)),
        Err(_) => fs::rename(new, target),
    }
}

/// Returns an error message if a file of this name exists and must not be replaced.
fn reject_foreign_file(out: &Path, name: &str, checksums: &Checksums) -> Result<(), String> {
    let path = out.join(name);
    let Ok(found) = fs::metadata(&path) else { return Ok(()) };
    let shown_path = path.display();
    if found.is_dir() {
        return Err(format!("cannot write {shown_path}: that is a directory; give another --out, or move it away"));
    }
    // Pipes and devices are written to directly.
    if !found.is_file() || found.len() == 0 {
        return Ok(());
    }
    let has_known_checksum = |path: &Path| {
        let crc = hex_checksum(path)?;
        Ok(checksums.get(name).is_some_and(|known| known.contains(&crc)))
    };
    let is_own = match FileKind::from_file_name(name) {
        Some(kind) => kind.is_written_by_phalanx(&path),
        None => has_known_checksum(&path),
    };
    match is_own {
        Ok(true) => Ok(()),
        Ok(false) => Err(format!(
            "cannot write {shown_path}: the existing file was not written by phalanx, or has been changed since, so it is not replaced; \
             give another --out, or delete it first"
        )),
        Err(error) => {
            Err(format!("cannot write {shown_path}: the existing file cannot be read ({error}); give another --out"))
        }
    }
}

/// Reads the checksums of the directory. Returns an error if the checksum file was not written by phalanx.
fn read_checksums(out: &Path) -> Result<Checksums, String> {
    let path = out.join(CHECKSUM_FILE);
    if !path.exists() {
        return Ok(Checksums::new());
    }
    let bytes = if path.is_file() { read_at_most(&path, MAX_SCENE_BYTES) } else { Ok(None) };
    let checksums: Option<Checksums> = bytes.ok().flatten().and_then(|bytes| match bytes.is_empty() {
        true => Some(Checksums::new()),
        false => serde_json::from_slice(&bytes).ok(),
    });
    let is_checksum = |text: &String| text.len() == 8 && u32::from_str_radix(text, 16).is_ok();
    checksums.filter(|checksums| checksums.values().flatten().all(is_checksum)).ok_or_else(|| {
        format!(
            "cannot write {}: phalanx stores the checksums of its files there, but the existing file was not written by phalanx, so it is \
             not replaced; give another --out, or delete it first",
            path.display()
        )
    })
}

/// CRC-32 of a file as eight hexadecimal digits.
fn hex_checksum(path: &Path) -> io::Result<String> {
    file_checksum(path, u64::MAX).map(|(crc, _)| format!("{crc:08x}"))
}

/// Lists all files of a directory and its subdirectories, by their relative paths in alphabetical order.
fn list_files(directory: &Path) -> io::Result<Vec<String>> {
    let mut files = Vec::new();
    let mut pending = vec![PathBuf::new()];
    while let Some(subdirectory) = pending.pop() {
        for entry in fs::read_dir(directory.join(&subdirectory))? {
            let entry = entry?;
            let name = subdirectory.join(entry.file_name());
            match entry.file_type()?.is_dir() {
                true => pending.push(name),
                false => files.push(name.to_string_lossy().into_owned()),
            }
        }
    }
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [&str; 2] = ["report.txt", "figures/table.csv"];

    fn write_with(out: &Path, text: &str) -> Result<(), Failure> {
        OutputDirectory::open(out, &NAMES)?.write_with(|staging| {
            fs::create_dir(staging.join("figures")).expect("created");
            NAMES.iter().for_each(|name| fs::write(staging.join(name), text).expect("written"));
            Ok(())
        })
    }

    fn read_texts(out: &Path) -> [String; 2] {
        NAMES.map(|name| fs::read_to_string(out.join(name)).expect("readable"))
    }

    #[test]
    fn errors_while_writing_leave_existing_files_unchanged() {
        let directory = tempfile::tempdir().expect("a directory");
        let out = directory.path().join("out");
        write_with(&out, "first").expect("an empty directory");
        let directory = OutputDirectory::open(&out, &NAMES).expect("files of phalanx");
        fs::write(out.join("notes.txt"), "mine").expect("written");
        let rejected = directory.write_with(|staging| {
            fs::write(staging.join("notes.txt"), "ours").expect("written");
            fs::write(staging.join("report.txt"), "second").map_err(|error| write_failure(staging, error))
        });
        assert!(rejected.expect_err("a foreign file").message.contains("notes.txt"));
        let directory = OutputDirectory::open(&out, &NAMES).expect("files of phalanx");
        let failed =
            directory.write_with(|staging| Err(write_failure(&staging.join("report.txt"), "the disk is full")));
        let message = failed.expect_err("no file").message;
        assert!(message.contains(&*out.join("report.txt").to_string_lossy()), "{message}");
        assert_eq!(fs::read_to_string(out.join("notes.txt")).expect("readable"), "mine");
        assert_eq!(read_texts(&out), ["first", "first"]);
    }
}
