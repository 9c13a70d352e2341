//! Samples of a log as comma-separated values: one line per sample, one column per figure with its SI unit.

use std::io::{self, Write};

use super::csv::line;
use crate::trace::Sample;
use crate::trace::columns::{self, Column};

/// Writes the names of the columns.
pub fn csv_head(out: &mut dyn Write, columns: &[Column]) -> io::Result<()> {
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    writeln!(out, "{}", names.join(","))
}

/// Whether a line is the header of a table of samples.
pub fn is_samples(head: &str) -> bool {
    columns::are_sample_columns(&head.split(',').collect::<Vec<_>>())
}

/// Writes a sample. The cells of contacts with a missing body are empty.
pub fn csv_sample(out: &mut dyn Write, columns: &[Column], sample: &Sample) -> io::Result<()> {
    line(out, columns.iter().map(|column| column.value(sample)))
}
