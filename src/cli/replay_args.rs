//! Arguments of `phalanx replay`, and the messages that all its modes share.

use std::path::{Path, PathBuf};

use clap::Args;

use super::Status;
use super::output::print_diagnostic;
use crate::log::LogSummary;
use crate::report::replay::ReplayReport;

/// Summarise the run in a log, verify it by simulating again, compare it with another log, or export its samples.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx replay run.mcap\n  phalanx replay run.mcap --verify\n  phalanx replay run.mcap --csv \
                  run.csv\n  phalanx replay analytic.mcap --against engine.mcap --html both.html\n  phalanx replay run.mcap.partial --recover run.mcap\n\nA truncated or damaged log is read \
                  up to the damage. The order of messages in the file does not matter. Exit status: 0 the log is complete (with --verify: \
                  and identical to the new run); 1 data are lost, a topic is missing, or the runs differ; 2 bad input; 3 interrupted, \
                  or a file could not be written."
)]
pub struct ReplayArgs {
    /// Log of a run (MCAP), or the partial log of a killed run
    #[arg(value_name = "LOG.mcap")]
    pub(super) log: PathBuf,

    /// Print one JSON document with SI units in its keys instead of the summary
    #[arg(long)]
    pub(super) json: bool,

    /// Simulate the scene again with all settings in the log and compare message by message; the same build gives the
    /// same bytes
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
    #[arg(long, value_name = "FILE.html", conflicts_with_all = ["verify", "recover"])]
    pub(super) html: Option<PathBuf>,

    /// Write the readable part of a damaged or truncated log as a complete, indexed log; no data are added, and the
    /// new log states what is missing
    #[arg(long, value_name = "FILE.mcap", group = "mode")]
    pub(super) recover: Option<PathBuf>,
}

/// Prints the lost parts of a log and returns the resulting exit status.
pub(super) fn print_losses(log: &Path, summary: &LogSummary) -> Status {
    for loss in &summary.losses {
        print_diagnostic(&format!("error: {}: {loss}", log.display()));
    }
    if summary.is_complete() { Status::Done } else { Status::CheckFailed }
}

/// Prints lost, missing and inconsistent parts of a log and returns the resulting exit status.
pub(super) fn print_defects(log: &Path, summary: &LogSummary, report: &ReplayReport) -> Status {
    let status = print_losses(log, summary);
    let messages = report.error_messages();
    messages.iter().for_each(|message| print_diagnostic(message));
    if messages.is_empty() { status } else { Status::CheckFailed }
}
