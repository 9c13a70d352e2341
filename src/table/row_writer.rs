//! Writes a table row by row, with the same bytes as [`super::write`].

use std::io::{self, Write};

use super::{Column, Format, Value, csv_file, parquet_file};

/// Writer of a table row by row, for tables larger than memory.
pub struct RowWriter<'a> {
    columns: usize,
    rows: Rows<'a>,
}

enum Rows<'a> {
    Csv(Box<csv_file::Rows<&'a mut (dyn Write + Send)>>),
    Parquet(Box<parquet_file::Rows<'a>>),
}

impl<'a> RowWriter<'a> {
    /// Starts a table with these columns.
    ///
    /// # Errors
    /// Returns an error if the header cannot be written.
    pub fn new(out: &'a mut (dyn Write + Send), format: Format, columns: &[Column]) -> io::Result<Self> {
        let rows = match format {
            Format::Csv => Rows::Csv(Box::new(csv_file::Rows::new(out, columns)?)),
            Format::Parquet => Rows::Parquet(Box::new(parquet_file::Rows::new(out, columns)?)),
        };
        Ok(RowWriter { columns: columns.len(), rows })
    }

    /// Adds a row with one value per column, of the column's kind or missing.
    ///
    /// # Errors
    /// Returns an error if the row cannot be written, or its length differs from the number of columns.
    pub fn add(&mut self, row: Vec<Value>) -> io::Result<()> {
        if row.len() != self.columns {
            let message = format!("a row has {} values for {} columns", row.len(), self.columns);
            return Err(io::Error::new(io::ErrorKind::InvalidData, message));
        }
        match &mut self.rows {
            Rows::Csv(rows) => rows.add(&row),
            Rows::Parquet(rows) => rows.add(row),
        }
    }

    /// Writes the remaining data.
    ///
    /// # Errors
    /// Returns an error if the data cannot be written.
    pub fn finish(self) -> io::Result<()> {
        match self.rows {
            Rows::Csv(rows) => rows.finish(),
            Rows::Parquet(rows) => rows.finish(&[]),
        }
    }
}
