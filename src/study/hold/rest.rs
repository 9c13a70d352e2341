//! Detection of the time at which the object comes to rest in the hand.

use super::plan::REST_SPEED_M_S;
use crate::criteria::{GraspCriteria, GraspTracker};
use crate::numeric::elementary::hypot;
use crate::trace::{Event, Sample, Sink, SinkError};

/// Evaluates the grasp criteria and the time from which the object is at rest.
pub(super) struct RestDetector {
    tracker: GraspTracker,
    rest_start_s: Option<f64>,
}

impl RestDetector {
    pub(super) fn new(tracker: GraspTracker) -> Self {
        RestDetector { tracker, rest_start_s: None }
    }

    /// Returns the time from which the object stays slower than [`REST_SPEED_M_S`] up to the last sample.
    pub(super) fn rest_start_s(&self) -> Option<f64> {
        self.rest_start_s
    }

    pub(super) fn criteria(&self) -> Option<GraspCriteria> {
        self.tracker.criteria()
    }
}

impl Sink for RestDetector {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let [x, y] = sample.bodies[0].velocity_m_s;
        match hypot(x, y) < REST_SPEED_M_S {
            true => _ = self.rest_start_s.get_or_insert(sample.time_s),
            false => self.rest_start_s = None,
        }
        self.tracker.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.tracker.event(event)
    }
}
