//! A report: a sequence of headings, lines, paragraphs, tables and figures, independent of the output format.
//!
//! In a file or a pipe tables have their natural width, so that programs find every row on one line. On a terminal the
//! text is wrapped to the width of the terminal. On a page tables are HTML tables.
//!
//! `text` renders plain text, `markup` renders Markdown and the HTML elements of a page.

mod markup;
mod text;

use std::fmt;

use serde::Serialize;

/// Result of a command. It can be serialised to a JSON document and formatted as a human-readable report.
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
    /// Title of the report; empty if the report is shown in a context with a title.
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

/// A picture drawn by [`plot`](crate::plot).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure {
    /// Name of the file of the picture, which a Markdown text expects in the directory `figures`.
    pub file: String,
    pub caption: String,
    /// A complete SVG document.
    pub svg: String,
}

impl Report {
    /// Creates a report that consists of this heading.
    pub fn section(heading: &str) -> Report {
        Report::from(Block::Heading(heading.to_string()))
    }

    /// Creates a report of one paragraph. Line ends in `content` have an effect only in unwrapped text.
    pub fn paragraph(content: &str) -> Report {
        Report::from(Block::Paragraph(content.to_string()))
    }

    /// Concatenates reports with empty lines between them; empty reports are skipped.
    pub fn join(reports: impl IntoIterator<Item = Report>) -> Report {
        let join = |all: Report, next: Report| if all.is_empty() { next } else { all.with("\n").with(next) };
        reports.into_iter().filter(|report| !report.is_empty()).fold(Report::default(), join)
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

    /// Text wrapped to `width` columns. Words and numbers are never split, so single lines may be longer.
    pub fn to_wrapped_text(&self, width: usize) -> String {
        text::report(self, Some(width))
    }

    /// HTML elements of a page. Each table is in a scrollable box; if the table has no caption, `title` is its
    /// accessible name.
    pub fn html(&self, title: &str) -> String {
        markup::html(self, title)
    }

    /// Markdown text. Figures are images in the directory `figures`, with their captions.
    pub fn markdown(&self) -> String {
        markup::markdown(self)
    }
}

/// Formats the report as unwrapped text.
impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&text::report(self, None))
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

impl<T: Into<Report>> From<Option<T>> for Report {
    fn from(part: Option<T>) -> Report {
        part.map(Into::into).unwrap_or_default()
    }
}

/// A table. The first column contains text. The other columns contain numbers, unless a cell of the column is
/// [`CellStyle::Prose`]. A row with a single cell is a heading for the rows below it.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Caption; may be empty if the context describes the table. Only tables with a caption are numbered.
    pub caption: String,
    /// Number of leading rows that form the header.
    header_rows: usize,
    key_columns: usize,
    columns_per_group: usize,
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// Creates a table whose first row is the header and whose first column identifies the rows.
    pub fn new<C: Clone + Into<Cell>>(rows: &[Vec<C>]) -> Table {
        let rows = rows.iter().map(|row| row.iter().cloned().map(Into::into).collect()).collect();
        Table { caption: String::new(), header_rows: 1, key_columns: 1, columns_per_group: 1, rows }
    }

    pub fn caption(self, caption: &str) -> Table {
        Table { caption: caption.to_string(), ..self }
    }

    /// Sets the number of leading rows that form the header.
    pub fn header_rows(self, header_rows: usize) -> Table {
        Table { header_rows, ..self }
    }

    /// Sets the number of leading columns that identify a row.
    pub fn key_columns(self, key_columns: usize) -> Table {
        Table { key_columns, ..self }
    }

    /// Sets the size of the groups of columns, after the key columns, that must not be separated.
    pub fn columns_per_group(self, columns_per_group: usize) -> Table {
        Table { columns_per_group, ..self }
    }

    /// Number of cells of the widest row.
    fn columns(&self) -> usize {
        self.rows.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Returns the header rows and the other rows.
    fn split_header(&self) -> (&[Vec<Cell>], &[Vec<Cell>]) {
        self.rows.split_at(self.header_rows.min(self.rows.len()))
    }

    /// Cells of a column below the header.
    fn body_cells(&self, column: usize) -> impl Iterator<Item = &Cell> {
        self.split_header().1.iter().filter_map(move |row| row.get(column))
    }

    /// Whether a cell of the column is prose.
    fn is_prose_column(&self, column: usize) -> bool {
        self.body_cells(column).any(|cell| cell.style == CellStyle::Prose)
    }

    /// Whether the column contains words and no numbers.
    fn is_text_column(&self, column: usize) -> bool {
        let starts = |is: fn(char) -> bool| self.body_cells(column).any(|cell| cell.text.trim_start().starts_with(is));
        let is_part_of_number = |first: char| first.is_ascii_digit() || "-−+.".contains(first);
        column == 0 || self.is_prose_column(column) || starts(char::is_alphabetic) && !starts(is_part_of_number)
    }

    /// Text of the header of a column; header rows are joined.
    fn header_text(&self, column: usize) -> String {
        let cells = self.split_header().0.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.text.trim()).filter(|text| !text.is_empty()).collect::<Vec<_>>().join(" ")
    }
}

/// A column: its header, and a function that returns the cell for an item.
pub type Column<'a, T> = (&'a str, &'a dyn Fn(&T) -> String);

/// Builds a table with one row for each item.
pub fn table_of<T>(items: impl IntoIterator<Item = T>, columns: &[Column<'_, T>]) -> Report {
    let header = columns.iter().map(|(header, _)| header.to_string()).collect();
    let rows = items.into_iter().map(|item| columns.iter().map(|(_, cell)| cell(&item)).collect());
    table(&std::iter::once(header).chain(rows).collect::<Vec<Vec<String>>>())
}

/// Builds a table whose first row is its header.
pub fn table(rows: &[Vec<String>]) -> Report {
    Table::new(rows).into()
}

/// Builds a table without a header.
pub fn list(rows: &[Vec<String>]) -> Report {
    Table::new(rows).header_rows(0).into()
}

/// A cell. If it shows a figure of the report, it contains the key of the figure, so that the page can be checked
/// against the JSON document.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    pub text: String,
    /// Key of the figure and its value in SI units; `None` for other cells.
    pub figure: Option<(String, f64)>,
    pub style: CellStyle,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CellStyle {
    #[default]
    Plain,
    /// A value within its limits.
    Good,
    /// A value outside its limits.
    Bad,
    /// Running text in a table.
    Prose,
}

impl Cell {
    pub fn new(text: impl Into<String>) -> Cell {
        Cell { text: text.into(), ..Cell::default() }
    }

    pub fn prose(text: impl Into<String>) -> Cell {
        Cell { style: CellStyle::Prose, ..Cell::new(text) }
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Cell {
        Cell::new(text)
    }
}
