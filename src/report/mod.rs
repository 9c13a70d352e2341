//! Reports of commands: documents for JSON and CSV, and text.
//!
//! The crate `phalanx-show` reports runs and grasps; this module adds the reports of studies and logs.

pub mod offsets;
pub mod replay;
pub mod reproduce;
pub mod simulation;
pub mod studies;
pub mod sweep;
pub mod validation;

pub use phalanx_show::report::*;

use serde_json::Value;

/// Formats rows as CSV. Columns are separated by spaces; a column is a key of the rows, or `name=key/key` for a value
/// in a nested object. Missing values are empty; texts of columns that end in `reason` are quoted, other texts contain no
/// commas.
fn rows_csv(rows: impl IntoIterator<Item = Value>, columns: &str) -> String {
    let columns = columns.split(' ').map(|column| column.split_once('=').unwrap_or((column, column)));
    let columns: Vec<(&str, String)> = columns.map(|(name, path)| (name, format!("/{path}"))).collect();
    let mut text = columns.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(",") + "\n";
    for row in rows {
        let cell = |(name, path): &(&str, String)| match row.pointer(path) {
            None | Some(Value::Null) => String::new(),
            Some(Value::String(text)) if name.ends_with("reason") => format!("\"{}\"", text.replace('"', "\"\"")),
            Some(Value::String(text)) => text.clone(),
            Some(Value::Number(number)) if number.is_f64() => format!("{:?}", number.as_f64().unwrap_or_default()),
            Some(other) => other.to_string(),
        };
        text.push_str(&columns.iter().map(cell).collect::<Vec<_>>().join(","));
        text.push('\n');
    }
    text
}
