//! Rows of cells.

/// A table: the first column is read as text, the others as figures unless a cell of them is in words. A row of one cell is a
/// heading of those below it.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Empty where what stands around it says what it is; with one, tables are numbered.
    pub caption: String,
    /// So many of the first rows are heads.
    pub(super) heads: usize,
    pub(super) keys: usize,
    pub(super) together: usize,
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// The first row is the head, the first column names the others.
    pub fn new<C: Clone + Into<Cell>>(rows: &[Vec<C>]) -> Table {
        let rows = rows.iter().map(|row| row.iter().cloned().map(Into::into).collect()).collect();
        Table { caption: String::new(), heads: 1, keys: 1, together: 1, rows }
    }

    pub fn caption(self, caption: &str) -> Table {
        Table { caption: caption.to_string(), ..self }
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

    /// Cells of the widest row.
    pub(super) fn columns(&self) -> usize {
        self.rows.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Heads, and what they are of.
    pub(super) fn parted(&self) -> (&[Vec<Cell>], &[Vec<Cell>]) {
        self.rows.split_at(self.heads.min(self.rows.len()))
    }

    /// Whether a cell of the column is in words.
    pub(super) fn is_in_words(&self, column: usize) -> bool {
        self.parted().1.iter().filter_map(|row| row.get(column)).any(|cell| cell.tone == Tone::Words)
    }
}

/// A cell; one that shows a figure of the report says which, so that what is shown can be checked against the JSON.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    pub text: String,
    /// Key of the figure and its value in SI.
    pub figure: Option<(String, f64)>,
    /// A text of the report that the cell leads to, by its id.
    pub link: Option<String>,
    pub tone: Tone,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    #[default]
    Plain,
    /// As it should be.
    Good,
    /// Not as it should be.
    Bad,
    /// Running text in a table.
    Words,
}

impl Cell {
    pub fn new(text: impl Into<String>) -> Cell {
        Cell { text: text.into(), ..Cell::default() }
    }

    pub fn words(text: impl Into<String>) -> Cell {
        Cell { tone: Tone::Words, ..Cell::new(text) }
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Cell {
        Cell::new(text)
    }
}

impl AsRef<str> for Cell {
    fn as_ref(&self) -> &str {
        &self.text
    }
}
