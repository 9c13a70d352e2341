//! Instants within one engine step at which a penetration or a contact force exceeds all earlier values.
//!
//! These instants get samples of their own, so that the samples alone yield the same extrema as the summary of the run.

use super::{ContactSample, ContactSummary};
use crate::engine::ContactExtremum;

/// Fraction of a step beyond which an instant counts as the end of the step.
const STEP_END: f64 = 1.0 - 1e-9;

/// The extrema of one step, each with the index of its contact.
#[derive(Clone, Debug, Default)]
pub(super) struct StepExtrema {
    /// Extrema inside the step, in order of time after `sort`.
    inside: Vec<(usize, ContactExtremum)>,
    /// Whether there is such an extremum at the end of the step.
    pub at_end: bool,
}

impl StepExtrema {
    pub fn clear(&mut self) {
        self.inside.clear();
        self.at_end = false;
    }

    /// Adds one contact over a step of length `dt_s`: its extrema within the step, if contact was solved by sub-steps,
    /// and force and penetration at the end.
    pub fn add_contact(
        &mut self,
        contact: usize,
        summary: &mut ContactSummary,
        within: Option<[ContactExtremum; 2]>,
        dt_s: f64,
        [force, depth]: [f64; 2],
    ) {
        if let Some([peak, deepest]) = within {
            // The geometry is frozen within a step, so extrema at its end are read from the end sample.
            let inside = |extremum: &ContactExtremum| extremum.after_s > 0.0 && extremum.after_s < STEP_END * dt_s;
            if inside(&peak) && summary.update_peak_force(peak.normal) {
                self.inside.push((contact, peak));
            }
            if inside(&deepest) && summary.update_max_penetration(-deepest.gap) && deepest.after_s != peak.after_s {
                self.inside.push((contact, deepest));
            }
        }
        self.at_end |= summary.update_peak_force(force) | summary.update_max_penetration(depth);
    }

    pub fn sort(&mut self) {
        self.inside.sort_by(|a, b| a.1.after_s.total_cmp(&b.1.after_s));
    }

    /// Removes and returns the first extremum if it lies before `after_s`.
    pub fn next_before(&mut self, after_s: f64) -> Option<(usize, ContactExtremum)> {
        match self.inside.first() {
            Some((_, first)) if first.after_s < after_s => Some(self.inside.remove(0)),
            _ => None,
        }
    }

    /// Removes and returns the next extremum if it lies exactly at `after_s`.
    pub fn next_at(&mut self, after_s: f64) -> Option<(usize, ContactExtremum)> {
        match self.inside.first() {
            Some((_, first)) if first.after_s == after_s => Some(self.inside.remove(0)),
            _ => None,
        }
    }
}

impl ContactSample {
    /// Sets the values at an instant within a step; `impulse_n_s` is the impulse up to the start of the step.
    pub(super) fn set_extremum(&mut self, extremum: &ContactExtremum, impulse_n_s: f64) {
        (self.gap_m, self.gap_rate_m_s, self.slip_m_s) = (extremum.gap, extremum.gap_rate, extremum.slip);
        (self.normal_n, self.tangential_n) = (extremum.normal, extremum.tangential);
        self.impulse_n_s = impulse_n_s + extremum.impulse;
    }
}
