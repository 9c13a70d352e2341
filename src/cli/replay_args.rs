//! What `phalanx replay` is asked, and what all its ways say alike.

use std::path::{Path, PathBuf};

use clap::Args;

use super::Status;
use super::output::complain;
use crate::log::Reading;
use crate::report::replay::ReplayReport;

/// Summarise the run of a log, check it by simulating again, compare it with another, or take its samples out.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx replay run.mcap\n  phalanx replay run.mcap --verify\n  phalanx replay run.mcap --csv \
                  run.csv\n  phalanx replay analytic.mcap --against engine.mcap --html both.html\n  phalanx replay run.mcap.partial --recover run.mcap\n\nA log that is truncated or damaged is read \
                  up to there. The order of messages in the file does not matter. Exit status: 0 the log is whole (with --verify: and the \
                  same again); 1 a part of it is lost, a topic is missing, or it differs; 2 bad input; 3 interrupted, or a file could not \
                  be written."
)]
pub struct ReplayArgs {
    /// Log of a run (MCAP), or what a run that was killed has left of one
    #[arg(value_name = "LOG.mcap")]
    pub(super) log: PathBuf,

    /// Print one JSON document with SI units in its keys instead of the summary
    #[arg(long)]
    pub(super) json: bool,

    /// Simulate again what is in the log, the scene and all settings, and compare message by message: the same build gives
    /// the same bytes
    #[arg(long, group = "mode")]
    pub(super) verify: bool,

    /// Set another log beside it: figures of both with differences, and how far apart they are along the common time. Both
    /// of fingers or both of discs
    #[arg(long, value_name = "OTHER.mcap", group = "mode")]
    pub(super) against: Option<PathBuf>,

    /// With --against: write the report and pictures there; the directory is made if need be
    #[arg(long, value_name = "DIR", requires = "against")]
    pub(super) out: Option<PathBuf>,

    /// Write all samples to a file of comma-separated values, one line each, every column with its SI unit; - is standard
    /// output
    #[arg(long, value_name = "FILE", conflicts_with = "mode")]
    pub(super) csv: Option<PathBuf>,

    /// Write a page that opens in any browser, offline: the bodies in motion, plots, events; with --against both logs laid
    /// over each other. A run of more samples than a page can hold is thinned out, and the page says so
    #[arg(long, value_name = "FILE.html", conflicts_with_all = ["verify", "recover"])]
    pub(super) html: Option<PathBuf>,

    /// Write what can be read of a damaged or truncated log as a whole, indexed one; nothing is made up, and what is
    /// missing is said in it
    #[arg(long, value_name = "FILE.mcap", group = "mode")]
    pub(super) recover: Option<PathBuf>,
}

/// Prints what is lost, and returns what that means for the exit status.
pub(super) fn losses(log: &Path, reading: &Reading) -> Status {
    for loss in &reading.losses {
        complain(&format!("error: {}: {loss}", log.display()));
    }
    if reading.is_whole() { Status::Done } else { Status::CheckFailed }
}

/// Prints what is lost, missing or contradictory, and returns what that means for the exit status.
pub(super) fn defects(log: &Path, reading: &Reading, report: &ReplayReport) -> Status {
    let status = losses(log, reading);
    let lines = report.complaints();
    lines.iter().for_each(|line| complain(line));
    if lines.is_empty() { status } else { Status::CheckFailed }
}
