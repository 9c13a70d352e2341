//! Detection of chattering: events that trigger each other without progress in time.

/// Largest time between consecutive events of one event function that counts as chattering.
const MAX_SPACING_S: f64 = 1e-15;
/// Number of rapid events after which one step uses the clamped law.
const MAX_RAPID_EVENTS: u32 = 6;

/// Counts rapid events per event function.
#[derive(Clone, Copy, Debug)]
pub struct Chatter<const S: usize> {
    recent: [(f64, u32); S],
    is_clamped: bool,
}

impl<const S: usize> Chatter<S> {
    pub fn new() -> Self {
        Self { recent: [(f64::NEG_INFINITY, 0); S], is_clamped: false }
    }

    /// Records an event; returns whether the next step should use the clamped law of this contact.
    pub fn record(&mut self, index: usize, t: f64) -> bool {
        let (last, count) = &mut self.recent[index];
        *count = if t - *last <= MAX_SPACING_S { *count + 1 } else { 0 };
        *last = t;
        let is_chattering = *count >= MAX_RAPID_EVENTS;
        if is_chattering {
            *count = 0;
            self.is_clamped = true;
        }
        is_chattering
    }

    /// Whether the step just taken used a clamped law; resets the flag.
    pub(crate) fn take_clamped(&mut self) -> bool {
        std::mem::take(&mut self.is_clamped)
    }
}
