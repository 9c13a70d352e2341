//! Cells and lines of comma-separated values: names without commas, numbers that read back to the same double.

use std::io::{self, Write};

/// A number; what is not finite (a gap to no object) is an empty cell.
pub fn cell(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { String::new() }
}

/// A line of numbers.
pub fn line(out: &mut (impl Write + ?Sized), values: impl IntoIterator<Item = f64>) -> io::Result<()> {
    let mut separator = "";
    for value in values {
        write!(out, "{separator}{}", cell(value))?;
        separator = ",";
    }
    writeln!(out)
}
