//! Output of a command: standard output and error, the width of printed text, and files.
//!
//! A closed pipe does not cause a panic. All output files of a command are checked together before any computation: no
//! output may overwrite another output, an input, or a file of another program.

use std::borrow::Cow;
use std::env;
use std::fmt::Display;
use std::fs;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;

use super::{Failure, Status};
pub(crate) use crate::files::FileKind;
use crate::files::{
    JSON_MARK, MARKDOWN_MARK, TEXT_MARK, cannot_write, check_result_file, check_target, refer_to_same_file,
    replace_file,
};
use crate::format::{Report, ToReport, escape_chars, is_unsafe_char};
use crate::log::{ensure_replaceable, partial_name};
use crate::page::picture_page;
use crate::scene::error::shortened;
use crate::study::results::companion_files;

/// Output of a command that can write a directory of files.
#[derive(Debug, Args)]
pub(crate) struct OutputArgs {
    /// Write the files named below to this directory, which is created if needed; an existing file is replaced only when
    /// the new one is complete
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    pub(super) json: bool,
}

impl OutputArgs {
    /// Returns the consequence of an interruption.
    pub(super) fn unwritten(&self) -> &'static str {
        match self.out {
            Some(_) => "no file was written, and existing files are unchanged",
            None => "there is no result",
        }
    }
}

/// Whether only results, warnings and errors are printed; set once, before the command starts.
pub(super) static QUIET: AtomicBool = AtomicBool::new(false);

pub(crate) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Escapes control characters that a terminal would interpret, because names in scenes and logs are untrusted.
fn escape_unsafe_chars(text: &str) -> Cow<'_, str> {
    escape_chars(text, is_unsafe_char)
}

/// Whether standard output was writable when the process started. Before `main`, Rust replaces a closed standard output
/// by /dev/null, and it ignores write errors of a read-only one; without this check all results would be lost silently.
static STDOUT_WRITABLE: AtomicBool = AtomicBool::new(true);

#[cfg(unix)]
#[used]
#[cfg_attr(not(target_vendor = "apple"), unsafe(link_section = ".init_array"))]
#[cfg_attr(target_vendor = "apple", unsafe(link_section = "__DATA,__mod_init_func"))]
static CHECK_STDOUT_BEFORE_MAIN: extern "C" fn() = check_stdout;

/// Sets [`STDOUT_WRITABLE`]. Makes one system call and does not use the Rust runtime, which is not initialised yet.
#[cfg(unix)]
extern "C" fn check_stdout() {
    use rustix::fs::{OFlags, fcntl_getfl};
    let flags = fcntl_getfl(rustix::stdio::stdout());
    STDOUT_WRITABLE.store(flags.is_ok_and(|flags| flags & OFlags::RWMODE != OFlags::RDONLY), Ordering::Relaxed);
}

/// Returns standard output; returns an error if it is not open for writing.
pub fn stdout() -> io::Result<io::StdoutLock<'static>> {
    match STDOUT_WRITABLE.load(Ordering::Relaxed) {
        true => Ok(io::stdout().lock()),
        false => Err(io::Error::other("it is closed or not open for writing")),
    }
}

/// Prints a text to standard output, which completes a command. If the reader closes the pipe (`| head`), this is not
/// an error.
pub fn print(text: &str) -> Result<Status, Failure> {
    match stdout().and_then(|mut out| out.write_all(escape_unsafe_chars(text).as_bytes()).and_then(|()| out.flush())) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::incomplete(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(Status::Done),
    }
}

/// Prints the result of a command, as one JSON document or as a text report.
pub(crate) fn print_result(result: &impl ToReport, json: bool) -> Result<Status, Failure> {
    if json { print(&result.json()) } else { print_report(&result.report()) }
}

/// Prints a report, wrapped to the width of the terminal.
pub(crate) fn print_report(report: &Report) -> Result<Status, Failure> {
    print(&match terminal_width() {
        Some(width) => report.to_wrapped_text(width),
        None => report.to_string(),
    })
}

/// Prints a note to stderr, except with `--quiet`.
pub(crate) fn print_note(note: &str) {
    if !is_quiet() {
        print_diagnostic(note);
    }
}

/// Prints a warning or an error to stderr. Write errors are ignored.
pub(crate) fn print_diagnostic(message: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", escape_unsafe_chars(&shortened(message)));
}

/// Width of a terminal of unknown size.
const DEFAULT_WIDTH: usize = 80;

/// Minimum width; narrower text is unreadable.
const MIN_WIDTH: usize = 20;

/// Number of columns of stdout; `None` if it is unlimited. In a pipe or file each row of a table is one line. The
/// variable COLUMNS also applies to pipes, because `watch` and pagers set it for their programs.
pub(crate) fn terminal_width() -> Option<usize> {
    let measure = || {
        let stdout = io::stdout();
        stdout.is_terminal().then(|| {
            terminal_size::terminal_size_of(&stdout)
                .map_or(DEFAULT_WIDTH, |(terminal_size::Width(width), _)| width.into())
        })
    };
    let columns = || env::var("COLUMNS").ok()?.trim().parse().ok().filter(|width| *width > 0);
    columns().or_else(measure).map(|width| width.max(MIN_WIDTH))
}

/// A flag, its path, and the kind of file to write.
pub(crate) type Target<'a> = (&'a str, Option<&'a Path>, FileKind);
/// The target of `--plot`: a picture, or a page with it.
pub(crate) fn picture_target(path: Option<&Path>) -> Target<'_> {
    ("--plot", path, path.map_or(FileKind::Picture, FileKind::from_extension))
}

/// A directory, and the names of files to write in it; `*` matches any text.
pub(crate) type Directory<'a> = (Option<&'a Path>, &'a [&'a str]);

pub(crate) const NO_DIRECTORY: Directory<'static> = (None, &[]);

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
            FileKind::Log => outputs.push((flag, path, partial_name(path))),
            FileKind::Results => outputs.extend(companion_files(path).map(|file| (flag, path, file))),
            _ => {}
        }
    }
    if let (Some(path), names) = directory {
        let new_directories =
            path.ancestors().filter(|ancestor| !ancestor.as_os_str().is_empty() && !ancestor.is_dir());
        let files = names.iter().map(|name| path.join(name)).chain(new_directories.map(Path::to_path_buf));
        outputs.extend(files.map(|file| ("--out", path, file)));
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
    for (path, kind) in targets.iter().filter_map(|(_, path, kind)| Some(((*path)?, *kind))) {
        check_target(path, kind).map_err(Failure::bad_input)?;
        remove_foreign_log(path, kind)?;
    }
    OutputDirectory::open(directory)
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
    fn open((out, names): Directory<'_>) -> Result<OutputDirectory, Failure> {
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

    /// Writes each text to the file with the name at the same index.
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
        _ => Cow::Borrowed(text),
    };
    replace_file(path, |out| out.write_all(text.as_bytes())).map_err(|error| write_failure(path, error))
}

/// Writes a picture in the format of the file's extension: svg, png, or a page for html.
pub(super) fn save_picture(path: &Path, title: &str, svg: &str) -> Result<(), Failure> {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("html") => save(path, &picture_page(title, svg)),
        #[cfg(feature = "png")]
        Some("png") => {
            let pixels = super::png::render(svg).map_err(|error| write_failure(path, error))?;
            replace_file(path, |out| out.write_all(&pixels)).map_err(|error| write_failure(path, error))
        }
        _ => save(path, svg),
    }
}

pub(super) fn write_failure(path: &Path, error: impl Display) -> Failure {
    Failure::incomplete(cannot_write(path, error))
}
