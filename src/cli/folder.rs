//! The directory of `--out`: all files of a command come there together, and only in place of files that phalanx wrote.
//!
//! They are written into a directory within it first, and moved when all are there. `.phalanx` beside them has the checksums of
//! those that do not tell by themselves who wrote them, so that the notes somebody made in a report are not lost either.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use super::Failure;
use super::own::Form;
use super::saved::{broken, save};
use crate::files::{Staging, checksum as sum_up, read_at_most, replace};
use crate::limits::LARGEST_SCENE_BYTES;

/// Checksums of what was written, by name.
pub const CHECKSUMS: &str = ".phalanx";

/// The latest checksum of each file and the one before: a process that was killed may have left either.
type Checksums = BTreeMap<String, Vec<String>>;

/// A directory that can take the files of a command.
#[derive(Debug)]
pub struct Folder {
    out: PathBuf,
    staging: Staging,
}

impl Folder {
    /// Makes the directory, and refuses it if it cannot be written to or if one of the files to be written is there and not
    /// phalanx's; before anything is computed.
    pub fn open(out: &Path, names: &[&str]) -> Result<Folder, Failure> {
        let place = out.display();
        if out.exists() && !out.is_dir() {
            return Err(Failure::bad_input(format!(
                "cannot write the results to {place}: that is a file; remove it first or give another directory"
            )));
        }
        fs::create_dir_all(out).map_err(|error| {
            Failure::bad_input(format!("cannot make the directory {place}: {error}; give one where you may write"))
        })?;
        let checksums = checksums(out).map_err(Failure::bad_input)?;
        let entries = fs::read_dir(out).into_iter().flatten().flatten();
        let found = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
        let mut own = found.filter(|found| names.iter().any(|name| fits(name, found)));
        own.try_for_each(|name| refuse_foreign(out, &name, &checksums)).map_err(Failure::bad_input)?;
        let staging = Staging::within(out).map_err(|error| {
            Failure::bad_input(format!(
                "cannot write to {place}: {}; give a directory where you may write",
                error.kind()
            ))
        })?;
        Ok(Folder { out: out.to_path_buf(), staging })
    }

    /// Lets `write` make the files in a directory of their own, and moves them to their places; after an error everything is as
    /// it was.
    pub fn fill(self, write: impl FnOnce(&Path) -> Result<(), Failure>) -> Result<(), Failure> {
        // Nobody knows the directory in between.
        let elsewhere = self.staging.path().display().to_string();
        let named = |Failure { message, status }| Failure {
            message: message.replace(&elsewhere, &self.out.display().to_string()),
            status,
        };
        write(self.staging.path()).and_then(|()| self.keep()).map_err(named)
    }

    /// Writes texts by their names, all or none.
    pub fn write(self, names: &[&str], texts: &[String]) -> Result<(), Failure> {
        self.fill(|staging| names.iter().zip(texts).try_for_each(|(name, text)| save(&staging.join(name), text)))
    }

    fn keep(&self) -> Result<(), Failure> {
        let names = files(self.staging.path()).map_err(|error| broken(&self.out, error))?;
        let mut checksums = checksums(&self.out).map_err(Failure::incomplete)?;
        names.iter().try_for_each(|name| refuse_foreign(&self.out, name, &checksums)).map_err(Failure::incomplete)?;
        for name in names.iter().filter(|name| Form::of_name(name).is_none()) {
            let path = self.staging.path().join(name);
            let crc = checksum(&path).map_err(|error| broken(&path, error))?;
            let known = checksums.entry(name.clone()).or_default();
            known.retain(|other| *other != crc);
            known.insert(0, crc);
            known.truncate(2);
        }
        let path = self.out.join(CHECKSUMS);
        let text = serde_json::to_string_pretty(&checksums).map_err(|error| broken(&path, error))?;
        replace(&path, |out| writeln!(out, "{text}")).map_err(|error| broken(&path, error))?;
        self.exchange(&names)
    }

    /// Moves all files; where that fails for one, those before it are moved back.
    fn exchange(&self, names: &[String]) -> Result<(), Failure> {
        let older = tempfile::Builder::new().prefix("older").tempdir_in(self.staging.path());
        let older = older.map_err(|error| broken(&self.out, error.kind()))?;
        let mut moved: Vec<(PathBuf, Option<PathBuf>)> = Vec::new();
        for (index, name) in names.iter().enumerate() {
            let (new, target) = (self.staging.path().join(name), self.out.join(name));
            let kept = older.path().join(index.to_string());
            // A second name for what is there, so that it is in its place until the new one is.
            let older = fs::hard_link(&target, &kept).is_ok().then_some(kept);
            if let Err(error) = place(&new, &target) {
                for (target, older) in moved.into_iter().rev() {
                    let _ = match older {
                        Some(older) => fs::rename(older, target),
                        None => fs::remove_file(target),
                    };
                }
                return Err(broken(&target, format!("{error}; the files are as they were before")));
            }
            moved.push((target, older));
        }
        Ok(())
    }
}

/// Whether a name is one of those that `pattern` stands for: itself, or with any text for `*`.
pub fn fits(pattern: &str, name: &str) -> bool {
    pattern == name
        || pattern.split_once('*').is_some_and(|(start, end)| name.starts_with(start) && name.ends_with(end))
}

/// Moves a file to its place; what stands there and is no regular file (a link, a pipe) is written through.
fn place(new: &Path, target: &Path) -> io::Result<()> {
    if let Some(parent) = target.parent() {
        fs::create_dir_all(parent)?;
    }
    match fs::symlink_metadata(target) {
        Ok(found) if !found.is_file() => replace(target, |out| io::copy(&mut File::open(new)?, out).map(drop)),
        Ok(_) => File::open(new)?.sync_all().and_then(|()| fs::rename(new, target)),
        Err(_) => fs::rename(new, target),
    }
}

/// Says why a file must not be replaced.
fn refuse_foreign(out: &Path, name: &str, checksums: &Checksums) -> Result<(), String> {
    let path = out.join(name);
    let Ok(found) = fs::metadata(&path) else { return Ok(()) };
    let place = path.display();
    if found.is_dir() {
        return Err(format!("cannot write {place}: that is a directory; give another --out, or move it away"));
    }
    // Pipes and devices are written to as they are.
    if !found.is_file() || found.len() == 0 {
        return Ok(());
    }
    let known = |path: &Path| {
        let crc = checksum(path)?;
        Ok(checksums.get(name).is_some_and(|of| of.contains(&crc)))
    };
    let own = match Form::of_name(name) {
        Some(form) => form.is_own(&path),
        None => known(&path),
    };
    match own {
        Ok(true) => Ok(()),
        Ok(false) => Err(format!(
            "cannot write {place}: the file there was not written by phalanx, or has been changed since, so it is left alone; \
             give another --out, or delete it first"
        )),
        Err(error) => Err(format!("cannot write {place}: the file there cannot be read ({error}); give another --out")),
    }
}

/// The checksums in the directory; refuses a file of that name that phalanx did not write.
fn checksums(out: &Path) -> Result<Checksums, String> {
    let path = out.join(CHECKSUMS);
    if !path.exists() {
        return Ok(Checksums::new());
    }
    let bytes = if path.is_file() { read_at_most(&path, LARGEST_SCENE_BYTES) } else { Ok(None) };
    let found: Option<Checksums> = bytes.ok().flatten().and_then(|bytes| match bytes.is_empty() {
        true => Some(Checksums::new()),
        false => serde_json::from_slice(&bytes).ok(),
    });
    let is_sum = |text: &String| text.len() == 8 && u32::from_str_radix(text, 16).is_ok();
    found.filter(|found| found.values().flatten().all(is_sum)).ok_or_else(|| {
        format!(
            "cannot write {}: it holds checksums of the files beside it, but that one was not written by phalanx, so it is left alone; \
             give another --out, or delete it first",
            path.display()
        )
    })
}

fn checksum(path: &Path) -> io::Result<String> {
    sum_up(path, u64::MAX).map(|(crc, _)| format!("{crc:08x}"))
}

/// All files of a directory and of those in it, by their names from there, in order.
fn files(directory: &Path) -> io::Result<Vec<String>> {
    let mut found = Vec::new();
    let mut open = vec![PathBuf::new()];
    while let Some(below) = open.pop() {
        for entry in fs::read_dir(directory.join(&below))? {
            let entry = entry?;
            let name = below.join(entry.file_name());
            match entry.file_type()?.is_dir() {
                true => open.push(name),
                false => found.push(name.to_string_lossy().into_owned()),
            }
        }
    }
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [&str; 2] = ["report.txt", "figures/table.csv"];

    fn fill(out: &Path, text: &str) -> Result<(), Failure> {
        Folder::open(out, &NAMES)?.fill(|staging| {
            fs::create_dir(staging.join("figures")).expect("made");
            NAMES.iter().for_each(|name| fs::write(staging.join(name), text).expect("written"));
            Ok(())
        })
    }

    fn texts(out: &Path) -> [String; 2] {
        NAMES.map(|name| fs::read_to_string(out.join(name)).expect("there"))
    }

    #[test]
    fn what_comes_up_while_files_are_made_leaves_everything_as_it_was() {
        let directory = tempfile::tempdir().expect("a directory");
        let out = directory.path().join("out");
        fill(&out, "first").expect("an empty directory");
        let folder = Folder::open(&out, &NAMES).expect("our files");
        fs::write(out.join("notes.txt"), "mine").expect("written");
        let refused = folder.fill(|staging| {
            fs::write(staging.join("notes.txt"), "ours").expect("written");
            fs::write(staging.join("report.txt"), "second").map_err(|error| broken(staging, error))
        });
        assert!(refused.expect_err("a file of somebody's").message.contains("notes.txt"));
        let folder = Folder::open(&out, &NAMES).expect("our files");
        let failed = folder.fill(|staging| Err(broken(&staging.join("report.txt"), "the disk is full")));
        let message = failed.expect_err("no file").message;
        assert!(message.contains(&*out.join("report.txt").to_string_lossy()), "{message}");
        assert_eq!(fs::read_to_string(out.join("notes.txt")).expect("there"), "mine");
        assert_eq!(texts(&out), ["first", "first"]);
    }
}
