//! Tables of comparisons that several sections share.

use super::{Comparison, Verdict};
use crate::format::report::{Cell, CellStyle, Report};

/// Header of a table of comparisons.
const HEADER: [&str; 6] = ["quantity", "thesis", "ours", "expected", "source", "reason"];

/// Adds a table of comparisons to a section, with each reason once below it.
pub fn comparison_table(section: Report, caption: &str, comparisons: &[&Comparison]) -> Report {
    let mut reasons: Vec<String> = Vec::new();
    let mut letter = |comparison: &Comparison| {
        let reason = reason(comparison);
        if reason.is_empty() {
            return String::new();
        }
        let index = reasons.iter().position(|known| *known == reason).unwrap_or_else(|| {
            reasons.push(reason);
            reasons.len() - 1
        });
        note_letter(index)
    };
    let row = |comparison: &&Comparison| {
        vec![
            Cell::prose(comparison.quantity),
            Cell::new(comparison.thesis_text()),
            computed_cell(comparison),
            Cell::new(comparison.expected_text()),
            Cell::prose(comparison.source),
            Cell::prose(letter(comparison)),
        ]
    };
    let rows = comparisons.iter().map(row).collect();
    let section = section.with_table(caption, &HEADER, rows);
    let notes: Vec<String> =
        reasons.iter().enumerate().map(|(index, reason)| format!("{}: {reason}", note_letter(index))).collect();
    if notes.is_empty() { section } else { section.with_notes(notes) }
}

/// Returns the letter that identifies a reason.
fn note_letter(index: usize) -> String {
    char::from(b'a' + (index % 26) as u8).to_string()
}

/// Returns the comparisons of one section.
pub fn section_comparisons<'a>(all: &'a [Comparison], section: &str) -> Vec<&'a Comparison> {
    all.iter().filter(|comparison| comparison.section == section).collect()
}

/// Returns the comparison with a key.
pub fn find_comparison<'a>(all: &'a [Comparison], key: &str) -> Option<&'a Comparison> {
    all.iter().find(|comparison| comparison.figure == key)
}

/// Returns a cell with the computed value, styled by its verdict.
pub fn computed_cell(comparison: &Comparison) -> Cell {
    let style = match comparison.verdict {
        Verdict::Inside => CellStyle::Good,
        Verdict::Outside => CellStyle::Bad,
        Verdict::NotJudged => CellStyle::Plain,
    };
    Cell {
        text: comparison.ours_text(),
        figure: Some((comparison.figure.to_string(), comparison.computed)),
        style,
        ..Cell::default()
    }
}

/// Returns the reason for a difference with its errata; empty if the computed value rounds to the printed one.
fn reason(comparison: &Comparison) -> String {
    if comparison.reason.is_empty() || comparison.matches_printed() && comparison.verdict != Verdict::Outside {
        return String::new();
    }
    match comparison.errata.is_empty() {
        true => comparison.reason.to_string(),
        false => format!("{} ({})", comparison.reason, errata(&comparison.errata)),
    }
}

fn errata(numbers: &[u32]) -> String {
    let list: Vec<String> = numbers.iter().map(u32::to_string).collect();
    format!("errata {}", list.join(", "))
}
