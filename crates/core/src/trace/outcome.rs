//! What remains of a run when it is over: figures found on the dense output, and what it cost.

use serde::Serialize;

use super::{Sample, Site};

/// The history of one contact in a few figures. For the limit of a joint, read rad for m and N·m for N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSummary {
    /// Time of the first touch-down, when the depth δ crosses 0 upward; `None` if contact never happened. A run that starts with an
    /// overlap, with a force or without, or with a gap of 0 that closes, has `Some(0.0)`.
    pub first_s: Option<f64>,
    pub touchdowns: u32,
    /// Largest normal force, searched on the dense output.
    pub peak_normal_n: f64,
    /// Largest overlap δ, with or without a force; 0 if there never was one. [`ContactSummary::depth_m`] says whether it was a contact.
    pub max_penetration_m: f64,
    /// ∫ F_n dt over the run.
    pub impulse_n_s: f64,
    /// How often friction that holds began to slip.
    pub slips: u32,
}

/// An overlap without a touch-down that is deeper than this is no rounding, m (limit: rad): 1 nm, what the analytic model lands on.
const PASSED: f64 = 1e-9;

impl ContactSummary {
    /// Whether the surfaces overlapped although no touch-down was found: steps too long for a fast body let it pass through another
    /// one. There was no contact then, and the overlap is no depth of one.
    pub fn passed_through(&self) -> bool {
        self.touchdowns == 0 && self.max_penetration_m > PASSED
    }

    /// Largest depth δ of the contact, with or without a force; `None` where the surfaces passed through each other unnoticed.
    pub fn depth_m(&self) -> Option<f64> {
        (!self.passed_through()).then_some(self.max_penetration_m)
    }

    /// Takes a penetration; true if it is the largest so far.
    pub(super) fn deepen(&mut self, delta_m: f64) -> bool {
        let deeper = delta_m > self.max_penetration_m;
        self.max_penetration_m = self.max_penetration_m.max(delta_m);
        deeper
    }

    /// Takes force and penetration of a sample.
    pub fn take(&mut self, (normal_n, delta_m): (f64, f64)) {
        self.press(normal_n);
        self.deepen(delta_m);
    }

    /// Takes a normal force; true if it is the largest so far.
    pub(super) fn press(&mut self, normal_n: f64) -> bool {
        let harder = normal_n > self.peak_normal_n;
        self.peak_normal_n = self.peak_normal_n.max(normal_n);
        harder
    }
}

/// What a run cost. Counters of the model that has no such thing stay 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Work {
    /// Accepted steps.
    #[serde(skip)]
    pub steps: u64,
    /// Steps repeated because the error was too large, to land on an event, or to approach a fold.
    #[serde(rename = "rejected_steps")]
    pub rejected: u64,
    pub rhs_evaluations: u64,
    pub jacobian_evaluations: u64,
    /// Events: touch-downs, lift-offs and reloads of any contact.
    pub events: u64,
    /// Sub-steps of the engine's contact solver, and Newton iterations in them.
    pub contact_substeps: u64,
    pub newton_iterations: u64,
}

/// A finished run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    pub last: Sample,
    /// In the order of the contacts of a sample.
    pub contacts: Vec<ContactSummary>,
    pub work: Work,
    /// Largest opening of a joint; 0 for the analytic model, whose loop is closed by construction, and where there is no joint.
    pub loop_gap_m: f64,
    /// When the object of a gripper was thrown out of it, which ends the run; `None` otherwise.
    pub ejected_s: Option<f64>,
}

impl Outcome {
    /// Of a finger that did not begin to move: all figures zero.
    #[cfg(feature = "engine")]
    pub(super) fn of_unmoved_finger() -> Self {
        let contacts = vec![ContactSummary::default(); Site::ALL.len()];
        Outcome { last: Sample::of_finger(), contacts, ..Outcome::default() }
    }

    /// A contact of the first finger.
    ///
    /// # Panics
    /// If there is no finger.
    pub fn site(&self, site: Site) -> &ContactSummary {
        &self.contacts[site as usize]
    }
}
