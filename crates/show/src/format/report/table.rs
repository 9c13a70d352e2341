//! A table as rows of cells.

use super::Report;

/// A table. The first column contains text, the others numbers unless one of their cells is [`CellStyle::Prose`]. A row
/// of one cell is a heading of the rows below it.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// May be empty if the context describes the table; tables with a caption are numbered.
    pub caption: String,
    /// Number of leading rows that form the header.
    pub(super) header_rows: usize,
    pub(super) key_columns: usize,
    pub(super) columns_per_group: usize,
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

    /// Sets the number of columns after the keys that must not be separated.
    pub fn columns_per_group(self, columns_per_group: usize) -> Table {
        Table { columns_per_group, ..self }
    }

    /// Number of cells of the widest row.
    pub(super) fn columns(&self) -> usize {
        self.rows.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Returns the header rows and the other rows.
    pub(super) fn split_header(&self) -> (&[Vec<Cell>], &[Vec<Cell>]) {
        self.rows.split_at(self.header_rows.min(self.rows.len()))
    }

    /// Cells of a column below the header.
    fn body_cells(&self, column: usize) -> impl Iterator<Item = &Cell> {
        self.split_header().1.iter().filter_map(move |row| row.get(column))
    }

    /// Whether a cell of the column is prose.
    pub(super) fn is_prose_column(&self, column: usize) -> bool {
        self.body_cells(column).any(|cell| cell.style == CellStyle::Prose)
    }

    /// Whether the column contains words and no numbers.
    pub(super) fn is_text_column(&self, column: usize) -> bool {
        let starts = |is: fn(char) -> bool| self.body_cells(column).any(|cell| cell.text.trim_start().starts_with(is));
        column == 0 || self.is_prose_column(column) || starts(char::is_alphabetic) && !starts(is_part_of_number)
    }

    /// Text of the header of a column; header rows are joined.
    pub(super) fn header_text(&self, column: usize) -> String {
        let cells = self.split_header().0.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.text.trim()).filter(|text| !text.is_empty()).collect::<Vec<_>>().join(" ")
    }
}

fn is_part_of_number(first: char) -> bool {
    first.is_ascii_digit() || "-−+.".contains(first)
}

/// Builds a table whose first row is its header.
pub fn table(rows: &[Vec<String>]) -> Report {
    Table::new(rows).into()
}

/// Builds a table without a header.
pub fn list(rows: &[Vec<String>]) -> Report {
    Table::new(rows).header_rows(0).into()
}

/// A cell. A cell with a figure of the report contains its key, so that the page can be checked against the JSON
/// document.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    pub text: String,
    /// Key of the figure, and its value in SI units.
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
