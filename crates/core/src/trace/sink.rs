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

/// What a sink looks at. A run of the analytic model leaves out what nobody does: of 384 simulations of a sweep that is a tenth of the
/// time. The last sample of an outcome has everything, and the engine leaves out nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wants {
    /// Energies of samples, 0 otherwise.
    pub energies: bool,
    /// Passive joints of fingers and the torques of their motors, 0 otherwise.
    pub passive: bool,
    /// Largest forces and depths within steps, in the outcome and as [`Sink::extreme`] samples; otherwise those at the ends of steps.
    pub peaks: bool,
}

impl Wants {
    pub const ALL: Self = Self { energies: true, passive: true, peaks: true };
}

/// Takes the samples and events of a run in order of time.
pub trait Sink {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError>;
    fn event(&mut self, event: &Event) -> Result<(), SinkError>;

    /// A sample within a step, or at the end of a long one, at which a force or a penetration is larger than ever before.
    ///
    /// For those who keep a run: with it the largest values among the samples are those of the run. Everyone else has
    /// a run step by step, and no use for it.
    fn extreme(&mut self, _sample: &Sample) -> Result<(), SinkError> {
        Ok(())
    }

    /// What it looks at, asked once before a run.
    fn wants(&self) -> Wants {
        Wants::ALL
    }

    /// Whether the run may go on: asked at least once a step of either model, because samples can be far apart. After a
    /// `false` the run ends as [`Reason::Stopped`](crate::integrator::Reason::Stopped).
    fn proceed(&self) -> bool {
        true
    }
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

/// One that may not be there.
impl<T: Sink> Sink for Option<T> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.as_mut().map_or(Ok(()), |sink| sink.sample(sample))
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.as_mut().map_or(Ok(()), |sink| sink.event(event))
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.as_mut().map_or(Ok(()), |sink| sink.extreme(sample))
    }

    fn wants(&self) -> Wants {
        self.as_ref().map_or(Wants::ALL, Sink::wants)
    }

    fn proceed(&self) -> bool {
        self.as_ref().is_none_or(|sink| sink.proceed())
    }
}
