//! Tracks one engine contact through time: converts the changes reported by steps to events and summary figures.

use super::slip_events::SlipEvents;
use super::{ContactSummary, EventKind};
use crate::engine::ChangeKind;

/// State of one engine contact.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ContactTracker {
    pub summary: ContactSummary,
    pub is_touching: bool,
    pub is_loaded: bool,
    /// Whether the force has ended since the last touch-down.
    released: bool,
    /// Impulse up to the start of the current step.
    pub impulse: f64,
    /// Impulse up to the last touch-down.
    touchdown_impulse: f64,
    slip_events: SlipEvents,
}

/// An event to emit: `approach` is nonzero at a touch-down only, `impulse` at a lift-off only.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReportedEvent {
    pub kind: EventKind,
    pub approach: f64,
    pub impulse: f64,
}

impl ContactTracker {
    /// Processes a change; `impulse` is the impulse of the current step so far. Returns `None` if the change is not an
    /// event.
    pub fn process_change(
        &mut self,
        kind: ChangeKind,
        time_s: f64,
        closing: f64,
        impulse: f64,
    ) -> Option<ReportedEvent> {
        let total_impulse = self.impulse + impulse;
        let mut event = ReportedEvent { kind: EventKind::TouchDown, approach: 0.0, impulse: 0.0 };
        match kind {
            ChangeKind::Closes if !self.is_touching => {
                (self.is_touching, self.released, self.touchdown_impulse) = (true, false, total_impulse);
                event.approach = closing;
                self.summary.first_s.get_or_insert(time_s);
                self.summary.touchdowns += 1;
            }
            ChangeKind::Slips => return self.update_slip(Some(true)),
            ChangeKind::Sticks => return self.update_slip(Some(false)),
            ChangeKind::Unloads if self.is_loaded => {
                (self.is_loaded, self.released) = (false, true);
                self.update_slip(None);
                (event.kind, event.impulse) = (EventKind::LiftOff, total_impulse - self.touchdown_impulse);
            }
            ChangeKind::Loads if !self.is_loaded => {
                self.is_loaded = true;
                if !self.released {
                    return None;
                }
                self.released = false;
                event.kind = EventKind::Reload;
            }
            ChangeKind::Opens => {
                self.is_touching = false;
                return None;
            }
            _ => return None,
        }
        Some(event)
    }

    /// Updates the slip state; `None` if the contact is inactive or has no bristle.
    pub fn update_slip(&mut self, is_slipping: Option<bool>) -> Option<ReportedEvent> {
        let kind = self.slip_events.update(is_slipping, &mut self.summary)?;
        Some(ReportedEvent { kind, approach: 0.0, impulse: 0.0 })
    }

    /// Adds the impulse of a step.
    pub fn add_step(&mut self, impulse: f64) {
        self.impulse += impulse;
        self.summary.impulse_n_s = self.impulse;
    }

    /// Returns the change between two steps: a force that appears or disappears at the end of a step.
    pub fn change_between_steps(&self, force: f64) -> Option<ChangeKind> {
        match (self.is_loaded, force > 0.0) {
            (true, false) => Some(ChangeKind::Unloads),
            (false, true) => Some(ChangeKind::Loads),
            _ => None,
        }
    }
}
