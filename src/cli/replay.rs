//! `phalanx replay`: summarises a log, verifies it by simulating again, compares two logs, and exports samples as a
//! table.

use std::slice;

use super::interrupt::Interrupt;
use super::output::print_result;
use super::replay_read::{
    LogPlaybackRecorder, ReplayArgs, SummarySink, Tee, ensure_drawable, print_defects, read_failure, read_head,
};
use super::samples::{self, write_table};
use super::targets::{FileKind, NO_DIRECTORY, TargetKind, reserve, save};
use super::{Failure, Status, replay_against, replay_verify};
use crate::format::ToReport;
use crate::log::{LogSink, LogSummary, read_file};
use crate::page::{Page, render_page};

/// Runs `phalanx replay`.
pub fn run(args: &ReplayArgs) -> Result<Status, Failure> {
    let interrupt = Interrupt::listen()?;
    match &args.against {
        _ if args.verify => replay_verify::run(args, &interrupt),
        Some(other) => replay_against::run(args, other, &interrupt),
        None => replay_log(args, &interrupt),
    }
}

/// Reads the log once for its summary, its table and its page. The summary is omitted if the table goes to standard
/// output.
fn replay_log(args: &ReplayArgs, interrupt: &Interrupt) -> Result<Status, Failure> {
    let path = &args.log;
    let csv = samples::csv_file(args.csv.as_deref(), args.json)?;
    let recorder = args.html.as_ref().map(|_| LogPlaybackRecorder::new(path, &read_head(path)?)).transpose()?;
    let mut summary_sink = SummarySink::new(path, interrupt)?;
    let html = ("--html", args.html.as_deref(), TargetKind::File(FileKind::Page));
    let csv_target = ("--csv", csv, TargetKind::File(FileKind::Table));
    reserve(&[("the log", slice::from_ref(path))], &[csv_target, html], NO_DIRECTORY)?;
    let (result, recorder) = match recorder {
        Some(mut recorder) => (read_log(args, &mut Tee(&mut summary_sink, &mut recorder)), Some(recorder)),
        None => (read_log(args, &mut summary_sink), None),
    };
    summary_sink.clear_progress();
    let Some(summary) = result? else { return Ok(Status::Done) };
    let mut report = summary_sink.report(path, &summary);
    report.csv = csv.map(|csv| csv.display().to_string());
    if let (Some(target), Some(recorder)) = (&args.html, recorder) {
        ensure_drawable(path, &summary)?;
        let (title, description) = recorder.name_and_description();
        let playback = recorder.into_playback(path, report.model.as_deref().unwrap_or("run"), report.report())?;
        save(target, &render_page(&Page { title, description, runs: vec![playback], ..Page::default() }))?;
        report.page = Some(target.display().to_string());
    }
    if csv.is_some() || args.csv.is_none() {
        print_result(&report, args.json)?;
    }
    Ok(print_defects(path, &report))
}

/// Reads the log and writes its table if requested. Returns `None` if the reader of standard output closed the pipe.
fn read_log<S: LogSink>(args: &ReplayArgs, sink: &mut S) -> Result<Option<LogSummary>, Failure> {
    let to_failure = |error| read_failure(&args.log, &error);
    let Some(csv) = &args.csv else { return read_file(&args.log, sink).map(Some).map_err(to_failure) };
    match write_table(csv, Vec::new(), sink, |table| read_file(&args.log, table).map_err(to_failure)) {
        (_, Ok(false)) => Ok(None),
        (Err(failure), _) | (_, Err(failure)) => Err(failure),
        (Ok(summary), Ok(true)) => Ok(Some(summary)),
    }
}
