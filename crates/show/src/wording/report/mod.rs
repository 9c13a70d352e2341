//! A report: headings, words, tables and figures in order, before it is known where they are shown.
//!
//! In a file or a pipe tables are as wide as they need to be, so that what reads them finds every row on one line. On a
//! terminal nothing is wider than the terminal, and on a page tables are tables.
//!
//! | file | job |
//! |---|---|
//! | `table` | rows of cells |
//! | `build` | how a report is put together |
//! | `text` | text, as wide as need be or within a width |
//! | `plain` | tables as wide as need be |
//! | `fit` | tables within a width: heads wrap, then columns go into groups below each other |
//! | `wrap` | lines of words within a width |
//! | `markdown` | Markdown; figures are files of their own |
//! | `html` | elements of a page |
//! | `reported` | what has a report, and is a document of JSON besides |

mod build;
mod fit;
mod html;
mod markdown;
mod plain;
mod reported;
mod table;
mod text;
mod wrap;

pub use build::{list, table};
pub use reported::{Reported, document};
pub use table::{Cell, Table, Tone};

use std::fmt;

/// What is said of something.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Of the whole; empty where what stands around it has one.
    pub title: String,
    pub parts: Vec<Part>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Part {
    /// Of the parts that follow, up to the next one.
    Heading(String),
    /// Lines that end where they end.
    Words(String),
    /// Sentences that run on: line ends within are there for files only.
    Paragraph(String),
    /// Short notes, one under the other.
    Notes(Vec<String>),
    Table(Table),
    Figure(Figure),
    Text(Text),
}

/// A picture of [`plot`](crate::plot).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure {
    /// Name of its file beside a text in Markdown.
    pub file: String,
    pub caption: String,
    /// A whole SVG document.
    pub svg: String,
}

/// A text as it is, such as a scene file, to which links of a report may lead; shown when it is pointed at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Text {
    /// What links name.
    pub id: String,
    pub title: String,
    pub text: String,
}

impl Report {
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    pub fn headings(&self) -> impl Iterator<Item = &str> {
        self.parts.iter().filter_map(|part| match part {
            Part::Heading(heading) => Some(heading.as_str()),
            _ => None,
        })
    }

    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        self.parts.iter().filter_map(|part| match part {
            Part::Figure(figure) => Some(figure),
            _ => None,
        })
    }

    /// Text of lines of at most so many columns, where words allow it: numbers and names are never broken.
    pub fn fitted(&self, width: usize) -> String {
        text::report(self, Some(width))
    }

    /// Elements of a page; tables scroll within boxes of their own, which the reader is told are about `title` where they have no caption.
    pub fn html(&self, title: &str) -> String {
        html::parts(&self.parts, title)
    }

    /// Markdown; figures are links into the directory `figures`, with their captions.
    pub fn markdown(&self) -> String {
        markdown::report(self)
    }
}

/// Text as wide as need be.
impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&text::report(self, None))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wording::figures::row;

    #[test]
    fn a_report_is_plain_in_files_and_narrow_where_there_is_little_room() {
        let mut report = Report::from("a head of several words\n");
        report.push(table(&[row(["", "µm", "F"]), row(["distal", "2.5", "100.0"])]));
        report.push(Report::paragraph("a sentence that goes on\nand on\n"));
        let plain =
            "a head of several words\n         µm      F\ndistal  2.5  100.0\na sentence that goes on\nand on\n";
        assert_eq!(report.to_string(), plain);
        let narrow =
            "a head of several\n  words\n         µm      F\ndistal  2.5  100.0\na sentence that goes\non and on\n";
        assert_eq!(report.fitted(20), narrow);
        assert_eq!(report.fitted(80), plain.replace("on\nand", "on and"));
    }
}
