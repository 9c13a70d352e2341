//! Consumers of a run. Samples are streamed: nothing keeps a whole run in memory unless its sink does.

use super::{Event, Sample};

/// Why a sink could not take a sample.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {what}: {source}")]
pub struct SinkError {
    pub what: String,
    #[source]
    pub source: std::io::Error,
}

/// Takes the samples and events of a run in order of time.
pub trait Sink {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError>;
    fn event(&mut self, event: &Event) -> Result<(), SinkError>;
}

/// Takes everything and keeps nothing.
impl Sink for () {
    fn sample(&mut self, _: &Sample) -> Result<(), SinkError> {
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}
