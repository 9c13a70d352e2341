//! Writing to stdout and stderr, and the width of printed text. A closed pipe does not cause a panic.

use std::borrow::Cow;
use std::env;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use super::Failure;
use crate::format::{Report, ToReport, is_unsafe_char};
use crate::scene::error::shortened;

/// Whether only results, warnings and errors are printed; set once, before the command starts.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Disables progress and notes.
pub(crate) fn set_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

pub(crate) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Escapes control characters that a terminal would interpret, because names in scenes and logs are untrusted. The
/// escapes are those of JSON, so a JSON document remains valid.
pub(crate) fn escape_unsafe_chars(text: &str) -> Cow<'_, str> {
    if !text.contains(is_unsafe_char) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match is_unsafe_char(c) {
            true => escaped.push_str(&format!("\\u{:04x}", u32::from(c))),
            false => escaped.push(c),
        }
    }
    Cow::Owned(escaped)
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

/// Returns standard output if it is open for writing.
pub fn stdout() -> io::Result<io::StdoutLock<'static>> {
    match STDOUT_WRITABLE.load(Ordering::Relaxed) {
        true => Ok(io::stdout().lock()),
        false => Err(io::Error::other("it is closed or not open for writing")),
    }
}

/// Prints to stdout. A pipe closed by its reader (`| head`) is not an error.
pub fn print(text: &str) -> Result<(), Failure> {
    match stdout().and_then(|mut out| out.write_all(escape_unsafe_chars(text).as_bytes()).and_then(|()| out.flush())) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::incomplete(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints the result of a command, as one JSON document or as a text report.
pub(crate) fn print_result(result: &impl ToReport, json: bool) -> Result<(), Failure> {
    if json { print(&result.json()) } else { print_report(&result.report()) }
}

/// Prints a report, wrapped to the width of the terminal.
pub(crate) fn print_report(report: &Report) -> Result<(), Failure> {
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
    parse_columns(env::var("COLUMNS").ok().as_deref()).or_else(measure).map(|width| width.max(MIN_WIDTH))
}

/// Parses the value of COLUMNS; `None` if it is not a positive width.
fn parse_columns(columns: Option<&str>) -> Option<usize> {
    columns?.trim().parse().ok().filter(|width| *width > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped() {
        assert!(matches!(escape_unsafe_chars("µ: 1 mm\n\tfine"), Cow::Borrowed(_)));
        assert_eq!(
            escape_unsafe_chars("a\u{1b}[31m\r\u{7f}\u{9b}2J\u{202e}z"),
            "a\\u001b[31m\\u000d\\u007f\\u009b2J\\u202ez"
        );
        // Escaping does not change the contents of a JSON document.
        let document = serde_json::to_string(&"\u{1b}\u{9b}\u{202e}").expect("JSON");
        let read: String = serde_json::from_str(&escape_unsafe_chars(&document)).expect("still JSON");
        assert_eq!(read, "\u{1b}\u{9b}\u{202e}");
    }

    #[test]
    fn invalid_columns_are_ignored() {
        let all = [Some("132"), Some(" 90 "), Some("0"), Some("wide"), Some("-4"), Some(""), None];
        assert_eq!(all.map(parse_columns), [Some(132), Some(90), None, None, None, None, None]);
    }
}
