//! Comparison of measured differences with the bounds of the scene.

use super::{Differences, MAX_STANDARD_ERRORS, Statistics, largest};
use crate::check;
use crate::invariants::Finding;
use crate::scene::Bounds;

/// Largest allowed error of the reference, as a fraction of the largest allowed error of the engine.
pub const MAX_REFERENCE_ERROR_SHARE: f64 = 0.1;

/// Bounds that do not depend on the engine. If one fails, the analytic model is not a valid reference.
pub const REFERENCE_BOUNDS: [&str; 2] = ["reference", "analytic_invariants"];

/// One bound and the measured value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Check {
    /// The key of the bound, with its unit.
    pub bound: &'static str,
    /// Description of the measured quantity.
    pub meaning: &'static str,
    /// Measured value; `None` if the scene does not have the quantity; infinite if only one of the models has it.
    pub measured: Option<f64>,
    pub limit: f64,
}

impl Check {
    /// Whether the bound holds. It always holds for a quantity that the scene does not have.
    pub fn passed(&self) -> bool {
        self.measured.is_none_or(|measured| measured <= self.limit)
    }
}

/// The verdict: all bounds with their measured values.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    pub checks: Vec<Check>,
}

impl Verdict {
    /// Whether every bound holds.
    pub fn passed(&self) -> bool {
        self.checks.iter().all(Check::passed)
    }

    /// Whether any of these bounds fails.
    pub fn fails(&self, bounds: &[&str]) -> bool {
        self.checks.iter().any(|check| bounds.contains(&check.bound) && !check.passed())
    }

    /// Adds the bound of the reference: its difference from another integration method is limited to a fraction of
    /// `bound`, the largest allowed error of the engine. A reference that could not be checked fails.
    pub fn with_reference(mut self, found: &check::Check, bound: f64) -> Self {
        let measured = match found.verdict {
            check::Verdict::Unknown => f64::INFINITY,
            _ => found.errors.path / bound,
        };
        let meaning = "difference of the reference from another method, as a fraction of the bound of the engine";
        self.checks.push(Check {
            bound: "reference",
            meaning,
            measured: Some(measured),
            limit: MAX_REFERENCE_ERROR_SHARE,
        });
        self
    }

    /// Adds the bounds of the criteria of both runs.
    pub fn with_criteria(mut self, checks: Vec<Check>) -> Self {
        self.checks.extend(checks);
        self
    }

    /// Adds the bound of the invariants of a run: the worst of them, as a fraction of its limit.
    pub fn with_invariants(mut self, bound: &'static str, found: &[Finding]) -> Self {
        let worst = found.iter().map(Finding::ratio_to_limit).fold(0.0, f64::max);
        let meaning = "worst invariant, as a fraction of its limit";
        self.checks.push(Check { bound, meaning, measured: Some(worst), limit: 1.0 });
        self
    }

    /// Adds the bound of the statistics, if there are any.
    pub fn with_statistics(mut self, found: Option<&Statistics>) -> Self {
        let Some(found) = found else { return self };
        let (bound, measured) = ("statistics", Some(found.worst()));
        let meaning = "largest difference of a mean over many runs, in standard errors";
        self.checks.push(Check { bound, meaning, measured, limit: MAX_STANDARD_ERRORS });
        self
    }
}

/// Judges the differences of the engine at the settings of the scene: angles and final forces of fingers, positions of
/// bodies, and peak forces in scenes of discs.
pub fn check_bounds(found: &Differences, bounds: &Bounds) -> Verdict {
    let (has_fingers, has_bodies) = (found.has_fingers(), found.has_bodies());
    let [position, impulse] = match has_fingers {
        true => ["largest position difference of the object", "relative difference of the impulse of an impact"],
        false => ["largest position difference of a disc", "relative difference of the impulse of a pair"],
    };
    let contact_time = "largest difference of a first contact";
    let final_force = "relative difference of a normal force at the end";
    let peak_force = "relative difference of a largest normal force";
    let all = [
        (has_fingers, "angle_rad", "largest difference of a joint angle", Some(found.angle_max()), bounds.angle_rad),
        (has_bodies, "position_m", position, Some(found.centre_max()), bounds.position_m),
        (true, "contact_time_s", contact_time, largest(&found.contact_time_s), bounds.contact_time_s),
        (has_fingers, "final_force", final_force, largest(&found.final_force), bounds.final_force),
        (true, "impulse", impulse, largest(&found.impulse), bounds.impulse),
        (!has_fingers, "peak_force", peak_force, largest(&found.peak_force), bounds.peak_force),
        (has_fingers, "loop_gap_m", "largest opening of a joint", Some(found.loop_gap_m), bounds.loop_gap_m),
    ];
    let checks = all.into_iter().filter(|(is_applicable, ..)| *is_applicable);
    let check = |(_, bound, meaning, measured, limit)| Check { bound, meaning, measured, limit };
    Verdict { checks: checks.map(check).collect() }
}
