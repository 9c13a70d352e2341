//! Tables as CSV: separated by commas, one line per row, column names in the first line. Texts that spreadsheets would
//! evaluate as formulas are written with a leading apostrophe, which reading removes.

use std::io::Write;
use std::path::Path;

use csv::{ErrorKind, ReaderBuilder, StringRecord, Terminator, Writer, WriterBuilder};

use super::value::{escape, infer_kind, parse_cell, unescape};
use super::{Column, Kind, Origin, Table, TableError, Value};
use crate::files::read_at_most;
use crate::limits::MAX_TABLE_BYTES;

/// Reads a CSV file. The `known` columns have their given kind; the kind of other columns is inferred, see
/// [`super::read`].
///
/// # Errors
/// Returns an error if the file cannot be read or is not a table; the error contains the location.
pub fn read_csv(path: &Path, known: &[Column]) -> Result<Table, TableError> {
    let bytes = read_at_most(path, MAX_TABLE_BYTES).map_err(|error| TableError::unopened(path, &error))?;
    parse(&bytes.ok_or_else(|| TableError::too_large(path))?, &path.display().to_string(), known)
}

fn parse(bytes: &[u8], file: &str, known: &[Column]) -> Result<Table, TableError> {
    let mut reader = ReaderBuilder::new().from_reader(bytes);
    let header = reader.headers().map_err(|error| convert_error(&error, file))?;
    let names = header.iter().map(|name| unescape(name.trim()).to_string()).collect();
    let names = check_names(names, file)?;
    let records: Vec<StringRecord> =
        reader.records().collect::<Result<_, _>>().map_err(|error| convert_error(&error, file))?;
    let kind = |(index, name): (usize, &String)| {
        let known = known.iter().find(|column| column.name == *name).map(|column| column.kind);
        let inferred = || infer_kind(records.iter().filter_map(|record| record.get(index)));
        known.or_else(inferred).unwrap_or(Kind::Text)
    };
    let kinds: Vec<Kind> = names.iter().enumerate().map(kind).collect();
    let lines = records.iter().map(|record| record.position().map_or(0, csv::Position::line)).collect();
    let mut table =
        Table::new(names.into_iter().zip(kinds).map(|(name, kind)| Column { name, kind }).collect(), Vec::new());
    table.origin = Origin { file: file.to_string(), lines };
    for (index, record) in records.iter().enumerate() {
        let cells = record.iter().zip(&table.columns).enumerate();
        let read = |(column, (cell, Column { kind, .. })): (usize, (&str, &Column))| {
            parse_cell(cell, *kind).ok_or_else(|| table.cell_error(index, column, cell, *kind))
        };
        let row = cells.map(read).collect::<Result<_, _>>()?;
        table.rows.push(row);
    }
    Ok(table)
}

fn check_names(names: Vec<String>, file: &str) -> Result<Vec<String>, TableError> {
    let invalid_header = |reason: String| Err(TableError(format!("{file}:1: {reason}")));
    match &names[..] {
        [] => invalid_header("the file is empty; the first line must contain the column names".to_string()),
        [only] if only.contains([';', '\t']) => invalid_header(
            "columns are not separated by commas; save the table with commas and decimal points".to_string(),
        ),
        _ => {
            if let Some(index) = names.iter().position(String::is_empty) {
                let column = index + 1;
                return invalid_header(format!("column {column} has no name; the first line must name every column"));
            }
            match (0..names.len()).find(|&index| names[..index].contains(&names[index])) {
                Some(index) => Err(TableError::duplicate_column(file, &names[index])),
                None => Ok(names),
            }
        }
    }
}

/// Parses rows of known columns from lines without a header, up to the first incomplete or damaged line. Also returns
/// the number of bytes that were parsed.
pub fn read_rows(bytes: &[u8], columns: &[Column]) -> (Vec<Vec<Value>>, usize) {
    let mut reader = ReaderBuilder::new().has_headers(false).flexible(true).from_reader(bytes);
    let (mut record, mut rows, mut valid_bytes) = (StringRecord::new(), Vec::new(), 0);
    while let Ok(true) = reader.read_record(&mut record) {
        let end = usize::try_from(reader.position().byte()).unwrap_or(usize::MAX).min(bytes.len());
        // An incomplete line may look valid; it lacks the line feed.
        if record.len() != columns.len() || !bytes[..end].ends_with(b"\n") {
            break;
        }
        let row = record.iter().zip(columns).map(|(cell, column)| parse_cell(cell, column.kind)).collect();
        let Some(row) = row else { break };
        rows.push(row);
        valid_bytes = end;
    }
    (rows, valid_bytes)
}

fn convert_error(error: &csv::Error, file: &str) -> TableError {
    let (position, reason) = match error.kind() {
        ErrorKind::UnequalLengths { pos, expected_len, len } => (
            pos,
            format!(
                "{len} values in {expected_len} columns; put strings with commas in double quotes, and give every line one \
                 value, possibly empty, for every column"
            ),
        ),
        ErrorKind::Utf8 { pos, err } => {
            (pos, format!("column {} is not UTF-8 text; save the table as UTF-8", err.field() + 1))
        }
        _ => return TableError::unreadable(Path::new(file), error),
    };
    TableError(format!("{file}:{}: {reason}", position.as_ref().map_or(1, csv::Position::line)))
}

/// Formats one line of a CSV file, including its line feed.
pub(crate) fn format_csv_line<'a>(values: impl IntoIterator<Item = &'a Value>) -> String {
    let mut writer = writer(Vec::new());
    // Writing to memory cannot fail.
    let written = writer.write_record(values.into_iter().map(cell));
    let bytes = written.ok().and_then(|()| writer.into_inner().ok()).unwrap_or_default();
    String::from_utf8(bytes).unwrap_or_default()
}

/// Text of a cell.
pub(super) fn cell(value: &Value) -> String {
    match value {
        Value::Text(text) => escape(text).into_owned(),
        other => other.text(),
    }
}

pub(super) fn writer<W: Write>(out: W) -> Writer<W> {
    WriterBuilder::new().terminator(Terminator::Any(b'\n')).from_writer(out)
}
