//! Width of printed text.

use std::env;
use std::io::{self, IsTerminal};

/// Width of a terminal of unknown size.
const DEFAULT_WIDTH: usize = 80;

/// Minimum width; narrower text is unreadable.
const MIN_WIDTH: usize = 20;

/// Number of columns of stdout; `None` if it is unlimited. In a pipe or file each row of a table is one line. The
/// variable COLUMNS also applies to pipes, because `watch` and pagers set it for their programs.
pub fn width() -> Option<usize> {
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
    fn invalid_columns_are_ignored() {
        let all = [Some("132"), Some(" 90 "), Some("0"), Some("wide"), Some("-4"), Some(""), None];
        assert_eq!(all.map(parse_columns), [Some(132), Some(90), None, None, None, None, None]);
    }
}
