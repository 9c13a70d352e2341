//! Writing to stdout and stderr without a panic when the reader has gone.

use std::borrow::Cow;
use std::io::{self, ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use super::{Failure, terminal};
use crate::scene::error::shortened;
use crate::wording::{Report, Reported};

/// Whether only results, warnings and errors are wanted: asked for once, before the command begins.
static QUIET: AtomicBool = AtomicBool::new(false);

/// No progress and no notes from now on.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// The text without what a terminal would obey: control characters and those that turn the order of letters around are shown as
/// JSON writes them, so that a document stays one. Names in scenes and logs are others' words.
fn visible(text: &str) -> Cow<'_, str> {
    let acts = |c: char| {
        let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        turns || c.is_control() && !matches!(c, '\n' | '\t')
    };
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

/// Prints to stdout. A reader that has seen enough (`| head`) is no error.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(visible(text).as_bytes()).and_then(|()| stdout.flush()) {
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
