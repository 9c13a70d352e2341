//! How wide what is printed may be.

use std::env;
use std::io::{self, IsTerminal};

/// Of a terminal that does not say.
const USUAL: usize = 80;

/// Nothing can be read in less.
const LEAST: usize = 20;

/// Columns there are on stdout; `None` where there is no end to a line: what reads a pipe or a file finds every row of a table
/// on one line. The variable COLUMNS is heeded in a pipe too, for `watch` and pagers set it for those they show.
pub fn width() -> Option<usize> {
    let measured = || {
        let stdout = io::stdout();
        stdout.is_terminal().then(|| {
            terminal_size::terminal_size_of(&stdout).map_or(USUAL, |(terminal_size::Width(width), _)| width.into())
        })
    };
    asked(env::var("COLUMNS").ok().as_deref()).or_else(measured).map(|width| width.max(LEAST))
}

/// What COLUMNS says; nothing where that is no width.
fn asked(columns: Option<&str>) -> Option<usize> {
    columns?.trim().parse().ok().filter(|width| *width > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_width_is_as_if_nothing_was_asked_for() {
        let all = [Some("132"), Some(" 90 "), Some("0"), Some("wide"), Some("-4"), Some(""), None];
        assert_eq!(all.map(asked), [Some(132), Some(90), None, None, None, None, None]);
    }
}
