//! A sheet: words and tables in order, before it is known where they are shown.
//!
//! In a file or a pipe tables are as wide as they need to be, so that what reads them finds every row on one line. On a
//! terminal nothing is wider than the terminal, and on a page tables are tables.
//!
//! | file | job |
//! |---|---|
//! | `plain` | as wide as need be |
//! | `fit` | tables within a width: heads wrap, then columns go into groups below each other |
//! | `wrap` | lines of words within a width |
//! | `html` | paragraphs and tables of a page |

mod fit;
mod html;
mod plain;
mod wrap;

use std::fmt;

/// What a report says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    parts: Vec<Part>,
}

#[derive(Clone, Debug, PartialEq)]
enum Part {
    /// Lines that end where they end.
    Words(String),
    /// Sentences that run on: line ends within are there for files only.
    Paragraph(String),
    Table(Table),
}

/// Rows of cells: the first column is read as text, the others as figures. A row of one cell is a heading of those below it.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    heads: usize,
    keys: usize,
    together: usize,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// The first row is the head, the first column names the others.
    pub fn new(rows: &[Vec<String>]) -> Table {
        Table { heads: 1, keys: 1, together: 1, rows: rows.to_vec() }
    }

    /// So many of the first rows are heads.
    pub fn heads(self, heads: usize) -> Table {
        Table { heads, ..self }
    }

    /// It takes so many of the first columns to tell one row from another.
    pub fn keys(self, keys: usize) -> Table {
        Table { keys, ..self }
    }

    /// Columns after the keys make sense in packs of so many only.
    pub fn together(self, together: usize) -> Table {
        Table { together, ..self }
    }
}

impl From<Table> for Sheet {
    fn from(table: Table) -> Sheet {
        Sheet { parts: vec![Part::Table(table)] }
    }
}

impl Sheet {
    /// Sheets below each other, an empty line between two.
    pub fn join(sheets: impl IntoIterator<Item = Sheet>) -> Sheet {
        let mut all = Sheet::default();
        for (index, sheet) in sheets.into_iter().enumerate() {
            if index > 0 {
                all.push('\n');
            }
            all.push(sheet);
        }
        all
    }

    pub fn push(&mut self, other: impl Into<Sheet>) {
        for part in other.into().parts {
            match part {
                Part::Words(words) => self.push_str(&words),
                other => self.parts.push(other),
            }
        }
    }

    pub fn push_str(&mut self, words: &str) {
        match self.parts.last_mut() {
            Some(Part::Words(before)) => before.push_str(words),
            _ if words.is_empty() => {}
            _ => self.parts.push(Part::Words(words.to_string())),
        }
    }

    /// Sentences that run on where there is room, with line ends for files and one at the end.
    pub fn paragraph(words: &str) -> Sheet {
        Sheet { parts: vec![Part::Paragraph(words.to_string())] }
    }

    /// With more below.
    pub fn and(mut self, other: impl Into<Sheet>) -> Sheet {
        self.push(other);
        self
    }

    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// Lines of at most so many columns, where words allow it: numbers and names are never broken.
    pub fn fitted(&self, width: usize) -> String {
        let one = |part: &Part| match part {
            Part::Words(words) => wrap::lines(words, width),
            Part::Paragraph(words) => wrap::paragraph(words, width),
            Part::Table(table) => fit::table(table, width),
        };
        self.parts.iter().map(one).collect()
    }

    /// Elements of a page; tables scroll within boxes of their own, which the reader is told are about `title`.
    pub fn html(&self, title: &str) -> String {
        html::parts(&self.parts, title)
    }
}

/// As wide as need be.
impl fmt::Display for Sheet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.parts.iter().try_for_each(|part| match part {
            Part::Words(words) | Part::Paragraph(words) => f.write_str(words),
            Part::Table(table) => f.write_str(&plain::table(&table.rows)),
        })
    }
}

/// So that `writeln!` adds lines.
impl fmt::Write for Sheet {
    fn write_str(&mut self, words: &str) -> fmt::Result {
        self.push_str(words);
        Ok(())
    }
}

impl From<&str> for Sheet {
    fn from(words: &str) -> Sheet {
        let mut sheet = Sheet::default();
        sheet.push_str(words);
        sheet
    }
}

impl From<String> for Sheet {
    fn from(words: String) -> Sheet {
        Sheet::from(words.as_str())
    }
}

impl From<char> for Sheet {
    fn from(letter: char) -> Sheet {
        Sheet::from(letter.to_string())
    }
}

/// A table whose first row is its head.
pub fn table(rows: &[Vec<String>]) -> Sheet {
    Table::new(rows).into()
}

/// A table without a head.
pub fn list(rows: &[Vec<String>]) -> Sheet {
    Table::new(rows).heads(0).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wording::figures::row;

    #[test]
    fn a_sheet_is_plain_in_files_and_narrow_where_there_is_little_room() {
        let mut sheet = Sheet::from("a head of several words\n");
        sheet.push(table(&[row(["", "µm", "F"]), row(["distal", "2.5", "100.0"])]));
        sheet.push(Sheet::paragraph("a sentence that goes on\nand on\n"));
        let plain =
            "a head of several words\n         µm      F\ndistal  2.5  100.0\na sentence that goes on\nand on\n";
        assert_eq!(sheet.to_string(), plain);
        let narrow =
            "a head of several\n  words\n         µm      F\ndistal  2.5  100.0\na sentence that goes\non and on\n";
        assert_eq!(sheet.fitted(20), narrow);
        assert_eq!(sheet.fitted(80), plain.replace("on\nand", "on and"));
    }
}
