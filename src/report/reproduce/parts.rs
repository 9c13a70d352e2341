//! Tables that several sections share.

use super::{Comparison, Verdict};
use crate::report::paper::{Cell, Section, Tone};

/// Head of a table of comparisons.
const HEAD: [&str; 6] = ["figure", "thesis", "ours", "expected", "source", "why ours differs"];

/// A table of comparisons.
pub fn compared(section: Section, caption: &str, of: &[&Comparison]) -> Section {
    let row = |one: &&Comparison| {
        vec![
            Cell::words(one.what),
            Cell::new(one.thesis_text()),
            ours(one),
            Cell::new(one.expected_text()),
            Cell::words(one.source),
            Cell::words(why(one)),
        ]
    };
    section.table(caption, &HEAD, of.iter().map(row).collect())
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
    Cell { text: of.ours_text(), figure: Some((of.figure.to_string(), of.ours)), tone }
}

/// The reason with its errata; nothing where the shown figures are the same.
pub fn why(of: &Comparison) -> String {
    let same = of.thesis.is_none() || of.thesis_text() == of.ours_text();
    if of.reason.is_empty() || same && of.verdict != Verdict::Outside {
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
