//! Cancels a run between two steps.

use crate::trace::{Event, RequiredData, Sample, Sink, SinkError};

/// Returns whether the run may continue; called once per step.
pub type KeepRunning<'a> = &'a dyn Fn() -> bool;

/// A sink whose run ends as soon as `keep_running` returns false.
pub struct Cancellable<'a, S> {
    pub sink: &'a mut S,
    pub keep_running: KeepRunning<'a>,
}

impl<S: Sink> Sink for Cancellable<'_, S> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sink.sample(sample)
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sink.extreme(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.sink.event(event)
    }

    fn required_data(&self) -> RequiredData {
        self.sink.required_data()
    }

    fn should_continue(&self) -> bool {
        (self.keep_running)()
    }
}
