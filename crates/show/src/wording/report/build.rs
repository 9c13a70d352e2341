//! How a report is put together.

use std::fmt;

use super::{Cell, Figure, Part, Report, Table, Text};

impl Report {
    /// One that begins with this heading.
    pub fn section(heading: &str) -> Report {
        Report::from(Part::Heading(heading.to_string()))
    }

    /// Sentences that run on where there is room, with line ends for files and one at the end.
    pub fn paragraph(words: &str) -> Report {
        Report::from(Part::Paragraph(words.to_string()))
    }

    /// Reports below each other, an empty line between two.
    pub fn join(reports: impl IntoIterator<Item = Report>) -> Report {
        let mut all = Report::default();
        for (index, report) in reports.into_iter().enumerate() {
            if index > 0 {
                all.push('\n');
            }
            all.push(report);
        }
        all
    }

    pub fn push(&mut self, other: impl Into<Report>) {
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

    /// With more below.
    pub fn and(mut self, other: impl Into<Report>) -> Report {
        self.push(other);
        self
    }

    /// With sentences below.
    pub fn words(self, text: impl Into<String>) -> Report {
        self.and(Part::Paragraph(text.into()))
    }

    pub fn notes(self, notes: Vec<String>) -> Report {
        self.and(Part::Notes(notes))
    }

    /// With a table that has a caption.
    pub fn table(self, caption: &str, head: &[&str], rows: Vec<Vec<Cell>>) -> Report {
        let head = head.iter().map(|cell| Cell::new(*cell)).collect();
        let rows: Vec<Vec<Cell>> = std::iter::once(head).chain(rows).collect();
        self.and(Table::new(&rows).caption(caption))
    }

    pub fn figure(self, file: &str, caption: &str, svg: String) -> Report {
        self.and(Part::Figure(Figure { file: file.to_string(), caption: caption.to_string(), svg }))
    }

    pub fn text(self, id: &str, title: &str, text: String) -> Report {
        self.and(Part::Text(Text { id: id.to_string(), title: title.to_string(), text }))
    }
}

/// A table whose first row is its head.
pub fn table(rows: &[Vec<String>]) -> Report {
    Table::new(rows).into()
}

/// A table without a head.
pub fn list(rows: &[Vec<String>]) -> Report {
    Table::new(rows).heads(0).into()
}

/// So that `writeln!` adds lines.
impl fmt::Write for Report {
    fn write_str(&mut self, words: &str) -> fmt::Result {
        self.push_str(words);
        Ok(())
    }
}

impl From<Part> for Report {
    fn from(part: Part) -> Report {
        Report { parts: vec![part], ..Report::default() }
    }
}

impl From<Table> for Report {
    fn from(table: Table) -> Report {
        Report::from(Part::Table(table))
    }
}

impl From<&str> for Report {
    fn from(words: &str) -> Report {
        let mut report = Report::default();
        report.push_str(words);
        report
    }
}

impl From<String> for Report {
    fn from(words: String) -> Report {
        Report::from(words.as_str())
    }
}

impl From<char> for Report {
    fn from(letter: char) -> Report {
        Report::from(letter.to_string())
    }
}
