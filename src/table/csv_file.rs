//! Tables as CSV: separated by commas, one line per row, column names in the first line.

use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;

use csv::{ErrorKind, Reader, ReaderBuilder, StringRecord, Terminator, Writer, WriterBuilder};

use super::formula_escape::{FORMULA_PREFIXES, is_escaped, unescape};
use super::value::{self, infer_kind};
use super::{Column, Kind, Origin, Table, TableError, Value};
use crate::files::read_at_most;
use crate::limits::MAX_TABLE_BYTES;

/// Reads a CSV file. `known` columns have the given kind; the kind of other columns is inferred, see [`super::read`].
///
/// # Errors
/// Returns an error if the file cannot be read, or is not a table; the error contains the location.
pub fn read_csv(path: &Path, known: &[Column]) -> Result<Table, TableError> {
    let file = path.display().to_string();
    let read_error = |reason: String| TableError::Read { file: file.clone(), reason };
    if path.is_dir() {
        return Err(read_error("it is a directory; name a file in it".to_string()));
    }
    let bytes = read_at_most(path, MAX_TABLE_BYTES).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => read_error("there is no such file; check the path".to_string()),
        _ => read_error(error.to_string()),
    })?;
    let most = MAX_TABLE_BYTES >> 20;
    let too_large = || read_error(format!("it is larger than {most} MiB; select fewer rows or columns"));
    let bytes = bytes.ok_or_else(too_large)?;
    parse(&bytes, &file, known)
}

/// Parses the bytes of a CSV file.
pub(super) fn parse(bytes: &[u8], file: &str, known: &[Column]) -> Result<Table, TableError> {
    let mut reader = ReaderBuilder::new().from_reader(bytes);
    let names = names(&mut reader, file)?;
    let (mut records, mut lines) = (Vec::new(), Vec::new());
    for record in reader.records() {
        let record = record.map_err(|error| convert_error(&error, file))?;
        lines.push(record.position().map_or(0, |position| position.line()));
        records.push(record);
    }
    let kind =
        |(index, name): (usize, &String)| {
            known.iter().find(|column| column.name == *name).map(|column| column.kind).unwrap_or_else(|| {
                infer_kind(records.iter().filter_map(|record| record.get(index))).unwrap_or(Kind::Text)
            })
        };
    let kinds: Vec<Kind> = names.iter().enumerate().map(kind).collect();
    let columns = names.into_iter().zip(kinds).map(|(name, kind)| Column { name, kind }).collect();
    let mut table = Table { columns, rows: Vec::new(), origin: Origin { file: file.to_string(), lines } };
    table.rows =
        records.iter().enumerate().map(|(index, record)| row(&table, index, record)).collect::<Result<_, _>>()?;
    Ok(table)
}

fn names(reader: &mut Reader<&[u8]>, file: &str) -> Result<Vec<String>, TableError> {
    let header = reader.headers().map_err(|error| convert_error(&error, file))?;
    let names: Vec<String> = header.iter().map(|name| unescape(name.trim()).to_string()).collect();
    let invalid_header = |reason: String| Err(TableError::Csv { file: file.to_string(), line: 1, reason });
    if let [only] = &names[..]
        && only.contains([';', '\t'])
    {
        return invalid_header(
            "columns are not separated by commas; save the table with commas and decimal points".to_string(),
        );
    }
    if names.is_empty() {
        return invalid_header("the file is empty; the first line must contain the column names".to_string());
    }
    if let Some(index) = names.iter().position(String::is_empty) {
        return invalid_header(format!("column {} has no name; the first line must name every column", index + 1));
    }
    match (0..names.len()).find(|&index| names[..index].contains(&names[index])) {
        Some(index) => Err(TableError::DuplicateColumn { file: file.to_string(), name: names[index].clone() }),
        None => Ok(names),
    }
}

fn row(table: &Table, index: usize, record: &StringRecord) -> Result<Vec<Value>, TableError> {
    let read = |(cell, column): (&str, &Column)| {
        value::parse_cell(cell, column.kind).ok_or_else(|| {
            let found = Value::Text(cell.to_string());
            let line_number = table.origin.lines.get(index).copied().unwrap_or(0);
            TableError::Cell {
                location: format!("{}:{line_number}", table.origin.file),
                number: table.find(&column.name).map_or(0, |column_index| column_index + 1),
                column: column.name.clone(),
                found: found.text(),
                expected_kind: column.kind.description(),
            }
        })
    };
    record.iter().zip(&table.columns).map(read).collect()
}

/// Parses rows of known columns from lines without a header, up to the first incomplete or damaged line. Also returns
/// the number of bytes parsed.
pub fn read_rows(bytes: &[u8], columns: &[Column]) -> (Vec<Vec<Value>>, usize) {
    let mut reader = ReaderBuilder::new().has_headers(false).flexible(true).from_reader(bytes);
    let (mut record, mut rows, mut valid_bytes) = (StringRecord::new(), Vec::new(), 0);
    while let Ok(true) = reader.read_record(&mut record) {
        let end = usize::try_from(reader.position().byte()).unwrap_or(usize::MAX).min(bytes.len());
        // An incomplete line may look valid; it lacks the line feed.
        if record.len() != columns.len() || !bytes[..end].ends_with(b"\n") {
            break;
        }
        let row: Option<Vec<Value>> =
            record.iter().zip(columns).map(|(cell, column)| value::parse_cell(cell, column.kind)).collect();
        let Some(row) = row else { break };
        rows.push(row);
        valid_bytes = end;
    }
    (rows, valid_bytes)
}

/// Converts an error of the CSV reader.
fn convert_error(error: &csv::Error, file: &str) -> TableError {
    let csv =
        |line: Option<u64>, reason: String| TableError::Csv { file: file.to_string(), line: line.unwrap_or(1), reason };
    match error.kind() {
        ErrorKind::UnequalLengths { pos, expected_len, len } => csv(
            pos.as_ref().map(csv::Position::line),
            format!(
                "{len} values in {expected_len} columns; put strings with commas in double quotes, and give every line one \
                 value, possibly empty, for every column"
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

/// Writer of a CSV file row by row.
pub(super) struct Rows<W: Write> {
    writer: Writer<W>,
}

impl<W: Write> Rows<W> {
    pub fn new(out: W, columns: &[Column]) -> io::Result<Self> {
        let mut writer = writer(out);
        writer.write_record(columns.iter().map(|column| escape(&column.name).into_owned()))?;
        Ok(Rows { writer })
    }

    pub fn add(&mut self, row: &[Value]) -> io::Result<()> {
        Ok(self.writer.write_record(row.iter().map(cell))?)
    }

    pub fn finish(mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// Formats one line of a CSV file, including its line feed.
pub fn format_csv_line<'a>(values: impl IntoIterator<Item = &'a Value>) -> String {
    let mut writer = writer(Vec::new());
    // Writing to memory cannot fail.
    let written = writer.write_record(values.into_iter().map(cell));
    let bytes = written.ok().and_then(|()| writer.into_inner().ok()).unwrap_or_default();
    String::from_utf8(bytes).unwrap_or_default()
}

fn cell(value: &Value) -> String {
    match value {
        Value::Text(text) => escape(text).into_owned(),
        other => other.text(),
    }
}

/// Escapes a text that spreadsheets would evaluate with a leading apostrophe, which [`unescape`] removes.
fn escape(text: &str) -> Cow<'_, str> {
    match text.starts_with(FORMULA_PREFIXES) || is_escaped(text) {
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
    fn escapes_formulas_and_restores_every_text() {
        for text in ["=1+2", "+1", "-x", "@SUM(A1)", "\t=1", "'=1", "''", "''=a", "'tis", "'", "a=b", "", "µ"] {
            let written = escape(text);
            assert!(!written.starts_with(FORMULA_PREFIXES), "{text}");
            assert_eq!(unescape(&written), text);
        }
        let columns = vec![Column::new("=cmd()", Kind::Text), Column::new("x_m", Kind::Number)];
        let rows = vec![vec![Value::from("=1+2"), Value::Number(-1.5)], vec![Value::from("-"), Value::Missing]];
        let mut bytes = Vec::new();
        write(&mut bytes, &Table::new(columns.clone(), rows.clone())).expect("writing to memory");
        assert_eq!(String::from_utf8_lossy(&bytes), "'=cmd(),x_m\n'=1+2,-1.5\n'-,\n");
        let read = parse(&bytes, "t.csv", &[]).expect("a table");
        assert_eq!((read.columns, read.rows), (columns.clone(), rows.clone()));
        assert_eq!(read_rows(format_csv_line(&rows[0]).as_bytes(), &columns).0, rows[..1]);
    }
}
