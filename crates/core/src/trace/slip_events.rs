//! Slip state of bristle friction through time: reports slip events up to a limit and counts all of them.

use super::{ContactSummary, EventKind};

/// Largest number of slip and stick events reported per contact; later ones are only counted. A tip that chatters for
/// minutes produces millions of them.
pub const MAX_FRICTION_EVENTS: u32 = 1000;

/// Slip state of the bristle of one contact.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SlipEvents {
    is_slipping: bool,
    reported: u32,
}

impl SlipEvents {
    /// Updates the slip state (`None` if the contact is inactive); returns the event to report, if any.
    pub fn update(&mut self, is_slipping: Option<bool>, summary: &mut ContactSummary) -> Option<EventKind> {
        let before = std::mem::replace(&mut self.is_slipping, is_slipping.unwrap_or(false));
        let changed = is_slipping.is_some_and(|slips| slips != before);
        summary.slips = summary.slips.saturating_add(u32::from(changed && self.is_slipping));
        if !changed || self.reported == MAX_FRICTION_EVENTS {
            return None;
        }
        self.reported += 1;
        Some(if self.is_slipping { EventKind::Slips } else { EventKind::Sticks })
    }
}
