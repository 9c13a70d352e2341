//! All files that a command is to write, checked together before it computes anything: no output overwrites another or an input.

use std::path::{Path, PathBuf};

use super::Failure;
use super::folder::{CHECKSUMS, Folder, fits};
use super::own::{Form, writable};
use crate::files::same;
use crate::log::partial_name;
use crate::study::store::companions;

/// A file that a flag names, and the files that come with it.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    File(Form),
    /// The log checks by itself what it may replace.
    Log,
    /// Results of a sweep, with checkpoint and study beside them; so does their store.
    Results,
}

/// A flag, the path that it gives, and what is written there.
pub type Target<'a> = (&'a str, Option<&'a Path>, Kind);
/// A flag, the directory that it gives, and names of files in it; `*` stands for any text.
pub type Directory<'a> = (&'a str, Option<&'a Path>, &'a [&'a str]);

/// No directory.
pub const NONE: Directory<'static> = ("", None, &[]);

/// The files of one flag.
struct Written<'a> {
    flag: &'a str,
    given: &'a Path,
    files: Vec<PathBuf>,
    /// Names of further files in the directory `given`.
    names: &'a [&'a str],
}

impl Written<'_> {
    /// The first of some files that is one of these.
    fn clash<'f>(&self, others: &'f [PathBuf]) -> Option<&'f PathBuf> {
        others.iter().find(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let within = || path.parent().is_some_and(|parent| same(self.given, &parent.join(".")));
            self.files.iter().any(|file| same(file, path)) || self.names.iter().any(|of| fits(of, &name)) && within()
        })
    }
}

/// Refuses targets that are one file, or an input (`reads`: its name in messages, and its files), or that cannot be written, or that
/// hold something else. Opens the directory.
pub fn reserve(
    reads: &[(&str, &[PathBuf])],
    targets: &[Target<'_>],
    directory: Directory<'_>,
) -> Result<Option<Folder>, Failure> {
    let mut all: Vec<Written<'_>> = Vec::new();
    for (flag, given, kind) in targets.iter().filter_map(|(flag, path, kind)| Some((*flag, (*path)?, kind))) {
        let mut files = vec![given.to_path_buf()];
        match kind {
            Kind::Log => files.push(partial_name(given)),
            Kind::Results => files.extend(companions(given)),
            Kind::File(_) => {}
        }
        all.push(Written { flag, given, files, names: &[] });
    }
    if let (flag, Some(given), names) = directory {
        let new = given.ancestors().filter(|path| !path.as_os_str().is_empty() && !path.is_dir());
        let whole = names.iter().chain(&[CHECKSUMS]).filter(|name| !name.contains('*'));
        let files = whole.map(|name| given.join(name)).chain(new.map(Path::to_path_buf)).collect();
        all.push(Written { flag, given, files, names });
    }
    for (index, one) in all.iter().enumerate() {
        let read = |(what, files): &(&str, &[PathBuf])| {
            Some((one.clash(files)?.clone(), format!("{what} itself, which must stay as it is")))
        };
        let written = |other: &Written<'_>| {
            let file = one.clash(&other.files).or(other.clash(&one.files))?;
            Some((file.clone(), format!("the file of {} {} too", other.flag, other.given.display())))
        };
        if let Some((file, whose)) = reads.iter().find_map(read).or_else(|| all[..index].iter().find_map(written)) {
            let also =
                if same(one.given, &file) { String::new() } else { format!("writes {}, which ", file.display()) };
            let (flag, given) = (one.flag, one.given.display());
            return Err(Failure::bad_input(format!("{flag} {given} {also}is {whose}; give another file")));
        }
    }
    for (_, path, kind) in targets {
        if let (Some(path), Kind::File(form)) = (path, kind) {
            writable(path, *form)?;
        }
    }
    let (_, out, names) = directory;
    out.map(|out| Folder::open(out, names)).transpose()
}
