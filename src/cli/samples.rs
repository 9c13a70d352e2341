//! `--csv` of `run` and `replay`: writes every sample as a line during the run or while a log is read.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::Failure;
use super::output::stdout;
use super::targets::write_failure;
use crate::files::{replace_file, without_temporary_path};
use crate::log::LogSink;
use crate::report::samples::{csv_head, csv_sample};
use crate::trace::{Channel, Event, RequiredData, Sample, Schema, Sink, SinkError};

/// Name for standard output.
const STDOUT: &str = "-";

/// Returns the file of `--csv`, or `None` if the table replaces the summary on standard output.
///
/// # Errors
/// Returns an error if the table and `--json` would both go to standard output.
pub(super) fn csv_file(path: Option<&Path>, json: bool) -> Result<Option<&Path>, Failure> {
    match path == Some(Path::new(STDOUT)) {
        false => Ok(path),
        true if !json => Ok(None),
        true => Err(Failure::bad_input(
            "--csv - and --json would both write to standard output; give --csv the name of a file, or leave out --json",
        )),
    }
}

/// Sink that writes each sample as a line and passes all data to `inner`.
pub(super) struct SampleTable<'a, S> {
    out: &'a mut dyn Write,
    inner: &'a mut S,
    channels: Vec<Channel>,
    /// Whether the header was written.
    has_header: bool,
    write_error: Option<io::ErrorKind>,
}

impl<S> SampleTable<'_, S> {
    fn write_line(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let header = if self.has_header { Ok(()) } else { csv_head(self.out, &self.channels) };
        self.has_header = true;
        header.and_then(|()| csv_sample(self.out, &self.channels, sample)).map_err(|source| {
            self.write_error = Some(source.kind());
            SinkError { target: "the table of samples".to_string(), source: without_temporary_path(source) }
        })
    }
}

impl<S: LogSink> LogSink for SampleTable<'_, S> {
    fn schema(&mut self, schema: &Schema) -> Result<(), SinkError> {
        self.channels = schema.channels();
        self.inner.schema(schema)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.write_line(sample)?;
        self.inner.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.inner.event(event)
    }
}

impl<S: Sink> Sink for SampleTable<'_, S> {
    fn required_data(&self) -> RequiredData {
        RequiredData::ALL
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.write_line(sample)?;
        self.inner.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.inner.event(event)
    }
}

/// Calls `fill` to write the table to standard output, or atomically to a file. Returns the result of `fill`, and
/// whether the table was written; `false` if the reader of standard output closed the pipe (`| head`).
pub(super) fn write_table<S, T>(
    path: &Path,
    channels: Vec<Channel>,
    inner: &mut S,
    fill: impl FnOnce(&mut SampleTable<'_, S>) -> Result<T, Failure>,
) -> (Result<T, Failure>, Result<bool, Failure>) {
    let mut result = None;
    let write = |out: &mut dyn Write| {
        let mut table = SampleTable { out, inner, channels, has_header: false, write_error: None };
        let fill_result = result.insert(fill(&mut table));
        // Any error discards an incomplete file; `result` holds the actual error.
        let table_result = fill_result.as_ref().map_or(Err(io::ErrorKind::Other.into()), |_| Ok(()));
        table.write_error.map_or(table_result, |kind| Err(kind.into()))
    };
    let to_stdout = path == Path::new(STDOUT);
    let written = match to_stdout {
        true => stdout().and_then(|out| {
            let mut out = BufWriter::new(out);
            write(&mut out).and_then(|()| out.flush())
        }),
        false => replace_file(path, |out| write(out)),
    };
    let written = match written {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe && to_stdout => Ok(false),
        written => written.map(|()| true).map_err(|error| write_failure(path, error)),
    };
    let not_started = || Err(Failure::incomplete(format!("cannot write {}", path.display())));
    (result.unwrap_or_else(not_started), written)
}
