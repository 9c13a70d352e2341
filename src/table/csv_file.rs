//! Tables as CSV: commas, one line a row, the names of the columns in the first one.

use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;

use csv::{ErrorKind, Reader, ReaderBuilder, StringRecord, Terminator, Writer, WriterBuilder};

use super::formula::{FORMULA, is_kept, meant};
use super::value::{self, kind_of};
use super::{Column, Kind, Origin, Table, TableError, Value};
use crate::files::read_at_most;
use crate::limits::LARGEST_TABLE_BYTES;

/// Reads a CSV file. `known` columns have the kind they say; that of the others is found, see [`super::read`].
///
/// # Errors
/// The file cannot be read, or is no table; says where.
pub fn read_csv(path: &Path, known: &[Column]) -> Result<Table, TableError> {
    let file = path.display().to_string();
    let unreadable = |reason: String| TableError::Read { file: file.clone(), reason };
    if path.is_dir() {
        return Err(unreadable("it is a directory; name a file in it".to_string()));
    }
    let bytes = read_at_most(path, LARGEST_TABLE_BYTES).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => unreadable("there is no such file; check the path".to_string()),
        _ => unreadable(error.to_string()),
    })?;
    let most = LARGEST_TABLE_BYTES >> 20;
    let too_large = || unreadable(format!("it is larger than {most} MiB; take some of its rows, or of its columns"));
    let bytes = bytes.ok_or_else(too_large)?;
    parse(&bytes, &file, known)
}

/// Reads the bytes of a CSV file.
pub(super) fn parse(bytes: &[u8], file: &str, known: &[Column]) -> Result<Table, TableError> {
    let mut reader = ReaderBuilder::new().from_reader(bytes);
    let names = names(&mut reader, file)?;
    let (mut records, mut lines) = (Vec::new(), Vec::new());
    for record in reader.records() {
        let record = record.map_err(|error| broken(&error, file))?;
        lines.push(record.position().map_or(0, |position| position.line()));
        records.push(record);
    }
    let kind = |(index, name): (usize, &String)| {
        known
            .iter()
            .find(|column| column.name == *name)
            .map(|column| column.kind)
            .unwrap_or_else(|| kind_of(records.iter().filter_map(|record| record.get(index))).unwrap_or(Kind::Text))
    };
    let kinds: Vec<Kind> = names.iter().enumerate().map(kind).collect();
    let columns = names.into_iter().zip(kinds).map(|(name, kind)| Column { name, kind }).collect();
    let mut table = Table { columns, rows: Vec::new(), origin: Origin { file: file.to_string(), lines } };
    table.rows =
        records.iter().enumerate().map(|(index, record)| row(&table, index, record)).collect::<Result<_, _>>()?;
    Ok(table)
}

fn names(reader: &mut Reader<&[u8]>, file: &str) -> Result<Vec<String>, TableError> {
    let header = reader.headers().map_err(|error| broken(&error, file))?;
    let names: Vec<String> = header.iter().map(|name| meant(name.trim()).to_string()).collect();
    let wrong = |reason: String| Err(TableError::Csv { file: file.to_string(), line: 1, reason });
    if let [only] = &names[..]
        && only.contains([';', '\t'])
    {
        return wrong(
            "columns are not separated by commas; save the table with commas, and points in numbers".to_string(),
        );
    }
    if names.is_empty() {
        return wrong("the file is empty; the first line of a table names its columns".to_string());
    }
    if let Some(index) = names.iter().position(String::is_empty) {
        return wrong(format!("column {} has no name; the first line names every column", index + 1));
    }
    match (0..names.len()).find(|&index| names[..index].contains(&names[index])) {
        Some(index) => Err(TableError::Twice { file: file.to_string(), name: names[index].clone() }),
        None => Ok(names),
    }
}

fn row(table: &Table, index: usize, record: &StringRecord) -> Result<Vec<Value>, TableError> {
    let read = |(cell, column): (&str, &Column)| {
        value::read(cell, column.kind).ok_or_else(|| {
            let found = Value::Text(cell.to_string());
            let at = table.origin.lines.get(index).copied().unwrap_or(0);
            TableError::Cell {
                place: format!("{}:{at}", table.origin.file),
                number: table.find(&column.name).map_or(0, |at| at + 1),
                column: column.name.clone(),
                found: found.text(),
                wanted: column.kind.name(),
            }
        })
    };
    record.iter().zip(&table.columns).map(read).collect()
}

/// Rows of known columns from lines without a header, as far as they go: up to the first line that is torn or damaged. Also
/// says how many bytes they take.
pub fn read_rows(bytes: &[u8], columns: &[Column]) -> (Vec<Vec<Value>>, usize) {
    let mut reader = ReaderBuilder::new().has_headers(false).flexible(true).from_reader(bytes);
    let (mut record, mut rows, mut good) = (StringRecord::new(), Vec::new(), 0);
    while let Ok(true) = reader.read_record(&mut record) {
        let end = usize::try_from(reader.position().byte()).unwrap_or(usize::MAX).min(bytes.len());
        // A line that has not been written to its end may still look like one.
        if record.len() != columns.len() || !bytes[..end].ends_with(b"\n") {
            break;
        }
        let row: Option<Vec<Value>> =
            record.iter().zip(columns).map(|(cell, column)| value::read(cell, column.kind)).collect();
        let Some(row) = row else { break };
        rows.push(row);
        good = end;
    }
    (rows, good)
}

/// What the reader says, in our words.
fn broken(error: &csv::Error, file: &str) -> TableError {
    let csv =
        |line: Option<u64>, reason: String| TableError::Csv { file: file.to_string(), line: line.unwrap_or(1), reason };
    match error.kind() {
        ErrorKind::UnequalLengths { pos, expected_len, len } => csv(
            pos.as_ref().map(csv::Position::line),
            format!(
                "{len} values in {expected_len} columns; a text with a comma stands in double quotes, and every line has a \
                 value, or nothing, for every column"
            ),
        ),
        ErrorKind::Utf8 { pos, err } => csv(
            pos.as_ref().map(csv::Position::line),
            format!("column {} is not UTF-8 text; save the table as UTF-8", err.field() + 1),
        ),
        _ => TableError::Read { file: file.to_string(), reason: error.to_string() },
    }
}

/// Writes the table as CSV.
pub(super) fn write(out: &mut dyn Write, table: &Table) -> io::Result<()> {
    let mut rows = Rows::new(out, &table.columns)?;
    table.rows.iter().try_for_each(|row| rows.add(row))?;
    rows.finish()
}

/// A CSV file that is written row by row.
pub(super) struct Rows<W: Write> {
    writer: Writer<W>,
}

impl<W: Write> Rows<W> {
    pub fn new(out: W, columns: &[Column]) -> io::Result<Self> {
        let mut writer = writer(out);
        writer.write_record(columns.iter().map(|column| harmless(&column.name).into_owned()))?;
        Ok(Rows { writer })
    }

    pub fn add(&mut self, row: &[Value]) -> io::Result<()> {
        Ok(self.writer.write_record(row.iter().map(cell))?)
    }

    pub fn finish(mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// One line of a CSV file, with its line feed.
pub fn line<'a>(values: impl IntoIterator<Item = &'a Value>) -> String {
    let mut writer = writer(Vec::new());
    // Memory takes everything.
    let written = writer.write_record(values.into_iter().map(cell));
    let bytes = written.ok().and_then(|()| writer.into_inner().ok()).unwrap_or_default();
    String::from_utf8(bytes).unwrap_or_default()
}

fn cell(value: &Value) -> String {
    match value {
        Value::Text(text) => harmless(text).into_owned(),
        other => other.text(),
    }
}

/// A text that no spreadsheet takes for a formula, with an apostrophe before it; [`meant`] takes that away again.
fn harmless(text: &str) -> Cow<'_, str> {
    match text.starts_with(FORMULA) || is_kept(text) {
        true => Cow::Owned(format!("'{text}")),
        false => Cow::Borrowed(text),
    }
}

fn writer<W: Write>(out: W) -> Writer<W> {
    WriterBuilder::new().terminator(Terminator::Any(b'\n')).from_writer(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_is_a_formula_and_every_text_comes_back() {
        for text in ["=1+2", "+1", "-x", "@SUM(A1)", "\t=1", "'=1", "''", "''=a", "'tis", "'", "a=b", "", "µ"] {
            let written = harmless(text);
            assert!(!written.starts_with(FORMULA), "{text}");
            assert_eq!(meant(&written), text);
        }
        let columns = vec![Column::new("=cmd()", Kind::Text), Column::new("x_m", Kind::Number)];
        let rows = vec![vec![Value::from("=1+2"), Value::Number(-1.5)], vec![Value::from("-"), Value::Missing]];
        let mut bytes = Vec::new();
        write(&mut bytes, &Table::new(columns.clone(), rows.clone())).expect("memory takes everything");
        assert_eq!(String::from_utf8_lossy(&bytes), "'=cmd(),x_m\n'=1+2,-1.5\n'-,\n");
        let read = parse(&bytes, "t.csv", &[]).expect("a table");
        assert_eq!((read.columns, read.rows), (columns.clone(), rows.clone()));
        assert_eq!(read_rows(line(&rows[0]).as_bytes(), &columns).0, rows[..1]);
    }
}
