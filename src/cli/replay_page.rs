//! `phalanx replay --html`: the page of a log, or of two laid over each other.

use std::path::Path;

use super::replay_read::attached;
use super::{Failure, Status};
use crate::log::{Concerns, LogSink, Reading};
use crate::page::{Film, Reel};
use crate::scene::Scene;
use crate::trace::{Event, Layout, Sample, Sink, SinkError};
use crate::wording::Report;

/// A run kept for a page, in bounded memory: one of many samples is thinned out.
pub(super) struct Reels {
    scene: Scene,
    reel: Box<Reel>,
    /// Whether the samples are of what the scene has.
    fits: bool,
}

/// A page shows every part of a sample: without one of them there is none.
pub(super) fn undrawable(path: &Path, reading: &Reading) -> Result<(), Failure> {
    let Some(missing) = reading.missing.iter().find(|missing| missing.concerns != Concerns::Run) else { return Ok(()) };
    let (topic, what) = (&missing.topic, &missing.what);
    let message = format!("error: {}: no page can be made: missing topic: {topic} {what}", path.display());
    Err(Failure { message, status: Status::CheckFailed })
}

impl Reels {
    /// For the scene of a log, without which nothing can be drawn.
    pub fn new(path: &Path, head: &Reading) -> Result<Self, Failure> {
        let refused = |why: String| Failure::bad_input(format!("{}: there is nothing to draw: {why}", path.display()));
        match attached(head) {
            Some(Ok(scene)) if scene.kind() == head.kind() => Ok(Reels { scene, reel: Box::default(), fits: true }),
            Some(Ok(_)) => Err(refused("the scene in the log is of another kind than its metadata say".to_string())),
            Some(Err(error)) => Err(refused(format!("the scene in the log cannot be read by this phalanx:\n{error}"))),
            None => Err(refused("the part of the log that held its scene is lost".to_string())),
        }
    }

    /// Name and description of the scene.
    pub fn about(&self) -> (String, String) {
        (self.scene.name.clone(), self.scene.description.clone())
    }

    pub fn film(self, path: &Path, label: &str, summary: impl Into<Report>) -> Result<Film, Failure> {
        match self.fits {
            true => Ok(self.reel.film(label, &self.scene, summary)),
            false => Err(Failure::bad_input(format!(
                "{}: there is nothing to draw: the samples are not of what the scene in the log has",
                path.display()
            ))),
        }
    }
}

impl LogSink for Reels {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.fits = Layout::of(&self.scene.system) == *layout;
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if self.fits { self.reel.sample(sample) } else { Ok(()) }
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        if self.fits { self.reel.event(event) } else { Ok(()) }
    }
}

/// Two sinks that take the same log.
pub(super) struct Tee<'a, A, B>(pub &'a mut A, pub &'a mut B);

impl<A: LogSink, B: LogSink> LogSink for Tee<'_, A, B> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.sample(sample)?;
        self.1.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.0.event(event)?;
        self.1.event(event)
    }

    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.0.layout(layout)?;
        self.1.layout(layout)
    }
}
