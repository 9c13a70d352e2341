//! Typed tables: named columns of a kind, rows of values, reading and writing.
//!
//! The file name determines the format, CSV or Parquet. Numbers are written as the shortest decimal that reads back to
//! the same `f64`, so both formats preserve a table bit for bit. Parquet stores the kinds of columns; in CSV they
//! follow from the notation of values (a number has a point or an exponent, or is `NaN` or `inf`). An empty CSV cell is
//! [`Value::Missing`].
//!
//! | file | job |
//! |---|---|
//! | `value` | values and kinds, conversion from and to text |
//! | `typed_columns` | access to columns by name and kind |
//! | `csv_file`, `parquet_file` | the two formats |
//! | `formula_escape` | escaping of texts that look like formulas |
//! | `row_writer` | writes tables row by row |
//! | `error` | errors with their location |

mod csv_file;
mod error;
mod formula_escape;
mod parquet_file;
mod row_writer;
mod typed_columns;
mod value;

use std::path::Path;

pub use csv_file::{format_csv_line, read_csv, read_rows};
pub use error::TableError;
pub use parquet_file::RowGroupReader;
pub use row_writer::RowWriter;
pub use value::{Kind, Value};

use crate::files::replace_file;

/// A column: its name, which includes the unit, and the kind of its values.
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
    /// One value per column in each row; values are of the column's kind or missing.
    pub rows: Vec<Vec<Value>>,
    /// Source of the table, for messages.
    pub origin: Origin,
}

/// Source of a table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// File name; empty if the table was not read from a file.
    pub file: String,
    /// Line of each row in a CSV file; empty otherwise.
    pub lines: Vec<u64>,
}

/// Tables with the same contents are equal, whatever their source. Numbers are compared by their bits.
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

/// File format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Csv,
    Parquet,
}

/// Returns the format of a file by its extension.
///
/// # Errors
/// Returns an error if the extension is neither `.csv` nor `.parquet`.
pub fn format(path: &Path) -> Result<Format, TableError> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    match extension.to_ascii_lowercase().as_str() {
        "csv" => Ok(Format::Csv),
        "parquet" => Ok(Format::Parquet),
        _ => Err(TableError::UnknownFormat { file: path.display().to_string() }),
    }
}

/// Reads a table.
///
/// The kind of a CSV column is the narrowest kind of all its values: integers, numbers (including integers), flags
/// (`true`,
/// `false`), or texts. A column without values is text.
///
/// # Errors
/// Returns an error if the file cannot be read, or is not a table; the error contains the location.
pub fn read(path: &Path) -> Result<Table, TableError> {
    match format(path)? {
        Format::Csv => read_csv(path, &[]),
        Format::Parquet => parquet_file::read(path),
    }
}

/// Writes a table atomically: an older file is replaced once the new one is on the disk.
///
/// # Errors
/// Returns an error if the file cannot be written, or a value is not of its column's kind.
pub fn write(path: &Path, table: &Table) -> Result<(), TableError> {
    let format = format(path)?;
    check(table)?;
    let written = replace_file(path, |out| match format {
        Format::Csv => csv_file::write(out, table),
        Format::Parquet => parquet_file::write(out, table, &[]),
    });
    written.map_err(|error| TableError::Write { file: path.display().to_string(), reason: error.to_string() })
}

/// Writes a table as Parquet atomically, with metadata and a checksum of its rows, which [`RowGroupReader`] reads.
///
/// # Errors
/// Returns an error if the file cannot be written, or a value is not of its column's kind.
pub fn write_with_metadata(path: &Path, table: &Table, metadata: &[(String, String)]) -> Result<(), TableError> {
    check(table)?;
    let written = replace_file(path, |out| parquet_file::write(out, table, metadata));
    written.map_err(|error| TableError::Write { file: path.display().to_string(), reason: error.to_string() })
}

/// Validates a table: unique column names, one value per column in each row, values of the column's kind.
fn check(table: &Table) -> Result<(), TableError> {
    for (index, column) in table.columns.iter().enumerate() {
        if table.columns[..index].iter().any(|other| other.name == column.name) {
            return Err(TableError::DuplicateColumn { file: table.origin.file.clone(), name: column.name.clone() });
        }
    }
    for (index, row) in table.rows.iter().enumerate() {
        if row.len() != table.columns.len() {
            return Err(TableError::Width { row: index + 1, found: row.len(), expected: table.columns.len() });
        }
        for (value, column) in row.iter().zip(&table.columns) {
            if value.kind().is_some_and(|kind| kind != column.kind) {
                return Err(table.cell_error(index, &column.name, value, column.kind));
            }
        }
    }
    Ok(())
}
