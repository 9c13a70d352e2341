//! Consumers of a run. Samples are streamed: a run is kept in memory only if its sink stores it.

use super::{Event, Sample};

/// Error reported by a sink that could not process a sample.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {target}: {source}")]
pub struct SinkError {
    /// Name of the output, for messages.
    pub target: String,
    #[source]
    pub source: std::io::Error,
}

/// Data that a sink uses. The analytic model skips unused data, which saves a tenth of the time of a sweep of 384
/// simulations; the last sample of an outcome is always complete. The engine skips only the forces in joints, which are
/// then 0 in its outcomes too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RequiredData {
    /// Whether samples need energies; otherwise they are 0.
    pub energies: bool,
    /// Whether samples need the forces in joints; otherwise they are 0.
    pub joint_forces: bool,
    /// Whether samples need passive joint angles, motor torques and places of cables; otherwise they are 0.
    pub passive: bool,
    /// Whether the outcome and [`Sink::extreme`] samples need the largest forces and penetrations within steps.
    /// Otherwise only the ends of steps are used.
    pub peaks: bool,
    /// Whether samples are needed on the grid, in addition to the ends of all steps.
    pub grid: bool,
    /// Interval of the points, s; 0 for none. At its multiples, except 0, [`Sink::point`] receives samples.
    pub point_interval_s: f64,
}

impl RequiredData {
    pub const NONE: Self =
        Self { energies: false, joint_forces: false, passive: false, peaks: false, grid: false, point_interval_s: 0.0 };
    /// All data except points.
    pub const ALL: Self =
        Self { energies: true, joint_forces: true, passive: true, peaks: true, grid: true, point_interval_s: 0.0 };
    /// All data except points and the forces in joints.
    pub const EVALUATION: Self = Self { joint_forces: false, ..Self::ALL };

    /// Returns the data that at least one of two sinks uses. Only one of them may need points.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            energies: self.energies || other.energies,
            joint_forces: self.joint_forces || other.joint_forces,
            passive: self.passive || other.passive,
            peaks: self.peaks || other.peaks,
            grid: self.grid || other.grid,
            point_interval_s: self.point_interval_s.max(other.point_interval_s),
        }
    }
}

/// Receives the samples and events of a run in order of time.
pub trait Sink {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError>;

    /// Receives an event; ignored by default.
    fn event(&mut self, _event: &Event) -> Result<(), SinkError> {
        Ok(())
    }

    /// Receives a sample within a step at which a force or a penetration exceeds all earlier values.
    ///
    /// A sink that stores these samples has the same extrema as the run; other sinks can ignore them.
    fn extreme(&mut self, _sample: &Sample) -> Result<(), SinkError> {
        Ok(())
    }

    /// Receives a sample at which a normal force crosses the threshold of the criteria. By default, it is treated like
    /// any other sample.
    fn crossing(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sample(sample)
    }

    /// Receives a sample at a multiple of [`RequiredData::point_interval_s`]. Points do not change any other figure of
    /// a run.
    fn point(&mut self, _sample: &Sample) -> Result<(), SinkError> {
        Ok(())
    }

    /// Returns the data that the sink uses, by default all data; called once before a run. A sink that forwards samples
    /// to another sink must also forward this request.
    fn required_data(&self) -> RequiredData {
        RequiredData::ALL
    }

    /// Whether the run may continue. It is called at least once per step of either model, because samples can be far
    /// apart. After `false` the run ends with [`Reason::Stopped`](crate::integrator::Reason::Stopped).
    fn should_continue(&self) -> bool {
        true
    }
}

/// A sink that discards everything, for runs whose outcome alone is used.
impl Sink for () {
    fn required_data(&self) -> RequiredData {
        RequiredData { grid: false, ..RequiredData::EVALUATION }
    }

    fn sample(&mut self, _: &Sample) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Two sinks of one run.
impl<A: Sink, B: Sink> Sink for (A, B) {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.sample(sample)?;
        self.1.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.0.event(event)?;
        self.1.event(event)
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.extreme(sample)?;
        self.1.extreme(sample)
    }

    fn crossing(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.crossing(sample)?;
        self.1.crossing(sample)
    }

    fn point(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.point(sample)?;
        self.1.point(sample)
    }

    fn required_data(&self) -> RequiredData {
        self.0.required_data().or(self.1.required_data())
    }

    fn should_continue(&self) -> bool {
        self.0.should_continue() && self.1.should_continue()
    }
}

/// An optional sink; `None` discards everything.
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

    fn required_data(&self) -> RequiredData {
        self.as_ref().map_or(RequiredData::NONE, Sink::required_data)
    }

    fn should_continue(&self) -> bool {
        self.as_ref().is_none_or(|sink| sink.should_continue())
    }
}

/// Function that returns whether the run may continue; called once per step.
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

    fn crossing(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sink.crossing(sample)
    }

    fn point(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sink.point(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.sink.event(event)
    }

    fn required_data(&self) -> RequiredData {
        self.sink.required_data()
    }

    fn should_continue(&self) -> bool {
        (self.keep_running)() && self.sink.should_continue()
    }
}
