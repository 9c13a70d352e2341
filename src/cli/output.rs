//! Writing to stdout and stderr without a panic when the reader has gone.

use std::borrow::Cow;
use std::io::{self, ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use super::{Failure, terminal};
use crate::scene::error::shortened;
use crate::wording::{Report, Reported, acts};

/// Whether only results, warnings and errors are wanted: asked for once, before the command begins.
static QUIET: AtomicBool = AtomicBool::new(false);

/// No progress and no notes from now on.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// The text without commands to a terminal: they are shown as JSON writes them, so that a document stays one. Names in scenes and
/// logs are others' words.
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match acts(c) {
            true => shown.push_str(&format!("\\u{:04x}", u32::from(c))),
            false => shown.push(c),
        }
    }
    Cow::Owned(shown)
}

/// Whether standard output could be written to when the process began. Rust puts /dev/null in place of a closed one before `main`,
/// and drops what a read-only one refuses: all results would be lost without a word.
static WRITABLE: AtomicBool = AtomicBool::new(true);

#[cfg(unix)]
#[used]
#[cfg_attr(not(target_vendor = "apple"), unsafe(link_section = ".init_array"))]
#[cfg_attr(target_vendor = "apple", unsafe(link_section = "__DATA,__mod_init_func"))]
static BEFORE_MAIN: extern "C" fn() = look;

/// One system call, which needs nothing of Rust's runtime.
#[cfg(unix)]
extern "C" fn look() {
    use rustix::fs::{OFlags, fcntl_getfl};
    let flags = fcntl_getfl(rustix::stdio::stdout());
    WRITABLE.store(flags.is_ok_and(|flags| flags & OFlags::RWMODE != OFlags::RDONLY), Ordering::Relaxed);
}

/// Standard output, if it is open for writing.
pub fn stdout() -> io::Result<io::StdoutLock<'static>> {
    match WRITABLE.load(Ordering::Relaxed) {
        true => Ok(io::stdout().lock()),
        false => Err(io::Error::other("it is closed, or not open for writing")),
    }
}

/// Prints to stdout. A reader that has seen enough (`| head`) is no error.
pub fn print(text: &str) -> Result<(), Failure> {
    match stdout().and_then(|mut out| out.write_all(visible(text).as_bytes()).and_then(|()| out.flush())) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::incomplete(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints what a command answers: as one JSON document, or for people.
pub fn answer(of: &impl Reported, json: bool) -> Result<(), Failure> {
    if json { print(&of.json()) } else { show(&of.report()) }
}

/// Prints a report: on a terminal no wider than it is.
pub fn show(report: &Report) -> Result<(), Failure> {
    print(&match terminal::width() {
        Some(width) => report.fitted(width),
        None => report.to_string(),
    })
}

/// Says on stderr what is no warning and no error; nothing with `--quiet`.
pub fn note(words: &str) {
    if !is_quiet() {
        complain(words);
    }
}

/// Prints a warning or an error to stderr, as far as that takes it.
pub fn complain(message: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", visible(&shortened(message)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_a_terminal_obeys_is_printed() {
        assert!(matches!(visible("µ: 1 mm\n\tfine"), Cow::Borrowed(_)));
        assert_eq!(visible("a\u{1b}[31m\r\u{7f}\u{9b}2J\u{202e}z"), "a\\u001b[31m\\u000d\\u007f\\u009b2J\\u202ez");
        // A document of JSON says the same as before.
        let document = serde_json::to_string(&"\u{1b}\u{9b}\u{202e}").expect("JSON");
        let read: String = serde_json::from_str(&visible(&document)).expect("still JSON");
        assert_eq!(read, "\u{1b}\u{9b}\u{202e}");
    }
}
