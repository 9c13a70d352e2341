//! A report: a sequence of headings, lines, paragraphs, tables and figures, independent of the output format.
//!
//! In a file or a pipe tables have their natural width, so that programs find every row on one line. On a terminal the
//! text is wrapped to the width of the terminal. On a page tables are HTML tables.
//!
//! | file | job |
//! |---|---|
//! | `table` | rows of cells |
//! | `text` | plain text, of natural width or wrapped to a width |
//! | `markdown` | Markdown; figures are separate files |
//! | `html` | HTML elements of a page |

mod html;
mod markdown;
mod table;
mod text;

pub use table::{Cell, CellStyle, Table, list, table};

use std::fmt;

use serde::Serialize;

/// Result of a command: serialises to a JSON document and formats as a report for people.
pub trait ToReport: Serialize {
    /// Returns the report, which can be rendered as text, Markdown or HTML.
    fn report(&self) -> Report;

    /// Returns the JSON document with a final line end.
    fn json(&self) -> String {
        to_json_document(self)
    }
}

/// Serialises a value as a JSON document with a final line end.
///
/// Floats are printed in the shortest form that reads back to the same double; numbers that are not finite become null.
pub fn to_json_document<T: Serialize + ?Sized>(value: &T) -> String {
    serde_json::to_string_pretty(value).expect("a document is plain data with string keys") + "\n"
}

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

impl Report {
    /// Creates a report that begins with this heading.
    pub fn section(heading: &str) -> Report {
        Report::from(Block::Heading(heading.to_string()))
    }

    /// Creates a report of one paragraph. Line ends in `content` apply to unwrapped text only.
    pub fn paragraph(content: &str) -> Report {
        Report::from(Block::Paragraph(content.to_string()))
    }

    /// Concatenates reports, separated by empty lines.
    pub fn join(reports: impl IntoIterator<Item = Report>) -> Report {
        let join = |all: Report, next: Report| if all.is_empty() { next } else { all.with("\n").with(next) };
        reports.into_iter().fold(Report::default(), join)
    }

    pub fn push(&mut self, other: impl Into<Report>) {
        for block in other.into().blocks {
            if let (Some(Block::Lines(before)), Block::Lines(content)) = (self.blocks.last_mut(), &block) {
                before.push_str(content);
            } else {
                self.blocks.push(block);
            }
        }
    }

    pub fn push_str(&mut self, content: &str) {
        self.push(content);
    }

    /// Appends another report.
    pub fn with(mut self, other: impl Into<Report>) -> Report {
        self.push(other);
        self
    }

    /// Appends a paragraph.
    pub fn with_paragraph(self, text: impl Into<String>) -> Report {
        self.with(Block::Paragraph(text.into()))
    }

    pub fn with_notes(self, notes: Vec<String>) -> Report {
        self.with(Block::Notes(notes))
    }

    /// Appends a table with a caption; `head` is its header row.
    pub fn with_table(self, caption: &str, head: &[&str], rows: Vec<Vec<Cell>>) -> Report {
        let head = head.iter().map(|cell| Cell::new(*cell)).collect();
        let rows: Vec<Vec<Cell>> = std::iter::once(head).chain(rows).collect();
        self.with(Table::new(&rows).caption(caption))
    }

    pub fn with_figure(self, file: &str, caption: &str, svg: String) -> Report {
        self.with(Block::Figure(Figure { file: file.to_string(), caption: caption.to_string(), svg }))
    }

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

    /// Text wrapped to `width` columns. Words and numbers are never split, so that single lines may be longer.
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

/// Allows `writeln!` to append lines.
impl fmt::Write for Report {
    fn write_str(&mut self, content: &str) -> fmt::Result {
        self.push_str(content);
        Ok(())
    }
}

impl From<Block> for Report {
    fn from(block: Block) -> Report {
        Report { blocks: vec![block], ..Report::default() }
    }
}

impl From<Table> for Report {
    fn from(table: Table) -> Report {
        Report::from(Block::Table(table))
    }
}

impl From<String> for Report {
    fn from(content: String) -> Report {
        if content.is_empty() { Report::default() } else { Report::from(Block::Lines(content)) }
    }
}

impl From<&str> for Report {
    fn from(content: &str) -> Report {
        Report::from(content.to_string())
    }
}

impl From<char> for Report {
    fn from(letter: char) -> Report {
        Report::from(letter.to_string())
    }
}
