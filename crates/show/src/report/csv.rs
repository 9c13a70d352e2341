//! Cells and lines of comma-separated values. Names contain no commas; numbers read back to the same double.

use std::io::{self, Write};

/// Formats a number; a number that is not finite (the gap to a missing object) is an empty cell.
pub fn cell(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { String::new() }
}

/// Writes a line of numbers.
pub fn line(out: &mut (impl Write + ?Sized), values: impl IntoIterator<Item = f64>) -> io::Result<()> {
    let mut separator = "";
    for value in values {
        write!(out, "{separator}{}", cell(value))?;
        separator = ",";
    }
    writeln!(out)
}
