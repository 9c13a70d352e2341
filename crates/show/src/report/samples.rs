//! Samples of a log as comma-separated values: one line per sample, one column per figure with its SI unit. Names
//! contain no commas; numbers read back to the same double.

use std::fmt::Write as _;
use std::io::{self, Write};

use crate::trace::{Channel, Sample};

/// Formats a number; a number that is not finite (the gap to a missing object) is an empty cell.
pub fn cell(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { String::new() }
}

/// Writes the names of the columns.
pub fn csv_head(out: &mut dyn Write, channels: &[Channel]) -> io::Result<()> {
    let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
    writeln!(out, "{}", names.join(","))
}

/// Writes a sample. The cells of contacts with a missing body are empty.
pub fn csv_sample(out: &mut dyn Write, channels: &[Channel], sample: &Sample) -> io::Result<()> {
    let mut line = String::with_capacity(24 * channels.len());
    for channel in channels {
        let value = channel.value(sample);
        if value.is_finite() {
            let _ = write!(line, "{value:?}");
        }
        line.push(',');
    }
    line.pop();
    writeln!(out, "{line}")
}
