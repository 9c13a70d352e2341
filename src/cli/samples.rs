//! `--csv` of `run` and `replay`: every sample as a line, as the run goes or a log is read.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::Failure;
use super::output::stdout;
use super::saved::broken;
use crate::files::{own_words, replace};
use crate::log::LogSink;
use crate::report::samples::{csv_head, csv_sample};
use crate::trace::columns::{Column, columns};
use crate::trace::{Event, Layout, Sample, Sink, SinkError};

/// The name that stands for standard output.
const STDOUT: &str = "-";

/// The file of `--csv`; none if it goes to standard output, in place of the summary, which two documents cannot share.
pub(super) fn file(path: Option<&Path>, json: bool) -> Result<Option<&Path>, Failure> {
    match path == Some(Path::new(STDOUT)) {
        false => Ok(path),
        true if !json => Ok(None),
        true => Err(Failure::bad_input(
            "--csv - and --json would both write to standard output; give --csv the name of a file, or leave out --json",
        )),
    }
}

/// Writes each sample as a line, and passes everything on.
pub(super) struct Table<'a, S> {
    out: &'a mut dyn Write,
    inner: &'a mut S,
    columns: Vec<Column>,
    /// The columns have been named.
    headed: bool,
    failed: Option<io::ErrorKind>,
}

impl<S> Table<'_, S> {
    fn line(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let head = if self.headed { Ok(()) } else { csv_head(self.out, &self.columns) };
        self.headed = true;
        head.and_then(|()| csv_sample(self.out, &self.columns, sample)).map_err(|source| {
            self.failed = Some(source.kind());
            SinkError { what: "the table of samples".to_string(), source: own_words(source) }
        })
    }
}

impl<S: LogSink> LogSink for Table<'_, S> {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.columns = columns(layout);
        self.inner.layout(layout)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.line(sample)?;
        self.inner.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.inner.event(event)
    }
}

impl<S: Sink> Sink for Table<'_, S> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.line(sample)?;
        self.inner.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.inner.event(event)
    }
}

/// Lets `fill` write the table: to a file that appears whole or not at all, or to standard output. Returns its result, and whether
/// the table was written: false if the reader of standard output takes no more (`| head`).
pub(super) fn tabulated<S, T>(
    path: &Path,
    columns: Vec<Column>,
    inner: &mut S,
    fill: impl FnOnce(&mut Table<'_, S>) -> Result<T, Failure>,
) -> (Result<T, Failure>, Result<bool, Failure>) {
    let mut result = None;
    let write = |out: &mut dyn Write| {
        let mut table = Table { out, inner, columns, headed: false, failed: None };
        let filled = result.insert(fill(&mut table));
        // Half a table is no file; the failure itself says why.
        let whole = filled.as_ref().map_or(Err(io::ErrorKind::Other.into()), |_| Ok(()));
        table.failed.map_or(whole, |kind| Err(kind.into()))
    };
    let to_stdout = path == Path::new(STDOUT);
    let written = match to_stdout {
        true => stdout().and_then(|out| {
            let mut out = BufWriter::new(out);
            write(&mut out).and_then(|()| out.flush())
        }),
        false => replace(path, |out| write(out)),
    };
    let written = match written {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe && to_stdout => Ok(false),
        written => written.map(|()| true).map_err(|error| broken(path, error)),
    };
    let unstarted = || Err(Failure::incomplete(format!("cannot write {}", path.display())));
    (result.unwrap_or_else(unstarted), written)
}
