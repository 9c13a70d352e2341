//! Tracks one contact through time: summary figures and events.

use super::{ContactSummary, Event, EventKind, Exit, Sample};
#[cfg(feature = "engine")]
use crate::engine::ChangeKind;

/// Largest number of slip and stick events reported per contact; later ones are only counted. A tip that chatters for
/// minutes produces millions of them.
pub(crate) const MAX_FRICTION_EVENTS: u32 = 1000;

/// State of one contact through time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ContactTracker {
    pub summary: ContactSummary,
    /// Impulse up to the last touch-down.
    touchdown_impulse: f64,
    /// Slip state of the bristle, and the number of reported slip events.
    is_slipping: bool,
    reported_slip_events: u32,
    #[cfg(feature = "engine")]
    pub engine: EngineContactState,
}

/// State of an engine contact.
#[cfg(feature = "engine")]
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct EngineContactState {
    pub is_touching: bool,
    pub is_loaded: bool,
    /// Whether the force has ended since the last touch-down.
    released: bool,
    /// Impulse up to the start of the current step.
    pub impulse: f64,
}

/// An event to emit: `approach` is nonzero at a touch-down only, `impulse` at a lift-off only.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReportedEvent {
    pub kind: EventKind,
    pub approach: f64,
    pub impulse: f64,
}

impl ReportedEvent {
    /// Returns an event whose approach speed and impulse are 0.
    pub fn of_kind(kind: EventKind) -> Self {
        ReportedEvent { kind, approach: 0.0, impulse: 0.0 }
    }

    pub fn at(self, time_s: f64, contact: usize) -> Event {
        Event { time_s, contact, kind: self.kind, approach_speed: self.approach, impulse: self.impulse }
    }
}

impl ContactTracker {
    /// Records a touch-down; `approach` is the closing speed, and `impulse` the impulse since the start of the run.
    pub fn touch_down(&mut self, time_s: f64, approach: f64, impulse: f64) -> ReportedEvent {
        self.summary.first_s.get_or_insert(time_s);
        self.summary.touchdowns += 1;
        self.touchdown_impulse = impulse;
        ReportedEvent { approach, ..ReportedEvent::of_kind(EventKind::TouchDown) }
    }

    /// Returns the lift-off; `impulse` is the impulse since the start of the run.
    pub fn lift_off(&self, impulse: f64) -> ReportedEvent {
        ReportedEvent { impulse: impulse - self.touchdown_impulse, ..ReportedEvent::of_kind(EventKind::LiftOff) }
    }

    /// Updates the slip state; `None` if the contact is inactive or has no bristle. Returns the event to report, if
    /// any.
    pub(crate) fn update_slip(&mut self, is_slipping: Option<bool>) -> Option<ReportedEvent> {
        let before = std::mem::replace(&mut self.is_slipping, is_slipping.unwrap_or(false));
        let changed = is_slipping.is_some_and(|slips| slips != before);
        self.summary.slips = self.summary.slips.saturating_add(u32::from(changed && self.is_slipping));
        if !changed || self.reported_slip_events == MAX_FRICTION_EVENTS {
            return None;
        }
        self.reported_slip_events += 1;
        Some(ReportedEvent::of_kind(if self.is_slipping { EventKind::Slips } else { EventKind::Sticks }))
    }
}

#[cfg(feature = "engine")]
impl ContactTracker {
    /// Processes a change; `impulse` is the impulse of the current step so far. Returns `None` if the change is not an
    /// event.
    pub(crate) fn process_change(
        &mut self,
        kind: ChangeKind,
        time_s: f64,
        closing: f64,
        impulse: f64,
    ) -> Option<ReportedEvent> {
        let total_impulse = self.engine.impulse + impulse;
        match kind {
            ChangeKind::Closes if !self.engine.is_touching => {
                (self.engine.is_touching, self.engine.released) = (true, false);
                Some(self.touch_down(time_s, closing, total_impulse))
            }
            ChangeKind::Slips => self.update_slip(Some(true)),
            ChangeKind::Sticks => self.update_slip(Some(false)),
            ChangeKind::Unloads if self.engine.is_loaded => {
                (self.engine.is_loaded, self.engine.released) = (false, true);
                self.update_slip(None);
                Some(self.lift_off(total_impulse))
            }
            ChangeKind::Loads if !self.engine.is_loaded => {
                self.engine.is_loaded = true;
                let was_released = std::mem::take(&mut self.engine.released);
                was_released.then(|| ReportedEvent::of_kind(EventKind::Reload))
            }
            ChangeKind::Opens => {
                self.engine.is_touching = false;
                None
            }
            ChangeKind::Closes | ChangeKind::Loads | ChangeKind::Unloads => None,
        }
    }

    /// Adds the impulse of a step.
    pub(crate) fn add_step(&mut self, impulse: f64) {
        self.engine.impulse += impulse;
        self.summary.impulse_n_s = self.engine.impulse;
    }

    /// Returns the change between two steps: a force that appears or disappears at the end of a step.
    pub(crate) fn change_between_steps(&self, force: f64) -> Option<ChangeKind> {
        match (self.engine.is_loaded, force > 0.0) {
            (true, false) => Some(ChangeKind::Unloads),
            (false, true) => Some(ChangeKind::Loads),
            _ => None,
        }
    }
}

/// Updates the maxima of all contacts with a sample: by rounding, it can exceed the extrema found within steps.
pub(super) fn update_summaries(trackers: &mut [ContactTracker], sample: &Sample) {
    for (tracker, contact) in trackers.iter_mut().zip(sample.contacts()) {
        tracker.summary.update(contact.force_and_penetration());
    }
}

/// Whether something has touched the object or a disc: any contact except joint limits.
pub(super) fn has_hand_touched(trackers: &[ContactTracker], sample: &Sample, exit: &Exit) -> bool {
    trackers.iter().enumerate().any(|(index, tracker)| tracker.summary.touchdowns > 0 && exit.counts(index, sample))
}
