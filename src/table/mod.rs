//! Typed tables: columns with a name and a kind, rows of values, to and from files.
//!
//! A file is CSV or Parquet by its name. Numbers are written as the shortest decimal that is read as the same `f64`, so that
//! either file gives back the table bit for bit; Parquet keeps the kinds of columns, CSV shows them by how values are
//! written (a number has a point, an exponent, or is `NaN` or `inf`). What is empty in a CSV file is [`Value::Missing`].
//!
//! | file | job |
//! |---|---|
//! | `value` | values and kinds, to and from text |
//! | `get` | columns by name, of one kind |
//! | `csv_file`, `parquet_file` | either format |
//! | `row_writer` | rows to either format, as they come |
//! | `error` | what can be wrong, with its place |

mod csv_file;
mod error;
mod formula;
mod get;
mod parquet_file;
mod row_writer;
mod value;

use std::path::Path;

pub use csv_file::{line, read_csv, read_rows};
pub use error::TableError;
pub use parquet_file::Groups;
pub use row_writer::RowWriter;
pub use value::{Kind, Value};

use crate::files::replace;

/// A column: its name, which carries the unit, and what its values are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    pub name: String,
    pub kind: Kind,
}

impl Column {
    pub fn new(name: impl Into<String>, kind: Kind) -> Self {
        Column { name: name.into(), kind }
    }
}

/// Rows of values under named columns.
#[derive(Clone, Debug, Default)]
pub struct Table {
    pub columns: Vec<Column>,
    /// Each as long as there are columns; values are of the column's kind or missing.
    pub rows: Vec<Vec<Value>>,
    /// Where the table was read, for messages.
    pub origin: Origin,
}

/// Where a table comes from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// Its file; empty if it was not read.
    pub file: String,
    /// Line of each row in a text file; empty otherwise.
    pub lines: Vec<u64>,
}

/// Tables are equal that say the same, wherever they come from. Numbers are compared by their bits.
impl PartialEq for Table {
    fn eq(&self, other: &Self) -> bool {
        self.columns == other.columns && self.rows == other.rows
    }
}

impl Table {
    pub fn new(columns: Vec<Column>, rows: Vec<Vec<Value>>) -> Self {
        Table { columns, rows, origin: Origin::default() }
    }
}

/// Formats of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Csv,
    Parquet,
}

/// The format of a file by its name.
///
/// # Errors
/// A name that ends neither in `.csv` nor in `.parquet`.
pub fn format(path: &Path) -> Result<Format, TableError> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    match extension.to_ascii_lowercase().as_str() {
        "csv" => Ok(Format::Csv),
        "parquet" => Ok(Format::Parquet),
        _ => Err(TableError::Name { file: path.display().to_string() }),
    }
}

/// Reads a table.
///
/// The kind of a column of a CSV file is that of all its values: integers, numbers (integers among them), flags
/// (`true`, `false`), or texts; a column without values is text.
///
/// # Errors
/// The file cannot be read, or is no table; says where.
pub fn read(path: &Path) -> Result<Table, TableError> {
    match format(path)? {
        Format::Csv => read_csv(path, &[]),
        Format::Parquet => parquet_file::read(path),
    }
}

/// Writes a table, whole or not at all: an older file is replaced when the new one is on the disk.
///
/// # Errors
/// The file cannot be written, or a value is not of its column's kind.
pub fn write(path: &Path, table: &Table) -> Result<(), TableError> {
    let format = format(path)?;
    check(table)?;
    let written = replace(path, |out| match format {
        Format::Csv => csv_file::write(out, table),
        Format::Parquet => parquet_file::write(out, table, &[]),
    });
    written.map_err(|error| TableError::Write { file: path.display().to_string(), reason: error.to_string() })
}

/// Writes a table as Parquet, whole or not at all, with notes of what it is in its metadata and a checksum of its rows:
/// [`Groups`] reads them.
///
/// # Errors
/// The file cannot be written, or a value is not of its column's kind.
pub fn write_noted(path: &Path, table: &Table, notes: &[(String, String)]) -> Result<(), TableError> {
    check(table)?;
    let written = replace(path, |out| parquet_file::write(out, table, notes));
    written.map_err(|error| TableError::Write { file: path.display().to_string(), reason: error.to_string() })
}

/// Whether the table is one: rows as long as there are columns, values of their kinds, names that differ.
fn check(table: &Table) -> Result<(), TableError> {
    for (index, column) in table.columns.iter().enumerate() {
        if table.columns[..index].iter().any(|other| other.name == column.name) {
            return Err(TableError::Twice { file: table.origin.file.clone(), name: column.name.clone() });
        }
    }
    for (index, row) in table.rows.iter().enumerate() {
        if row.len() != table.columns.len() {
            return Err(TableError::Width { row: index + 1, found: row.len(), expected: table.columns.len() });
        }
        for (value, column) in row.iter().zip(&table.columns) {
            if value.kind().is_some_and(|kind| kind != column.kind) {
                return Err(table.cell(index, &column.name, value, column.kind));
            }
        }
    }
    Ok(())
}
