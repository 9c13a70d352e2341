//! Reading a log with everything that listens to it: the summary of either kind, the criteria, the table of samples.

use std::cell::RefCell;
use std::io::{self, Write};
use std::path::Path;

use super::Failure;
use super::interrupt::Interrupt;
use super::output::complain;
use super::progress::Progress;
use super::simulate::grasp;
use crate::criteria::{AtRest, Criteria, GraspCriteria, GraspTracker, Tracker};
use crate::log::{self, LARGEST_RECORD, LogSink, ReadError, Reading};
use crate::report::{ReplayReport, Summary, csv_head, csv_sample};
use crate::scene::words::SceneKind;
use crate::scene::{self, AnyScene, SceneError};
use crate::trace::columns::{Column, columns};
use crate::trace::{Event, Layout, Sample, Sink, SinkError};

/// Everything that listens to a log.
pub(super) struct Listeners<'a> {
    summary: Summary,
    grasp: Option<AtRest>,
    tracker: Option<Tracker>,
    /// Of a gripper.
    gripper: Option<GraspTracker>,
    /// The scene of a log of bodies, if there is one that this phalanx reads: how they are moved.
    moved: Option<AnyScene>,
    progress: Progress,
    interrupt: &'a Interrupt,
}

impl<'a> Listeners<'a> {
    /// Looks at the head of the log: the criteria need its scene before the first sample.
    pub fn new(path: &Path, interrupt: &'a Interrupt) -> Result<Self, Failure> {
        let head = head(path)?;
        let duration_s = head.metadata.get("duration_s").and_then(|text| text.parse().ok());
        let mut listeners = Listeners {
            summary: Summary::default(),
            grasp: None,
            tracker: None,
            gripper: None,
            moved: None,
            progress: Progress::new(duration_s.unwrap_or(f64::INFINITY)),
            interrupt,
        };
        match attached(&head) {
            Some(Ok(AnyScene::Finger(scene))) => {
                listeners.grasp = grasp(&scene);
                listeners.tracker = listeners.grasp.as_ref().map(|grasp| Tracker::new(grasp.angles()));
            }
            Some(Ok(scene)) => {
                if let AnyScene::Gripper(gripper) = &scene {
                    listeners.gripper = Some(GraspTracker::of(gripper));
                }
                listeners.moved = Some(scene);
            }
            Some(Err(error)) => {
                let missing = match head.kind() {
                    SceneKind::Finger => "no dynamic criteria",
                    SceneKind::Bodies => "what moves the discs is unknown",
                    SceneKind::Gripper => "no criteria of the grasp",
                };
                complain(&format!("{missing}, for the scene in the log cannot be read by this phalanx: {error}"));
            }
            None => {}
        }
        Ok(listeners)
    }

    /// What is known of the run, and what its samples consist of.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Wipes the line that says how far it has come.
    pub fn done(&mut self) {
        self.progress.clear();
    }

    /// The summary of what was read.
    pub fn report(&self, name: String, reading: &Reading) -> ReplayReport {
        ReplayReport::new(
            name,
            reading,
            &self.summary,
            self.criteria(reading),
            self.grasp(reading).as_ref(),
            self.moved.as_ref(),
        )
    }

    /// What became of the object of a gripper.
    fn grasp(&self, reading: &Reading) -> Option<GraspCriteria> {
        self.gripper.as_ref().filter(|_| is_of_whole_run(reading))?.criteria()
    }

    /// Of a run that was completed, and of which nothing is missing.
    fn criteria(&self, reading: &Reading) -> Option<Criteria> {
        let judged = self.tracker.as_ref().zip(self.grasp.as_ref()).filter(|_| is_of_whole_run(reading));
        judged.map(|(tracker, grasp)| tracker.criteria(grasp.is_stable()))
    }

    fn check(&self) -> Result<(), SinkError> {
        go_on(self.interrupt, "a summary of the whole log")
    }
}

/// Whether a run was completed and nothing of its log is missing.
fn is_of_whole_run(reading: &Reading) -> bool {
    let completed = reading.ended.as_ref().is_some_and(|ended| ended.stopped.is_none());
    completed && reading.losses.is_empty() && reading.recovered.is_none()
}

impl LogSink for Listeners<'_> {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.summary = Summary::new(layout.clone());
        // The scene may be of another kind than the log.
        self.tracker = self.tracker.take().filter(|_| layout.fingers.len() == 1);
        self.gripper = self.gripper.take().filter(|_| layout.fingers.len() == 2);
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.check()?;
        Sink::sample(&mut self.progress, sample)?;
        self.summary.sample(sample)?;
        self.gripper.sample(sample)?;
        self.tracker.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.summary.event(event)?;
        self.gripper.event(event)?;
        self.tracker.event(event)
    }
}

/// Writes every sample as a line, and passes everything on.
struct Table<'l, 'a> {
    out: &'l mut dyn Write,
    listeners: &'l mut Listeners<'a>,
    columns: Vec<Column>,
    /// The columns have been named.
    headed: bool,
    gone: bool,
}

impl Table<'_, '_> {
    fn written(&mut self, written: io::Result<()>) -> Result<(), SinkError> {
        written.map_err(|source| {
            self.gone = source.kind() == io::ErrorKind::BrokenPipe;
            SinkError { what: "the table of samples".to_string(), source }
        })
    }
}

impl LogSink for Table<'_, '_> {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.listeners.layout(layout)?;
        self.columns = columns(layout);
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if !std::mem::replace(&mut self.headed, true) {
            let head = csv_head(self.out, &self.columns);
            self.written(head)?;
        }
        let line = csv_sample(self.out, &self.columns, sample);
        self.written(line)?;
        self.listeners.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.listeners.event(event)
    }
}

/// Reads a log.
pub(super) fn read(path: &Path, listeners: &mut Listeners<'_>) -> Result<Reading, Failure> {
    let reading = log::read_any_file(path, listeners).map_err(|error| bad_log(path, &error));
    listeners.progress.clear();
    reading
}

/// Reads a log and writes all its samples; nothing if whoever takes them takes no more.
pub(super) fn tabulate(
    path: &Path,
    listeners: &mut Listeners<'_>,
    out: &mut dyn Write,
) -> Result<Option<Reading>, Failure> {
    let mut table = Table { out, listeners, columns: Vec::new(), headed: false, gone: false };
    let reading = log::read_any_file(path, &mut table);
    let gone = table.gone;
    listeners.progress.clear();
    match reading {
        Err(_) if gone => Ok(None),
        Err(error) => Err(bad_log(path, &error)),
        Ok(reading) => Ok(Some(reading)),
    }
}

/// The scene of a log, if it has one of a size that scenes have.
pub(super) fn attached(head: &Reading) -> Option<Result<AnyScene, SceneError>> {
    let (name, text) = head.scene.as_ref().filter(|(_, text)| text.len() < LARGEST_RECORD)?;
    Some(scene::parse_any(text, name))
}

/// Watches a log being gone through message by message: shows how far that has come, and ends it at a signal.
pub(super) struct Watch<'a> {
    progress: RefCell<Progress>,
    interrupt: &'a Interrupt,
    /// What errors say is not done.
    what: &'a str,
}

impl<'a> Watch<'a> {
    pub fn new(duration_s: Option<f64>, interrupt: &'a Interrupt, what: &'a str) -> Self {
        Watch { progress: RefCell::new(Progress::new(duration_s.unwrap_or(f64::INFINITY))), interrupt, what }
    }

    pub fn reached(&self, log_time_ns: u64) -> Result<(), SinkError> {
        self.progress.borrow_mut().reached(log_time_ns as f64 * 1e-9);
        go_on(self.interrupt, self.what)
    }

    /// Wipes the line.
    pub fn done(&self) {
        self.progress.borrow_mut().clear();
    }
}

/// An error that ends the reading of a log, once a signal has come.
fn go_on(interrupt: &Interrupt, what: &str) -> Result<(), SinkError> {
    match interrupt.signal() {
        None => Ok(()),
        Some(signal) => {
            Err(SinkError { what: what.to_string(), source: io::Error::other(format!("interrupted by {signal}")) })
        }
    }
}

pub(super) fn bad_log(path: &Path, error: &ReadError) -> Failure {
    match error {
        ReadError::Missing { .. } | ReadError::NotAFile { .. } => Failure::bad_input(error),
        ReadError::Sink(error) => Failure::incomplete(error),
        _ => Failure::bad_input(format!("{}: {error}", path.display())),
    }
}

/// The head of a log: its metadata and its scene.
pub(super) fn head(log: &Path) -> Result<Reading, Failure> {
    crate::log::read_head(log).map_err(|error| bad_log(log, &error))
}
