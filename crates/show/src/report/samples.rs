//! Samples of a log as comma-separated values: one line per sample, one column per figure with its SI unit. Names
//! contain no commas; numbers read back to the same double.

use std::io::{self, Write};

use crate::trace::Sample;
use crate::trace::columns::Column;

/// Formats a number; a number that is not finite (the gap to a missing object) is an empty cell.
pub fn cell(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { String::new() }
}

/// Writes the names of the columns.
pub fn csv_head(out: &mut dyn Write, columns: &[Column]) -> io::Result<()> {
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    writeln!(out, "{}", names.join(","))
}

/// Writes a sample. The cells of contacts with a missing body are empty.
pub fn csv_sample(out: &mut dyn Write, columns: &[Column], sample: &Sample) -> io::Result<()> {
    let cells: Vec<String> = columns.iter().map(|column| cell(column.value(sample))).collect();
    writeln!(out, "{}", cells.join(","))
}
