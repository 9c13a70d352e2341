//! A report: a sequence of headings, lines, paragraphs, tables and figures, independent of the output format.
//!
//! In a file or a pipe tables have their natural width, so that programs find every row on one line. On a terminal the
//! text is wrapped to the width of the terminal. On a page tables are HTML tables.
//!
//! | file | job |
//! |---|---|
//! | `table` | rows of cells |
//! | `builder` | construction of a report |
//! | `text` | plain text, of natural width or wrapped to a width |
//! | `plain` | tables of natural width |
//! | `fit_width` | tables within a width: headers wrap, then columns are split into groups below each other |
//! | `wrap` | lines of words within a width |
//! | `markdown` | Markdown; figures are separate files |
//! | `html` | HTML elements of a page |
//! | `to_report` | the trait of results with a report and a JSON document |

mod builder;
mod fit_width;
mod html;
mod markdown;
mod plain;
mod table;
mod text;
mod to_report;
mod wrap;

pub use builder::{list, table};
pub use table::{Cell, CellStyle, Table};
pub use to_report::{ToReport, to_json_document};

use std::fmt;

/// A human-readable report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Title of the report; empty if its context has one.
    pub title: String,
    pub blocks: Vec<Block>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// Heading of the blocks up to the next heading.
    Heading(String),
    /// Lines whose line ends are always preserved.
    Lines(String),
    /// A paragraph; its line ends apply to unwrapped text only.
    Paragraph(String),
    /// A list of short notes.
    Notes(Vec<String>),
    Table(Table),
    Figure(Figure),
    Text(Text),
}

/// A picture of [`plot`](crate::plot).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure {
    /// Name of its file in the directory `figures` of a Markdown text.
    pub file: String,
    pub caption: String,
    /// A complete SVG document.
    pub svg: String,
}

/// A verbatim text, such as a scene file, that cells of a table may link to; a page shows it when its link is selected.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Text {
    /// Identifier that links refer to.
    pub id: String,
    pub title: String,
    pub text: String,
}

impl Report {
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    pub fn headings(&self) -> impl Iterator<Item = &str> {
        self.blocks.iter().filter_map(|block| match block {
            Block::Heading(heading) => Some(heading.as_str()),
            _ => None,
        })
    }

    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        self.blocks.iter().filter_map(|block| match block {
            Block::Figure(figure) => Some(figure),
            _ => None,
        })
    }

    /// Text wrapped to `width` columns. Numbers and names are never split, so that single lines may be longer.
    pub fn to_wrapped_text(&self, width: usize) -> String {
        text::report(self, Some(width))
    }

    /// HTML elements of a page. Each table is in a scrollable box; `title` is its accessible name if it has no caption.
    pub fn html(&self, title: &str) -> String {
        html::blocks(&self.blocks, title)
    }

    /// Markdown; figures are images in the directory `figures`, with their captions.
    pub fn markdown(&self) -> String {
        markdown::report(self)
    }
}

/// Formats the report as unwrapped text.
impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&text::report(self, None))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::numbers::row;

    #[test]
    fn formats_unwrapped_and_wrapped_text() {
        let mut report = Report::from("a head of several words\n");
        report.push(table(&[row(["", "µm", "F"]), row(["distal", "2.5", "100.0"])]));
        report.push(Report::paragraph("a sentence that goes on\nand on\n"));
        let plain =
            "a head of several words\n         µm      F\ndistal  2.5  100.0\na sentence that goes on\nand on\n";
        assert_eq!(report.to_string(), plain);
        let narrow =
            "a head of several\n  words\n         µm      F\ndistal  2.5  100.0\na sentence that goes\non and on\n";
        assert_eq!(report.to_wrapped_text(20), narrow);
        assert_eq!(report.to_wrapped_text(80), plain.replace("on\nand", "on and"));
    }
}
