//! The errata that the reasons name, from the documentation.

use crate::wording::report::{Cell, Report};

const ERRATA: &str = include_str!("../../docs/errata.md");

/// The section.
pub fn section() -> Report {
    let mut lines = ERRATA.lines().filter(|line| line.starts_with('|')).map(cells);
    let head = lines.next().unwrap_or_default();
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    // After the head comes the rule.
    let rows = lines.skip(1).map(|row| {
        let mut row = row.into_iter();
        let first = row.next().map(Cell::new);
        first.into_iter().chain(row.map(Cell::words)).collect()
    });
    Report::section("Errata").table(
        "What is wrong in the thesis and what phalanx does instead; T marks those with a test.",
        &head,
        rows.collect(),
    )
}

/// The cells of a line of a Markdown table, without marks.
fn cells(line: &str) -> Vec<String> {
    let text = line.trim().trim_start_matches('|').trim_end_matches('|').replace("\\|", "\u{0}");
    text.split('|').map(|cell| cell.trim().replace('\u{0}', "|").replace("**", "").replace('`', "")).collect()
}
