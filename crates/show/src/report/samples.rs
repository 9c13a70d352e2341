//! Samples of a log as comma-separated values: one line per sample, one column per figure with its SI unit. Numbers read
//! back to the same double.

use std::fmt::Write as _;
use std::io::{self, Write};

use crate::trace::{Channel, Sample};

/// Formats a number. If it is not finite (the gap to a missing object), the cell is empty.
pub fn cell(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { String::new() }
}

/// Quotes a name that contains a comma, a quote or a line end. Names of scenes do not, those of mechanisms of the library may.
fn quoted(name: &str) -> String {
    match name.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", name.replace('"', "\"\"")),
        false => name.to_string(),
    }
}

/// Writes the names of the columns.
pub fn csv_head(out: &mut dyn Write, channels: &[Channel]) -> io::Result<()> {
    let names: Vec<String> = channels.iter().map(|channel| quoted(&channel.name)).collect();
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

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn names_with_commas_and_quotes_are_quoted() {
        assert_eq!(["a_m", "a,b", "a\"b", "a\nb"].map(quoted), ["a_m", "\"a,b\"", "\"a\"\"b\"", "\"a\nb\""]);
    }
}
