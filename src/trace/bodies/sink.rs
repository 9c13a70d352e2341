//! Consumers of a run of discs.

use super::{BodiesEvent, BodiesSample};
use crate::trace::SinkError;

/// Takes the samples and events of a run in order of time.
pub trait BodiesSink {
    fn sample(&mut self, sample: &BodiesSample) -> Result<(), SinkError>;
    fn event(&mut self, event: &BodiesEvent) -> Result<(), SinkError>;

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
