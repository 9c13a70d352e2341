//! `phalanx replay`: what a log says of its run, without simulating anything.

use std::path::{Path, PathBuf};

use clap::Args;

use super::interrupt::Interrupt;
use super::output::{complain, print};
use super::run::final_angles;
use super::{Failure, Status};
use crate::criteria::Tracker;
use crate::log::{self, LARGEST_RECORD, ReadError, Reading};
use crate::report::{ReplayReport, Summary, replay_json, replay_text};
use crate::scene::{self, AnyScene, Scene};
use crate::trace::{Event, Sample, Sink, SinkError};

/// Summarise the run of a log: how it ended, final state, contacts, dynamic criteria, and what of the log is lost.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx replay run.mcap\n  phalanx replay run.mcap.partial\n  phalanx replay run.mcap --json > \
                  run.json\n\nA log that is truncated or damaged is read up to there. Exit status: 0 the log is whole; 1 a part \
                  of it is lost; 2 bad input."
)]
pub struct ReplayArgs {
    /// Log of a run (MCAP), or what a run that was killed has left of one
    #[arg(value_name = "LOG.mcap")]
    log: PathBuf,

    /// Print one JSON document with SI units in its keys instead of the summary
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &ReplayArgs) -> Result<Status, Failure> {
    let interrupt = Interrupt::listen()?;
    let mut listeners = Listeners { summary: Summary::default(), tracker: None, interrupt: &interrupt };
    // The scene is at the beginning of the log, and the criteria need it before the first sample.
    listeners.tracker = attached(&args.log)?.as_ref().and_then(final_angles).map(Tracker::new);
    let reading = log::read_file(&args.log, &mut listeners).map_err(|error| bad_log(&args.log, &error))?;
    let criteria = match &reading {
        Reading { losses, ended: Some(ended), .. } if losses.is_empty() && ended.stopped.is_none() => {
            listeners.tracker.as_ref().map(|tracker| tracker.criteria(true))
        }
        _ => None,
    };
    let report = ReplayReport::new(args.log.display().to_string(), &reading, &listeners.summary, criteria);
    print(&match args.json {
        true => replay_json(&report),
        false => replay_text(&report),
    })?;
    for loss in &reading.losses {
        complain(&format!("error: {}: {loss}", args.log.display()));
    }
    Ok(if reading.is_whole() { Status::Done } else { Status::CheckFailed })
}

/// The scene of a log, if it has one that this phalanx reads.
fn attached(path: &Path) -> Result<Option<Scene>, Failure> {
    let head = log::read_head(path).map_err(|error| bad_log(path, &error))?;
    let Some((name, text)) = head.scene.filter(|(_, text)| text.len() < LARGEST_RECORD) else {
        return Ok(None);
    };
    match scene::parse_any(&text, &name) {
        Ok(AnyScene::Finger(scene)) => Ok(Some(*scene)),
        Ok(AnyScene::Bodies(_)) => {
            complain("a log of discs: their samples are not summarised yet, only what is said of the run");
            Ok(None)
        }
        Err(error) => {
            complain(&format!("no dynamic criteria, for the scene in the log cannot be read by this phalanx: {error}"));
            Ok(None)
        }
    }
}

fn bad_log(path: &Path, error: &ReadError) -> Failure {
    match error {
        ReadError::Missing { .. } | ReadError::NotAFile { .. } => Failure::bad_input(error),
        ReadError::Sink(error) => Failure::incomplete(error),
        _ => Failure::bad_input(format!("{}: {error}", path.display())),
    }
}

/// Everything that listens to a log.
struct Listeners<'a> {
    summary: Summary,
    tracker: Option<Tracker>,
    interrupt: &'a Interrupt,
}

impl Listeners<'_> {
    fn check(&self) -> Result<(), SinkError> {
        match self.interrupt.signal() {
            None => Ok(()),
            Some(signal) => Err(SinkError {
                what: "a summary of the whole log".to_string(),
                source: std::io::Error::other(format!("interrupted by {signal}")),
            }),
        }
    }
}

impl Sink for Listeners<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.check()?;
        self.summary.sample(sample)?;
        self.tracker.as_mut().map_or(Ok(()), |tracker| tracker.sample(sample))
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.summary.event(event)?;
        self.tracker.as_mut().map_or(Ok(()), |tracker| tracker.event(event))
    }
}
