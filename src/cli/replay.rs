//! `phalanx replay`: summarises a log, verifies it by simulating again, compares two logs, and exports samples as a
//! table.

use std::path::{Path, PathBuf};
use std::slice;

use clap::Args;

use super::interrupt::Interrupt;
use super::output::{print_diagnostic, print_result};
use super::replay_read::{LogPlaybackRecorder, SummarySink, Tee, ensure_drawable, read_failure, read_head};
use super::samples::{self, write_table};
use super::targets::{FileKind, NO_DIRECTORY, TargetKind, reserve, save};
use super::{Failure, Status, replay_against, replay_verify};
use crate::format::ToReport;
use crate::log::{LogSink, LogSummary, read_file};
use crate::page::{Page, render_page};
use crate::report::replay::ReplayReport;

/// Summarise the run in a log, verify it by simulating again, compare it with another log, or export its samples.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx replay run.mcap\n  phalanx replay run.mcap --verify\n  phalanx replay run.mcap --csv \
                  run.csv\n  phalanx replay analytic.mcap --against engine.mcap --html both.html\n\nA truncated or damaged log is read \
                  up to the damage (mcap recover extracts what follows). The order of messages in the file does not matter. Exit \
                  status: 0 the log is complete (with --verify: and identical to the new run); 1 data are lost, a topic is missing, \
                  or the runs differ; 2 bad input; 3 interrupted, or a file could not be written."
)]
pub struct ReplayArgs {
    /// Log of a run (MCAP), or the partial log of a killed run
    #[arg(value_name = "LOG.mcap")]
    pub(super) log: PathBuf,

    /// Print one JSON document with SI units in its keys instead of the summary
    #[arg(long)]
    pub(super) json: bool,

    /// Simulate the scene again with all settings in the log and compare all samples and events bit for bit
    #[arg(long, group = "mode")]
    pub(super) verify: bool,

    /// Compare with another log of the same kind of scene: results of both with their differences, and the differences
    /// of the trajectories over the common time
    #[arg(long, value_name = "OTHER.mcap", group = "mode")]
    pub(super) against: Option<PathBuf>,

    /// With --against: write the report and plots to this directory, which is created if needed
    #[arg(long, value_name = "DIR", requires = "against")]
    pub(super) out: Option<PathBuf>,

    /// Write all samples as comma-separated values to this file, one line per sample, with SI units in the column
    /// names; - writes to standard output
    #[arg(long, value_name = "FILE", conflicts_with = "mode")]
    pub(super) csv: Option<PathBuf>,

    /// Write a page for any browser, also offline: an animation, plots and events; with --against both logs are
    /// overlaid. If the run has too many samples for a page, some are omitted and the page states this
    #[arg(long, value_name = "FILE.html", conflicts_with = "verify")]
    pub(super) html: Option<PathBuf>,
}

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

/// Prints lost, missing and inconsistent parts of a log and returns the resulting exit status.
pub(super) fn print_defects(log: &Path, report: &ReplayReport) -> Status {
    let losses = report.reading.losses.iter();
    let mut messages: Vec<String> =
        losses.map(|loss| format!("error: {}: {}", log.display(), loss.description)).collect();
    messages.extend(report.error_messages());
    messages.iter().for_each(|message| print_diagnostic(message));
    if messages.is_empty() { Status::Done } else { Status::CheckFailed }
}
