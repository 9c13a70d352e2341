//! Tables that several sections share.

use super::{Comparison, Verdict};
use crate::wording::report::{Cell, Report, Tone};

/// Head of a table of comparisons.
const HEAD: [&str; 6] = ["figure", "thesis", "ours", "expected", "source", "why"];

/// A table of comparisons, with the reasons below it, each once.
pub fn compared(section: Report, caption: &str, of: &[&Comparison]) -> Report {
    let mut reasons: Vec<String> = Vec::new();
    let mut letter = |one: &Comparison| {
        let reason = why(one);
        if reason.is_empty() {
            return String::new();
        }
        let place = reasons.iter().position(|known| *known == reason).unwrap_or_else(|| {
            reasons.push(reason);
            reasons.len() - 1
        });
        note(place)
    };
    let row = |one: &&Comparison| {
        vec![
            Cell::words(one.what),
            Cell::new(one.thesis_text()),
            ours(one),
            Cell::new(one.expected_text()),
            Cell::words(one.source),
            Cell::words(letter(one)),
        ]
    };
    let rows = of.iter().map(row).collect();
    let section = section.table(caption, &HEAD, rows);
    let notes: Vec<String> =
        reasons.iter().enumerate().map(|(place, reason)| format!("{}: {reason}", note(place))).collect();
    if notes.is_empty() { section } else { section.notes(notes) }
}

/// The letter of a reason.
fn note(place: usize) -> String {
    char::from(b'a' + (place % 26) as u8).to_string()
}

/// The comparisons of one section of the file.
pub fn of_section<'a>(all: &'a [Comparison], section: &str) -> Vec<&'a Comparison> {
    all.iter().filter(|one| one.section == section).collect()
}

/// The comparison of a key.
pub fn of_key<'a>(all: &'a [Comparison], key: &str) -> Option<&'a Comparison> {
    all.iter().find(|one| one.figure == key)
}

/// Our figure, toned by its verdict.
pub fn ours(of: &Comparison) -> Cell {
    let tone = match of.verdict {
        Verdict::Inside => Tone::Good,
        Verdict::Outside => Tone::Bad,
        Verdict::NotJudged => Tone::Plain,
    };
    Cell { text: of.ours_text(), figure: Some((of.figure.to_string(), of.ours)), tone, ..Cell::default() }
}

/// The reason with its errata; nothing where ours rounds to what is printed.
fn why(of: &Comparison) -> String {
    if of.reason.is_empty() || of.as_printed() && of.verdict != Verdict::Outside {
        return String::new();
    }
    match of.errata.is_empty() {
        true => of.reason.to_string(),
        false => format!("{} ({})", of.reason, errata(&of.errata)),
    }
}

fn errata(numbers: &[u32]) -> String {
    let list: Vec<String> = numbers.iter().map(u32::to_string).collect();
    format!("errata {}", list.join(", "))
}
