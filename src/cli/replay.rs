//! `phalanx replay`: what a log says of its run; whether simulating again gives the same; two logs side by side; samples as
//! a table; the good part of a damaged log.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use super::interrupt::Interrupt;
use super::output::{complain, print, show};
use super::own::{Form, writable};
use super::replay_read::{Listeners, bad_log, read, tabulate};
use super::{Failure, Status, replay_against, replay_page, replay_recover, replay_verify};
use crate::files::replace;
use crate::log::Reading;
use crate::report::{ReplayReport, replay_json, replay_text};

/// Summarise the run of a log, check it by simulating again, compare it with another, or take its samples out.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx replay run.mcap\n  phalanx replay run.mcap --verify\n  phalanx replay run.mcap --csv \
                  run.csv\n  phalanx replay analytic.mcap --against engine.mcap --html both.html\n  phalanx replay run.mcap.partial --recover run.mcap\n\nA log that is truncated or damaged is read \
                  up to there. Exit status: 0 the log is whole (with --verify: and the same again); 1 a part of it is lost, or \
                  it differs; 2 bad input; 3 interrupted, or a file could not be written."
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
    verify: bool,

    /// Set another log beside it: figures of both with differences, and how far apart they are along the common time. Both
    /// of fingers or both of discs
    #[arg(long, value_name = "OTHER.mcap", group = "mode")]
    against: Option<PathBuf>,

    /// With --against: write the report and pictures there; the directory is made if need be
    #[arg(long, value_name = "DIR", requires = "against")]
    pub(super) out: Option<PathBuf>,

    /// Write all samples to a file of comma-separated values, one line each, every column with its SI unit; - is standard
    /// output
    #[arg(long, value_name = "FILE", group = "mode")]
    csv: Option<PathBuf>,

    /// Write a page that opens in any browser, offline: the bodies in motion, plots, events; with --against both logs laid
    /// over each other. A run of more samples than a page can hold is thinned out, and the page says so
    #[arg(long, value_name = "FILE.html", conflicts_with_all = ["verify", "csv", "recover"])]
    pub(super) html: Option<PathBuf>,

    /// Write what can be read of a damaged or truncated log as a whole, indexed one; nothing is made up, and what is
    /// missing is said in it
    #[arg(long, value_name = "FILE.mcap", group = "mode")]
    recover: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &ReplayArgs) -> Result<Status, Failure> {
    let interrupt = Interrupt::listen()?;
    if args.verify {
        return replay_verify::run(args, &interrupt);
    }
    if let Some(target) = &args.recover {
        return replay_recover::run(args, target, &interrupt);
    }
    if let Some(other) = &args.against {
        return replay_against::run(args, other, &interrupt);
    }
    match (&args.csv, &args.html) {
        (Some(path), _) => csv(args, path, &interrupt),
        (None, Some(path)) => replay_page::run(args, path, &interrupt),
        (None, None) => {
            let mut listeners = Listeners::new(&args.log, &interrupt)?;
            let reading = read(&args.log, &mut listeners)?;
            summarise(args, &reading, &listeners)
        }
    }
}

/// Prints the summary, and says on stderr what of the log is lost.
fn summarise(args: &ReplayArgs, reading: &Reading, listeners: &Listeners<'_>) -> Result<Status, Failure> {
    let report = listeners.report(args.log.display().to_string(), reading);
    say(args, &report)?;
    Ok(losses(&args.log, reading))
}

pub(super) fn say(args: &ReplayArgs, report: &ReplayReport) -> Result<(), Failure> {
    match args.json {
        true => print(&replay_json(report)),
        false => show(&replay_text(report)),
    }
}

/// Says what is lost, and what that means for the exit status.
pub(super) fn losses(log: &Path, reading: &Reading) -> Status {
    for loss in &reading.losses {
        complain(&format!("error: {}: {loss}", log.display()));
    }
    if reading.is_whole() { Status::Done } else { Status::CheckFailed }
}

/// Writes the samples, and the summary unless they go to where it would.
fn csv(args: &ReplayArgs, path: &Path, interrupt: &Interrupt) -> Result<Status, Failure> {
    let mut listeners = Listeners::new(&args.log, interrupt)?;
    if path == Path::new("-") {
        if args.json {
            return Err(Failure::bad_input(
                "--csv - and --json would both write to standard output; give --csv the name of a file, or leave out --json",
            ));
        }
        let mut out = BufWriter::new(io::stdout().lock());
        let Some(reading) = tabulate(&args.log, &mut listeners, &mut out)? else { return Ok(Status::Done) };
        return match out.flush() {
            // Whoever reads has seen enough (`| head`).
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                Err(Failure::incomplete(format!("cannot write to standard output: {error}")))
            }
            _ => Ok(losses(&args.log, &reading)),
        };
    }
    refuse_the_log(&args.log, path, "--csv")?;
    writable(path, Form::Samples)?;
    let mut outcome = Err(Failure::incomplete(format!("cannot write {}", path.display())));
    let written = replace(path, |out| {
        outcome = tabulate(&args.log, &mut listeners, out);
        // Half of what was asked for is no file; the failure itself says why.
        outcome.as_ref().map_or(Err(io::ErrorKind::Other.into()), |_| Ok(()))
    });
    match (outcome?, written) {
        (Some(reading), Ok(())) => summarise(args, &reading, &listeners),
        (_, Err(error)) => Err(Failure::incomplete(format!("cannot write {}: {error}", path.display()))),
        (None, Ok(())) => Ok(Status::Done),
    }
}

/// A slip of the hand must not cost the log.
pub(super) fn refuse_the_log(log: &Path, target: &Path, flag: &str) -> Result<(), Failure> {
    match (log.canonicalize(), target.canonicalize()) {
        (Ok(source), Ok(place)) if source == place => Err(Failure::bad_input(format!(
            "{flag} {} is the log itself, which must stay as it is; give another file",
            target.display()
        ))),
        _ => Ok(()),
    }
}

/// The head of a log: its metadata and its scene.
pub(super) fn head(log: &Path) -> Result<Reading, Failure> {
    crate::log::read_head(log).map_err(|error| bad_log(log, &error))
}
