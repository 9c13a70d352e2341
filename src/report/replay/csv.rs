//! All samples of a log as comma-separated values: one line each, every figure a column with its unit, in SI.

use std::io::{self, Write};

use super::super::csv::line;
use crate::log::Names;
use crate::trace::bodies::BodiesSample;
use crate::trace::{Sample, columns};

/// What the columns are.
#[derive(Clone, Copy, Debug)]
pub enum CsvHead<'a> {
    Finger,
    Discs(&'a Names),
}

impl CsvHead<'_> {
    /// Writes the names of the columns.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let columns = match self {
            CsvHead::Finger => columns::of_finger(),
            CsvHead::Discs(names) => columns::of_discs(&names.discs, &names.pairs),
        };
        writeln!(out, "{}", columns.join(","))
    }
}

/// Whether a line names the columns of a table of samples.
pub fn is_samples(head: &str) -> bool {
    columns::are_of_samples(&head.split(',').collect::<Vec<_>>())
}

/// Writes a sample of a finger. Without an object or a joint limit the cells of theirs are empty.
pub fn csv_finger(out: &mut dyn Write, sample: &Sample) -> io::Result<()> {
    line(out, columns::finger_values(sample))
}

/// Writes a sample of discs.
pub fn csv_discs(out: &mut dyn Write, sample: &BodiesSample) -> io::Result<()> {
    line(out, columns::discs_values(sample))
}
