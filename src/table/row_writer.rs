//! Rows to a file as they come: its bytes are those that [`super::write`] gives the whole table.

use std::io::{self, Write};

use super::{Column, Format, Value, csv_file, parquet_file};

/// A table that is written row by row, so that it may be larger than memory.
pub struct RowWriter<'a> {
    columns: usize,
    rows: Rows<'a>,
}

enum Rows<'a> {
    Csv(Box<csv_file::Rows<&'a mut (dyn Write + Send)>>),
    Parquet(Box<parquet_file::Rows<'a>>),
}

impl<'a> RowWriter<'a> {
    /// A table of these columns.
    ///
    /// # Errors
    /// `out` does not take its head.
    pub fn new(out: &'a mut (dyn Write + Send), format: Format, columns: &[Column]) -> io::Result<Self> {
        let rows = match format {
            Format::Csv => Rows::Csv(Box::new(csv_file::Rows::new(out, columns)?)),
            Format::Parquet => Rows::Parquet(Box::new(parquet_file::Rows::new(out, columns)?)),
        };
        Ok(RowWriter { columns: columns.len(), rows })
    }

    /// Adds a row: a value of its kind, or none, for each of the columns.
    ///
    /// # Errors
    /// `out` does not take it, or the row has other columns.
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

    /// Writes what is left to be written.
    ///
    /// # Errors
    /// `out` does not take it.
    pub fn finish(self) -> io::Result<()> {
        match self.rows {
            Rows::Csv(rows) => rows.finish(),
            Rows::Parquet(rows) => rows.finish(&[]),
        }
    }
}
