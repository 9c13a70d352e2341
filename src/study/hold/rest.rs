//! Since when the object is at rest in the hand.

use super::plan::REST_M_S;
use crate::criteria::{GraspCriteria, GraspTracker};
use crate::numeric::elementary::hypot;
use crate::trace::{Event, Sample, Sink, SinkError};

/// Finds the criteria of a grasp and, by the way, since when its object is slow.
pub(super) struct Rest {
    tracker: GraspTracker,
    since_s: Option<f64>,
}

impl Rest {
    pub(super) fn new(tracker: GraspTracker) -> Self {
        Rest { tracker, since_s: None }
    }

    /// Since when it is slower than [`REST_M_S`] up to the last sample.
    pub(super) fn since_s(&self) -> Option<f64> {
        self.since_s
    }

    pub(super) fn criteria(&self) -> Option<GraspCriteria> {
        self.tracker.criteria()
    }
}

impl Sink for Rest {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let [x, y] = sample.bodies[0].velocity_m_s;
        match hypot(x, y) < REST_M_S {
            true => _ = self.since_s.get_or_insert(sample.time_s),
            false => self.since_s = None,
        }
        self.tracker.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.tracker.event(event)
    }
}
