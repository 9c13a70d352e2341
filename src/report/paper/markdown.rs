//! A paper as Markdown.

use super::{Block, Figure, Grid, Paper, Tone};

/// The text; figures are links into the directory `figures`, with their captions.
pub fn paper_markdown(paper: &Paper) -> String {
    let mut text = format!("# {}\n", paper.title);
    let (mut tables, mut figures) = (0, 0);
    for section in &paper.sections {
        text.push_str(&format!("\n## {}\n", section.title));
        for block in &section.blocks {
            text.push('\n');
            match block {
                Block::Words(words) => text.push_str(&format!("{words}\n")),
                Block::Notes(notes) => {
                    text.extend(notes.iter().flat_map(|note| ["- ", note.as_str(), "\n"]));
                }
                Block::Table(grid) => {
                    tables += 1;
                    text.push_str(&table(grid, tables));
                }
                Block::Figure(figure) => {
                    figures += 1;
                    text.push_str(&picture(figure, figures));
                }
                Block::Text(of) => text.push_str(&format!("**{}**\n\n```\n{}\n```\n", of.title, of.text.trim_end())),
            }
        }
    }
    text
}

fn table(grid: &Grid, number: usize) -> String {
    let cell = |text: &str| text.replace('|', "\\|").replace('\n', " ");
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let mut text = format!("**Table {number}.** {}\n\n", grid.caption);
    text.push_str(&line(grid.head.iter().map(|head| cell(head)).collect()));
    let right = |column: usize| {
        let tones = grid.rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.tone);
        column > 0 && !tones.clone().any(|tone| tone == Tone::Words)
    };
    let rules = (0..grid.head.len()).map(|column| if right(column) { "---:" } else { "---" }.to_string());
    text.push_str(&line(rules.collect()));
    for row in &grid.rows {
        let shown = row.iter().map(|of| match of.tone {
            Tone::Bad => format!("**{}**", cell(&of.text)),
            _ => cell(&of.text),
        });
        text.push_str(&line(shown.collect()));
    }
    text
}

fn picture(figure: &Figure, number: usize) -> String {
    format!("![{}](figures/{})\n\n**Figure {number}.** {}\n", figure.file, figure.file, figure.caption)
}
