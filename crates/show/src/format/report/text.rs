//! A report as plain text, unwrapped or wrapped to a width.

use super::{Block, Report, fit_width, plain, wrap};

/// Formats a report; a figure is represented by its file name and caption.
pub(super) fn report(report: &Report, width: Option<usize>) -> String {
    let paragraph = |content: &str| match width {
        Some(width) => wrap::paragraph(content, width),
        None if content.ends_with('\n') => content.to_string(),
        None => format!("{content}\n"),
    };
    let lines = |content: &str| match width {
        Some(width) => wrap::lines(content, width),
        None => content.to_string(),
    };
    let render = |block: &Block| match block {
        Block::Heading(heading) => lines(&format!("\n{heading}\n\n")),
        Block::Lines(content) => lines(content),
        Block::Paragraph(content) => paragraph(content),
        Block::Notes(notes) => notes.iter().map(|note| lines(&format!("- {note}\n"))).collect(),
        Block::Table(item) => {
            let caption = if item.caption.is_empty() { String::new() } else { lines(&format!("{}\n", item.caption)) };
            caption + &width.map_or_else(|| plain::table(&item.rows), |width| fit_width::table(item, width))
        }
        Block::Figure(figure) => lines(&format!("{}: {}\n", figure.file, figure.caption)),
        Block::Text(item) => format!("{}\n{}\n", item.title, item.text.trim_end()),
    };
    report.blocks.iter().map(render).collect()
}
