//! Where within one step of the engine a contact is deeper, or presses harder, than ever before.
//!
//! These instants get samples of their own, so that whoever has only the samples finds the same extremes as the summary of
//! the run.

use super::{ContactSample, ContactSummary};
use crate::engine::Moment;

/// Part of a step that counts as its end.
const END: f64 = 1.0 - 1e-9;

/// The instants of one step, by the place of contact they concern.
#[derive(Clone, Debug, Default)]
pub(super) struct Moments {
    /// In order of time once sorted.
    inside: Vec<(usize, Moment)>,
    /// Whether the end of the step is such an instant.
    pub at_end: bool,
}

impl Moments {
    pub fn clear(&mut self) {
        self.inside.clear();
        self.at_end = false;
    }

    /// Takes one place over a step of length `dt_s`: its extremes within, where contact was solved by sub-steps, and force
    /// and penetration at the end.
    pub fn take(
        &mut self,
        place: usize,
        summary: &mut ContactSummary,
        within: Option<[Moment; 2]>,
        dt_s: f64,
        [force, depth]: [f64; 2],
    ) {
        if let Some([peak, deepest]) = within {
            // Geometry stands still in a step: what lies at its end is taken from there.
            let inside = |moment: &Moment| moment.after_s > 0.0 && moment.after_s < END * dt_s;
            if inside(&peak) && summary.press(peak.normal) {
                self.inside.push((place, peak));
            }
            if inside(&deepest) && summary.deepen(-deepest.gap) && deepest.after_s != peak.after_s {
                self.inside.push((place, deepest));
            }
        }
        self.at_end |= summary.press(force) | summary.deepen(depth);
    }

    pub fn sort(&mut self) {
        self.inside.sort_by(|a, b| a.1.after_s.total_cmp(&b.1.after_s));
    }

    /// Takes out the first instant if it comes before `after_s`.
    pub fn before(&mut self, after_s: f64) -> Option<(usize, Moment)> {
        match self.inside.first() {
            Some((_, first)) if first.after_s < after_s => Some(self.inside.remove(0)),
            _ => None,
        }
    }

    /// Takes out the next one if it is at the very instant of one taken before.
    pub fn along(&mut self, after_s: f64) -> Option<(usize, Moment)> {
        match self.inside.first() {
            Some((_, first)) if first.after_s == after_s => Some(self.inside.remove(0)),
            _ => None,
        }
    }
}

impl ContactSample {
    /// As it is at an instant within a step; `impulse_n_s` is that up to the start of the step.
    pub(super) fn at(&mut self, moment: &Moment, impulse_n_s: f64) {
        (self.gap_m, self.gap_rate_m_s, self.slip_m_s) = (moment.gap, moment.gap_rate, moment.slip);
        (self.normal_n, self.tangential_n) = (moment.normal, moment.tangential);
        self.impulse_n_s = impulse_n_s + moment.impulse;
    }
}
