//! Summary of a finished run: extrema found on the dense output, and computational cost; errors of a run.

use serde::Serialize;

use super::{FingerContact, Sample, SinkError};
use crate::integrator::{Failure, Reason};

/// Summary of one contact. For a joint limit, read rad for m and N·m for N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSummary {
    /// Time of the first touch-down, s: the depth δ crosses 0 upward. `None` without contact. It is `Some(0.0)` for a
    /// run that starts with an overlap, with or without a force, or with a zero gap that closes.
    pub first_s: Option<f64>,
    pub touchdowns: u32,
    /// Largest normal force, found with the dense output.
    pub peak_normal_n: f64,
    /// Largest overlap δ, with or without a force; 0 if there was none. [`ContactSummary::depth_m`] excludes overlaps
    /// without contact.
    pub max_penetration_m: f64,
    /// ∫ F_n dt over the run.
    pub impulse_n_s: f64,
    /// Number of slip onsets of bristle friction.
    pub slips: u32,
}

/// Overlap without a touch-down above which surfaces count as having passed through each other, m (limit: rad): 1 nm,
/// the tolerance of event location in the analytic model.
const MIN_UNDETECTED_OVERLAP: f64 = 1e-9;

impl ContactSummary {
    /// Whether the surfaces overlapped although no touch-down was found (tunnelling), because the steps were too long
    /// for a fast body. The overlap is then not the depth of a contact.
    pub fn passed_through(&self) -> bool {
        self.touchdowns == 0 && self.max_penetration_m > MIN_UNDETECTED_OVERLAP
    }

    /// Returns the largest depth δ of the contact, with or without a force; `None` if the surfaces passed through each
    /// other.
    pub fn depth_m(&self) -> Option<f64> {
        (!self.passed_through()).then_some(self.max_penetration_m)
    }

    /// Updates the largest penetration; returns true if it grew.
    pub(super) fn update_max_penetration(&mut self, delta_m: f64) -> bool {
        let is_deeper = delta_m > self.max_penetration_m;
        self.max_penetration_m = self.max_penetration_m.max(delta_m);
        is_deeper
    }

    /// Updates both maxima with the normal force and the penetration of a sample.
    pub fn update(&mut self, (normal_n, delta_m): (f64, f64)) {
        self.update_peak_force(normal_n);
        self.update_max_penetration(delta_m);
    }

    /// Updates the largest normal force; returns true if it grew.
    pub(super) fn update_peak_force(&mut self, normal_n: f64) -> bool {
        let is_larger = normal_n > self.peak_normal_n;
        self.peak_normal_n = self.peak_normal_n.max(normal_n);
        is_larger
    }
}

/// Computational cost of a run. Counters that do not apply to the model stay 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Work {
    /// Accepted steps.
    #[serde(skip)]
    pub steps: u64,
    /// Steps that were repeated because the error was too large, to locate an event, or to approach a fold.
    #[serde(rename = "rejected_steps")]
    pub rejected: u64,
    pub rhs_evaluations: u64,
    pub jacobian_evaluations: u64,
    /// Events: touch-downs, lift-offs and reloads of any contact.
    pub events: u64,
    /// Sub-steps of the engine's contact solver.
    pub contact_substeps: u64,
    /// Newton iterations of the engine's contact solver.
    pub newton_iterations: u64,
}

/// A finished run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    pub last: Sample,
    /// Summaries in the order of the contacts of a sample.
    pub contacts: Vec<ContactSummary>,
    pub work: Work,
    /// Largest opening of a joint, m; 0 without joints, and for the analytic model, which closes loops by construction.
    pub loop_gap_m: f64,
    /// Time at which the object was ejected from the gripper, which ends the run, s; `None` without an ejection.
    pub ejected_s: Option<f64>,
}

impl Outcome {
    /// Returns the outcome of a finger that did not start: all values are zero.
    #[cfg(feature = "engine")]
    pub(super) fn stationary_finger() -> Self {
        let contacts = vec![ContactSummary::default(); FingerContact::ALL.len()];
        Outcome { last: Sample::with_one_finger(), contacts, ..Outcome::default() }
    }

    /// Returns a contact of a single finger. If its scene has no such contact, the result is a contact without a touch.
    ///
    /// # Panics
    /// Panics if the number of fingers is not one.
    pub fn finger_contact(&self, contact: FingerContact) -> ContactSummary {
        self.last.counts().finger_contact(contact).map_or_else(ContactSummary::default, |index| self.contacts[index])
    }
}

/// Reason why a run did not complete.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// The simulation failed; `partial_outcome` summarises the run up to the failure. The sink has received all of it.
    #[error("the simulation could not be completed {failure}")]
    Simulation { failure: Failure, partial_outcome: Box<Outcome> },
}

impl RunError {
    /// Error for a scene rejected before the first step.
    pub(crate) fn rejected(reason: String, outcome: Outcome) -> Self {
        let failure = Failure { time_s: 0.0, reason: Reason::Obstacle(reason) };
        RunError::Simulation { failure, partial_outcome: Box::new(outcome) }
    }

    /// Whether the run was cancelled by its sink, see [`Sink::should_continue`](super::Sink::should_continue).
    pub fn is_stop(&self) -> bool {
        matches!(self, RunError::Simulation { failure: Failure { reason: Reason::Stopped, .. }, .. })
    }
}
