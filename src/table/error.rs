//! Errors of tables and their files.

use crate::scene::closest_match;

/// Error while reading, writing or using a table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TableError {
    #[error("{file} is neither CSV nor Parquet; name a table NAME.csv or NAME.parquet")]
    UnknownFormat { file: String },
    #[error("cannot read {file}: {reason}")]
    Read { file: String, reason: String },
    #[error("cannot write {file}: {reason}")]
    Write { file: String, reason: String },
    /// A CSV file that is not a valid table.
    #[error("{file}:{line}: {reason}")]
    Csv { file: String, line: u64, reason: String },
    #[error("{file} is not a readable Parquet table: {reason}")]
    Parquet { file: String, reason: String },
    #[error("{}has two columns `{name}`; rename or remove one of them", table_name(file))]
    DuplicateColumn { file: String, name: String },
    #[error("row {row} of a table has {found} values for its {expected} columns")]
    Width { row: usize, found: usize, expected: usize },
    #[error("{}has no column `{name}`{}; its columns: {}", table_name(file), suggestion(name, columns), columns.join(", "))]
    NoColumn { file: String, name: String, columns: Vec<String> },
    #[error(
        "{location}, column {number} (`{column}`): {found:?} is not {expected_kind}; correct the value, or leave the cell empty if it is missing"
    )]
    Cell { location: String, number: usize, column: String, found: String, expected_kind: &'static str },
}

/// Names a table in a sentence.
fn table_name(file: &str) -> String {
    if file.is_empty() { "the table ".to_string() } else { format!("{file} ") }
}

fn suggestion(name: &str, columns: &[String]) -> String {
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    closest_match(name, &columns).map_or(String::new(), |near| format!(" (did you mean `{near}`?)"))
}
