//! `phalanx replay --html`: the page of a log, or of two overlaid logs.

use std::path::Path;

use super::replay_read::scene_in_log;
use super::{Failure, Status};
use crate::format::Report;
use crate::log::{LogSink, LogSummary, TopicSubject};
use crate::page::{Playback, PlaybackRecorder};
use crate::scene::Scene;
use crate::trace::{Event, Layout, Sample, Sink, SinkError};

/// Records a log for a page in bounded memory; samples of long runs are decimated.
pub(super) struct LogPlaybackRecorder {
    scene: Scene,
    recorder: Box<PlaybackRecorder>,
    /// Whether the layout of the samples matches the scene.
    matches_scene: bool,
}

/// Returns an error if a topic is missing, because a page needs all parts of a sample.
pub(super) fn ensure_drawable(path: &Path, summary: &LogSummary) -> Result<(), Failure> {
    let Some(missing) = summary.missing.iter().find(|missing| missing.subject != TopicSubject::Run) else {
        return Ok(());
    };
    let (topic, defect) = (&missing.topic, &missing.defect);
    let message = format!("error: {}: no page can be written: missing data: {topic} {defect}", path.display());
    Err(Failure { message, status: Status::CheckFailed })
}

impl LogPlaybackRecorder {
    /// Creates a recorder for the scene in the head of a log.
    ///
    /// # Errors
    /// Returns an error if the log has no readable scene of its kind.
    pub fn new(path: &Path, head: &LogSummary) -> Result<Self, Failure> {
        let bad_input =
            |reason: String| Failure::bad_input(format!("{}: there is nothing to draw: {reason}", path.display()));
        match scene_in_log(head) {
            Some(Ok(scene)) if scene.kind() == head.kind() => {
                Ok(LogPlaybackRecorder { scene, recorder: Box::default(), matches_scene: true })
            }
            Some(Ok(_)) => {
                Err(bad_input("the kind of the scene in the log differs from the kind in its metadata".to_string()))
            }
            Some(Err(error)) => {
                Err(bad_input(format!("the scene in the log cannot be read by this version of phalanx:\n{error}")))
            }
            None => Err(bad_input("the part of the log with its scene is lost".to_string())),
        }
    }

    /// Returns the name and description of the scene.
    pub fn name_and_description(&self) -> (String, String) {
        (self.scene.name.clone(), self.scene.description.clone())
    }

    pub fn into_playback(self, path: &Path, label: &str, summary: impl Into<Report>) -> Result<Playback, Failure> {
        match self.matches_scene {
            true => Ok(self.recorder.into_playback(label, &self.scene, summary)),
            false => Err(Failure::bad_input(format!(
                "{}: there is nothing to draw: the samples do not match the scene in the log",
                path.display()
            ))),
        }
    }
}

impl LogSink for LogPlaybackRecorder {
    fn layout(&mut self, layout: &Layout) -> Result<(), SinkError> {
        self.matches_scene = Layout::from_system(&self.scene.system) == *layout;
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if self.matches_scene { self.recorder.sample(sample) } else { Ok(()) }
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        if self.matches_scene { self.recorder.event(event) } else { Ok(()) }
    }
}

/// Passes a log to two sinks.
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
