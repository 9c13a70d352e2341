//! Builds a report block by block.

use std::fmt;

use super::{Block, Cell, Figure, Report, Table, Text};

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
        for block in other.into().blocks {
            match block {
                Block::Lines(content) => self.push_str(&content),
                other => self.blocks.push(other),
            }
        }
    }

    pub fn push_str(&mut self, content: &str) {
        match self.blocks.last_mut() {
            Some(Block::Lines(before)) => before.push_str(content),
            _ if content.is_empty() => {}
            _ => self.blocks.push(Block::Lines(content.to_string())),
        }
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

    pub fn with_text(self, id: &str, title: &str, text: String) -> Report {
        self.with(Block::Text(Text { id: id.to_string(), title: title.to_string(), text }))
    }
}

/// Builds a table whose first row is its header.
pub fn table(rows: &[Vec<String>]) -> Report {
    Table::new(rows).into()
}

/// Builds a table without a header.
pub fn list(rows: &[Vec<String>]) -> Report {
    Table::new(rows).header_rows(0).into()
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

impl From<&str> for Report {
    fn from(content: &str) -> Report {
        let mut report = Report::default();
        report.push_str(content);
        report
    }
}

impl From<String> for Report {
    fn from(content: String) -> Report {
        Report::from(content.as_str())
    }
}

impl From<char> for Report {
    fn from(letter: char) -> Report {
        Report::from(letter.to_string())
    }
}
