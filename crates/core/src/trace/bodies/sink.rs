//! Consumers of a run of discs.

use super::{BodiesEvent, BodiesSample};
use crate::trace::SinkError;

/// Takes the samples and events of a run in order of time.
pub trait BodiesSink {
    fn sample(&mut self, sample: &BodiesSample) -> Result<(), SinkError>;
    fn event(&mut self, event: &BodiesEvent) -> Result<(), SinkError>;

    /// A sample within a step, or at the end of a long one, at which a force or a penetration is larger than ever before.
    ///
    /// For those who keep a run: with it the largest values among the samples are those of the run. Everyone else has
    /// a run step by step, and no use for it.
    fn extreme(&mut self, _sample: &BodiesSample) -> Result<(), SinkError> {
        Ok(())
    }

    /// Whether the run may go on, as [`Sink::proceed`](crate::trace::Sink::proceed).
    fn proceed(&self) -> bool {
        true
    }
}

/// Takes everything and keeps nothing.
impl BodiesSink for () {
    fn sample(&mut self, _: &BodiesSample) -> Result<(), SinkError> {
        Ok(())
    }

    fn event(&mut self, _: &BodiesEvent) -> Result<(), SinkError> {
        Ok(())
    }
}

/// One that may not be there.
impl<S: BodiesSink> BodiesSink for Option<S> {
    fn sample(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        self.as_mut().map_or(Ok(()), |sink| sink.sample(sample))
    }

    fn event(&mut self, event: &BodiesEvent) -> Result<(), SinkError> {
        self.as_mut().map_or(Ok(()), |sink| sink.event(event))
    }

    fn extreme(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        self.as_mut().map_or(Ok(()), |sink| sink.extreme(sample))
    }

    fn proceed(&self) -> bool {
        self.as_ref().is_none_or(|sink| sink.proceed())
    }
}
