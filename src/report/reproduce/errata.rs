//! The errata of the thesis, from the documentation.

use crate::format::report::{Cell, Report};

const ERRATA: &str = include_str!("../../docs/errata.md");

/// Builds the section on the errata.
pub fn section() -> Report {
    let mut lines = ERRATA.lines().filter(|line| line.starts_with('|')).map(cells);
    let header = lines.next().unwrap_or_default();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    // The line after the header is the Markdown rule.
    let rows = lines.skip(1).map(|row| {
        let mut row = row.into_iter();
        let first = row.next().map(Cell::new);
        first.into_iter().chain(row.map(Cell::prose)).collect()
    });
    Report::section("Errata").with_table(
        "Errors of the thesis and their corrections in phalanx; T marks errata with a test.",
        &header,
        rows.collect(),
    )
}

/// Splits a row of a Markdown table into cells without markup.
fn cells(line: &str) -> Vec<String> {
    let text = line.trim().trim_start_matches('|').trim_end_matches('|').replace("\\|", "\u{0}");
    text.split('|').map(|cell| cell.trim().replace('\u{0}', "|").replace("**", "").replace('`', "")).collect()
}
