//! Status of one contact during a run.

use crate::trace::{ContactSample, EventKind};

/// Whether a contact is closed and active. Events give the times of changes; samples give the force between them.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactStatus {
    is_closed: bool,
    /// Whether the contact has been closed before.
    pub has_touched: bool,
    /// Whether a sample since the touch-down had a positive force.
    was_loaded: bool,
    /// Whether the normal force was zero at the last sample although the contact had been loaded: the normal law clamps
    /// it to 0.
    is_slack: bool,
}

impl ContactStatus {
    pub fn touch_down(&mut self) {
        *self = ContactStatus {
            is_closed: true,
            has_touched: true,
            // A second touch-down does not change a closed contact.
            was_loaded: self.is_closed && self.was_loaded,
            is_slack: self.is_closed && self.is_slack,
        };
    }

    pub fn change(&mut self, kind: EventKind) {
        match kind {
            EventKind::TouchDown | EventKind::Reload => self.touch_down(),
            EventKind::LiftOff => *self = ContactStatus { has_touched: true, ..ContactStatus::default() },
            EventKind::Slips | EventKind::Sticks => {}
        }
    }

    /// Updates the status from the force of a sample.
    pub fn update(&mut self, contact: &ContactSample) {
        if contact.normal_n > 0.0 {
            *self = ContactStatus { is_closed: true, has_touched: true, was_loaded: true, is_slack: false };
        } else {
            self.is_slack = self.is_closed && self.was_loaded;
        }
    }

    /// Returns whether the normal force is positive up to the next sample: the contact is closed, was loaded at the
    /// last sample or has just touched down, and is loaded at the next sample or lifts off before it.
    pub fn is_active_until(&self, next: &ContactSample, lifts_off: bool) -> bool {
        self.is_closed && !self.is_slack && (next.normal_n > 0.0 || lifts_off)
    }
}
