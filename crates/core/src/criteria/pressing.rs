//! What is known of one contact while a run streams by.

use crate::trace::{ContactSample, EventKind};

/// Whether a contact is closed, and presses. Its events say when that changes, and samples whether there is a force between them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pressing {
    closed: bool,
    /// Has ever been closed.
    pub touched: bool,
    /// A positive force has been seen since the touch-down.
    pressed: bool,
    /// Normal force at the last sample was zero although the contact had been pressed: the clamp of the normal law.
    slack: bool,
}

impl Pressing {
    pub fn touch_down(&mut self) {
        *self = Pressing {
            closed: true,
            touched: true,
            // A contact that is known to be closed already stays what it is.
            pressed: self.closed && self.pressed,
            slack: self.closed && self.slack,
        };
    }

    pub fn change(&mut self, kind: EventKind) {
        match kind {
            EventKind::TouchDown | EventKind::Reload => self.touch_down(),
            EventKind::LiftOff => *self = Pressing { touched: true, ..Pressing::default() },
            EventKind::Slips | EventKind::Sticks => {}
        }
    }

    /// Takes the force of a sample.
    pub fn take(&mut self, contact: &ContactSample) {
        if contact.normal_n > 0.0 {
            *self = Pressing { closed: true, touched: true, pressed: true, slack: false };
        } else {
            self.slack = self.closed && self.pressed;
        }
    }

    /// Whether the normal force is positive on the way to a sample: closed, pressed at the last sample (or just touched down), and
    /// pressed at the next one (or about to lift off before it).
    pub fn presses_until(&self, next: &ContactSample, lifts_off: bool) -> bool {
        self.closed && !self.slack && (next.normal_n > 0.0 || lifts_off)
    }
}
