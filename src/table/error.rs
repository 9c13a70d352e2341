//! What can be wrong with a table or its file.

use crate::scene::nearest;

/// Why a table cannot be read, written or used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TableError {
    #[error("{file} is neither CSV nor Parquet by its name: a table is written to NAME.csv or NAME.parquet")]
    Name { file: String },
    #[error("cannot read {file}: {reason}")]
    Read { file: String, reason: String },
    #[error("cannot write {file}: {reason}")]
    Write { file: String, reason: String },
    /// A text file that is no table.
    #[error("{file}:{line}: {reason}")]
    Csv { file: String, line: u64, reason: String },
    #[error("{file} is no Parquet table that can be read here: {reason}")]
    Parquet { file: String, reason: String },
    #[error("{}has two columns `{name}`; rename or remove one of them", of(file))]
    Twice { file: String, name: String },
    #[error("row {row} of a table has {found} values for its {expected} columns")]
    Width { row: usize, found: usize, expected: usize },
    #[error("{}has no column `{name}`{}; its columns: {}", of(file), meant(name, columns), columns.join(", "))]
    NoColumn { file: String, name: String, columns: Vec<String> },
    #[error(
        "{place}, column {number} (`{column}`): {found:?} is not {wanted}; mend the value, or leave the cell empty where there is none"
    )]
    Cell { place: String, number: usize, column: String, found: String, wanted: &'static str },
}

/// A table in a sentence.
fn of(file: &str) -> String {
    if file.is_empty() { "the table ".to_string() } else { format!("{file} ") }
}

fn meant(name: &str, columns: &[String]) -> String {
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    nearest(name, &columns).map_or(String::new(), |near| format!(" (did you mean `{near}`?)"))
}
