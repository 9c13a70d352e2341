//! Typed tables: named columns of a kind, rows of values, reading and writing.
//!
//! The file name determines the format, CSV or Parquet. Numbers are written as the shortest decimal that reads back to
//! the same `f64`, so both formats preserve a table bit for bit. Parquet stores the kinds of columns; in CSV they
//! follow from the notation of values (a number has a point or an exponent, or is `NaN` or `inf`). An empty CSV cell is
//! [`Value::Missing`].

mod csv_file;
mod parquet_file;
mod value;

use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;

pub use csv_file::{read_csv, read_rows};

pub(crate) use csv_file::format_csv_line;
pub use parquet_file::RowGroups;
pub use value::{Kind, Value};

use crate::files::{cannot_write, check_table_target, replace_file};
use crate::scene::closest_match;
use value::parse_cell;

/// Error while reading, writing or using a table: a single line with the location and the remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct TableError(String);

impl TableError {
    /// Error of a file that cannot be read.
    fn unreadable(path: &Path, reason: impl Display) -> Self {
        TableError(format!("cannot read {}: {reason}", path.display()))
    }

    /// Error of a file that cannot be opened.
    fn unopened(path: &Path, error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::NotFound => TableError::unreadable(path, "there is no such file; check the path"),
            _ if path.is_dir() => TableError::unreadable(path, "it is a directory; name a file in it"),
            _ => TableError::unreadable(path, error),
        }
    }

    /// Error of a file above the size limit.
    fn too_large(path: &Path) -> Self {
        let most = crate::limits::MAX_TABLE_BYTES >> 20;
        TableError::unreadable(path, format!("it is larger than {most} MiB; select fewer rows or columns"))
    }

    fn duplicate_column(file: &str, name: &str) -> Self {
        TableError(format!("{} has two columns `{name}`; rename or remove one of them", table_name(file)))
    }
}

/// Names a table in a sentence.
fn table_name(file: &str) -> &str {
    if file.is_empty() { "the table" } else { file }
}

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
    /// Rows with one value per column. Each value is of the kind of its column, or missing.
    pub rows: Vec<Vec<Value>>,
    /// Source of the table, for messages.
    pub origin: Origin,
}

/// Source of a table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// Name of the file; empty if the table was not read from a file.
    pub file: String,
    /// Line number of each row in a CSV file; empty for other sources.
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

    /// Index of a column.
    ///
    /// # Errors
    /// Returns an error if the table has no column of that name.
    pub fn column(&self, name: &str) -> Result<usize, TableError> {
        self.find(name).ok_or_else(|| {
            let names: Vec<&str> = self.columns.iter().map(|column| column.name.as_str()).collect();
            let suggestion =
                closest_match(name, &names).map_or(String::new(), |near| format!(" (did you mean `{near}`?)"));
            let table = table_name(&self.origin.file);
            TableError(format!("{table} has no column `{name}`{suggestion}; its columns: {}", names.join(", ")))
        })
    }

    /// Index of a column; `None` if the table has no column of that name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }

    /// Values of a column of numbers or integers; `None` for missing values.
    ///
    /// # Errors
    /// Returns an error if there is no such column, or if a value is of another kind.
    pub fn numbers(&self, name: &str) -> Result<Vec<Option<f64>>, TableError> {
        self.values_of_kind(name, Kind::Number, Value::as_number)
    }

    /// Values of a column of integers; `None` for missing values.
    ///
    /// # Errors
    /// Returns an error if there is no such column, or if a value is of another kind.
    pub fn integers(&self, name: &str) -> Result<Vec<Option<i64>>, TableError> {
        self.values_of_kind(name, Kind::Integer, Value::as_integer)
    }

    /// Values of a column of flags; `None` for missing values.
    ///
    /// # Errors
    /// Returns an error if there is no such column, or if a value is of another kind.
    pub fn flags(&self, name: &str) -> Result<Vec<Option<bool>>, TableError> {
        self.values_of_kind(name, Kind::Flag, Value::as_flag)
    }

    /// Values of a column of texts; `None` for missing values.
    ///
    /// # Errors
    /// Returns an error if there is no such column, or if a value is of another kind.
    pub fn texts(&self, name: &str) -> Result<Vec<Option<&str>>, TableError> {
        self.values_of_kind(name, Kind::Text, Value::as_text)
    }

    /// Values of a column, converted by `get`, which returns `None` for values of other kinds.
    fn values_of_kind<'a, T>(
        &'a self,
        name: &str,
        kind: Kind,
        get: impl Fn(&'a Value) -> Option<T>,
    ) -> Result<Vec<Option<T>>, TableError> {
        let index = self.column(name)?;
        let value = |row: &'a Vec<Value>| match row.get(index) {
            None | Some(Value::Missing) => Ok(None),
            Some(value) => get(value).map(Some).ok_or(()),
        };
        self.rows.iter().map(value).collect::<Result<_, _>>().map_err(|()| self.type_error(index, kind))
    }

    /// Returns an error for the first value that is not of the expected kind. In a CSV file one invalid cell makes the
    /// whole column text, so cells are parsed again.
    fn type_error(&self, column: usize, kind: Kind) -> TableError {
        let fits = |value: &Value| match value {
            Value::Text(text) => parse_cell(text, kind).is_some(),
            value => value.fits(kind) || kind == Kind::Number && value.fits(Kind::Integer),
        };
        let row = self.rows.iter().position(|row| row.get(column).is_some_and(|value| !fits(value))).unwrap_or(0);
        self.cell_error(row, column, &self.rows[row][column].text(), kind)
    }

    /// Returns an error for a value that is not of the expected kind.
    fn cell_error(&self, row: usize, column: usize, found: &str, kind: Kind) -> TableError {
        let Origin { file, lines } = &self.origin;
        let location = match lines.get(row) {
            // Line numbers are invalid if rows have been removed.
            Some(line) if lines.len() >= self.rows.len() => format!("{file}:{line}"),
            _ if file.is_empty() => format!("row {}", row + 1),
            _ => format!("{file}, row {}", row + 1),
        };
        TableError(format!(
            "{location}, column {} (`{}`): {found:?} is not {}; correct the value, or leave the cell empty if it is missing",
            column + 1,
            self.columns[column].name,
            kind.description()
        ))
    }

    /// Validates the table: unique column names, one value per column in each row, values of the column's kind.
    fn check(&self) -> Result<(), TableError> {
        for (index, Column { name, .. }) in self.columns.iter().enumerate() {
            if self.columns[..index].iter().any(|other| other.name == *name) {
                return Err(TableError::duplicate_column(&self.origin.file, name));
            }
        }
        for (index, row) in self.rows.iter().enumerate() {
            let (found, expected) = (row.len(), self.columns.len());
            if found != expected {
                let row = index + 1;
                return Err(TableError(format!("row {row} of a table has {found} values for its {expected} columns")));
            }
            let unfit = row.iter().zip(&self.columns).position(|(value, column)| !value.fits(column.kind));
            if let Some(column) = unfit {
                return Err(self.cell_error(index, column, &row[column].text(), self.columns[column].kind));
            }
        }
        Ok(())
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
        _ => {
            let file = path.display();
            Err(TableError(format!("{file} is neither CSV nor Parquet; name a table NAME.csv or NAME.parquet")))
        }
    }
}

/// Reads a table.
///
/// The kind of a CSV column is the narrowest kind of all its values: integers, numbers (including integers), flags
/// (`true`, `false`), or texts. A column without values is text.
///
/// # Errors
/// Returns an error if the file cannot be read, or is not a table; the error contains the location.
pub fn read(path: &Path) -> Result<Table, TableError> {
    match format(path)? {
        Format::Csv => read_csv(path, &[]),
        Format::Parquet => parquet_file::read(path),
    }
}

/// Writes a table atomically: an existing file is replaced only after the new one is on the disk.
///
/// # Errors
/// Returns an error if the file cannot be written, or if a value is not of the kind of its column.
pub fn write(path: &Path, table: &Table) -> Result<(), TableError> {
    write_with_metadata(path, table, &[])
}

/// Like [`write()`], but replaces an existing file only if it is a table of phalanx, or a table with the same columns.
///
/// # Errors
/// See [`write()`]; also returns an error for any other existing file, which is not changed.
pub fn write_over_own(path: &Path, table: &Table) -> Result<(), TableError> {
    format(path)?;
    let columns: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
    check_table_target(path, &columns).map_err(TableError)?;
    write(path, table)
}

/// Like [`write()`], with additional keys and values in the metadata of a Parquet file.
///
/// # Errors
/// See [`write()`].
pub fn write_with_metadata(path: &Path, table: &Table, metadata: &[(String, String)]) -> Result<(), TableError> {
    let format = format(path)?;
    table.check()?;
    let written = replace_file(path, |out| {
        let mut writer = RowWriter::new(out, format, &table.columns)?;
        table.rows.iter().try_for_each(|row| writer.add(row))?;
        writer.finish(metadata)
    });
    written.map_err(|error| TableError(cannot_write(path, error)))
}

/// Writes a table row by row, for tables that are larger than memory. The same rows give the same bytes.
pub enum RowWriter<'a> {
    Csv(Box<csv::Writer<&'a mut (dyn Write + Send)>>),
    Parquet(Box<parquet_file::Writer<'a>>),
}

impl<'a> RowWriter<'a> {
    /// Starts a table with these columns.
    ///
    /// # Errors
    /// Returns an error if the header cannot be written.
    pub fn new(out: &'a mut (dyn Write + Send), format: Format, columns: &[Column]) -> io::Result<Self> {
        Ok(match format {
            Format::Csv => {
                let mut writer = csv_file::writer(out);
                writer.write_record(columns.iter().map(|column| value::escape(&column.name).into_owned()))?;
                RowWriter::Csv(Box::new(writer))
            }
            Format::Parquet => RowWriter::Parquet(Box::new(parquet_file::Writer::new(out, columns)?)),
        })
    }

    /// Adds a row with one value per column. Each value is of the kind of its column, or missing.
    ///
    /// # Errors
    /// Returns an error if the row cannot be written, or if its length differs from the number of columns.
    pub fn add(&mut self, row: &[Value]) -> io::Result<()> {
        match self {
            RowWriter::Csv(writer) => Ok(writer.write_record(row.iter().map(csv_file::cell))?),
            RowWriter::Parquet(writer) => writer.add(row),
        }
    }

    /// Writes the remaining data; for a Parquet file, also the metadata.
    ///
    /// # Errors
    /// Returns an error if the data cannot be written.
    pub fn finish(self, metadata: &[(String, String)]) -> io::Result<()> {
        match self {
            RowWriter::Csv(mut writer) => writer.flush(),
            RowWriter::Parquet(writer) => writer.finish(metadata),
        }
    }
}
