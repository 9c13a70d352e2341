//! Runs that end when they are told to.

use crate::trace::{Event, Sample, Sink, SinkError, Wants};

/// Says whether to go on; asked once a step.
pub type GoOn<'a> = &'a dyn Fn() -> bool;

/// A sink whose run goes on only as long as it may.
pub struct While<'a, S> {
    pub sink: &'a mut S,
    pub go_on: GoOn<'a>,
}

impl<S: Sink> Sink for While<'_, S> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sink.sample(sample)
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sink.extreme(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.sink.event(event)
    }

    fn wants(&self) -> Wants {
        self.sink.wants()
    }

    fn proceed(&self) -> bool {
        (self.go_on)()
    }
}
