//! A paper: sections of words, tables and figures, as Markdown with figures beside it, or as one self-contained HTML file.
//!
//! | file | job |
//! |---|---|
//! | `markdown` | Markdown; figures are files of their own |
//! | `html` | one file, figures in it, light and dark, without a network |

mod html;
mod markdown;

pub use html::paper_html;
pub use markdown::paper_markdown;

/// A paper.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Paper {
    pub title: String,
    pub sections: Vec<Section>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    pub title: String,
    pub blocks: Vec<Block>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    Words(String),
    /// Short notes, one under the other.
    Notes(Vec<String>),
    Table(Grid),
    Figure(Figure),
    /// A text that is shown when it is pointed at.
    Text(Text),
}

/// A text as it is, such as a scene file, to which links of a paper may lead.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Text {
    /// What links name.
    pub id: String,
    pub title: String,
    pub text: String,
}

/// A table: the first column is read as text, the others as figures unless a cell of them is in words.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    pub caption: String,
    pub head: Vec<String>,
    pub rows: Vec<Vec<Cell>>,
}

/// A cell; one that shows a figure of the report says which, so that what is shown can be checked against the JSON.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    pub text: String,
    /// Key of the figure and its value in SI.
    pub figure: Option<(String, f64)>,
    /// A text of the paper that the cell leads to, by its id.
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

/// A picture of [`plot`](crate::plot).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure {
    /// Name of its file beside a Markdown paper.
    pub file: String,
    pub caption: String,
    /// A whole SVG document.
    pub svg: String,
}

impl Section {
    pub fn new(title: &str) -> Section {
        Section { title: title.to_string(), blocks: Vec::new() }
    }

    pub fn words(mut self, text: impl Into<String>) -> Section {
        self.blocks.push(Block::Words(text.into()));
        self
    }

    pub fn notes(mut self, notes: Vec<String>) -> Section {
        self.blocks.push(Block::Notes(notes));
        self
    }

    pub fn table(mut self, caption: &str, head: &[&str], rows: Vec<Vec<Cell>>) -> Section {
        let head = head.iter().map(|cell| cell.to_string()).collect();
        self.blocks.push(Block::Table(Grid { caption: caption.to_string(), head, rows }));
        self
    }

    pub fn text(mut self, id: &str, title: &str, text: String) -> Section {
        self.blocks.push(Block::Text(Text { id: id.to_string(), title: title.to_string(), text }));
        self
    }

    pub fn figure(mut self, file: &str, caption: &str, svg: String) -> Section {
        self.blocks.push(Block::Figure(Figure { file: file.to_string(), caption: caption.to_string(), svg }));
        self
    }
}
