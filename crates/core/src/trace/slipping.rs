//! Whether friction that holds slips, through time: what is told of it, and what is only counted.

use super::{ContactSummary, EventKind};

/// Changes between slipping and sticking of one contact that a run tells; the others it counts. A tip that chatters for minutes makes
/// millions of them.
pub const MOST_FRICTION_EVENTS: u32 = 1000;

/// Whether the bristle of one contact slips, as far as that is known.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slipping {
    slips: bool,
    told: u32,
}

impl Slipping {
    /// What a contact does now, if it presses; the event that this is, if any is to be told.
    pub fn change(&mut self, slips: Option<bool>, summary: &mut ContactSummary) -> Option<EventKind> {
        let before = std::mem::replace(&mut self.slips, slips.unwrap_or(false));
        let changed = slips.is_some_and(|slips| slips != before);
        summary.slips = summary.slips.saturating_add(u32::from(changed && self.slips));
        if !changed || self.told == MOST_FRICTION_EVENTS {
            return None;
        }
        self.told += 1;
        Some(if self.slips { EventKind::Slips } else { EventKind::Sticks })
    }
}
