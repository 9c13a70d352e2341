//! A report as text: as wide as need be, or within a width.

use super::{Part, Report, fit, plain, wrap};

/// The whole text. Of a figure only its caption is said.
pub(super) fn report(report: &Report, width: Option<usize>) -> String {
    let paragraph = |words: &str| match width {
        Some(width) => wrap::paragraph(words, width),
        None if words.ends_with('\n') => words.to_string(),
        None => format!("{words}\n"),
    };
    let lines = |words: &str| match width {
        Some(width) => wrap::lines(words, width),
        None => words.to_string(),
    };
    let one = |part: &Part| match part {
        Part::Heading(heading) => lines(&format!("\n{heading}\n\n")),
        Part::Words(words) => lines(words),
        Part::Paragraph(words) => paragraph(words),
        Part::Notes(notes) => notes.iter().map(|note| lines(&format!("- {note}\n"))).collect(),
        Part::Table(of) => {
            let caption = if of.caption.is_empty() { String::new() } else { lines(&format!("{}\n", of.caption)) };
            caption + &width.map_or_else(|| plain::table(&of.rows), |width| fit::table(of, width))
        }
        Part::Figure(figure) => lines(&format!("{}: {}\n", figure.file, figure.caption)),
        Part::Text(of) => format!("{}\n{}\n", of.title, of.text.trim_end()),
    };
    report.parts.iter().map(one).collect()
}
