//! Measured against bounds.

use super::difference::larger;
use super::{Differences, MOST_ERRORS, Statistics};
use crate::check;
use crate::invariants::Finding;
use crate::scene::Bounds;

/// What the reference may be off by, as a part of what the engine may.
pub const REFERENCE_SHARE: f64 = 0.1;

/// One bound of the scene and what was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Check {
    /// The key of the bound, with its unit.
    pub bound: &'static str,
    /// In words.
    pub meaning: &'static str,
    /// `None` if the scene has nothing to measure there; infinite if one of the models lacks it.
    pub measured: Option<f64>,
    pub limit: f64,
}

impl Check {
    /// Whether the bound holds; what a scene does not have cannot break it.
    pub fn passed(&self) -> bool {
        self.measured.is_none_or(|measured| measured <= self.limit)
    }
}

/// All bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    pub checks: Vec<Check>,
}

impl Verdict {
    /// Whether every bound holds.
    pub fn passed(&self) -> bool {
        self.checks.iter().all(Check::passed)
    }
}

impl Verdict {
    /// With the reference judged too: by another method it may be off by a part of what the engine may. What could not be
    /// checked is no reference.
    pub fn and_reference(mut self, found: &check::Check, bound: f64) -> Self {
        let measured = match found.verdict {
            check::Verdict::Unknown => f64::INFINITY,
            _ => found.errors.path / bound,
        };
        let meaning = "the reference against another method, as a part of what the engine may differ";
        self.checks.push(Check { bound: "reference", meaning, measured: Some(measured), limit: REFERENCE_SHARE });
        self
    }
}

impl Verdict {
    /// With the invariants of a run judged too: the worst of them, as a part of what is allowed.
    pub fn and_invariants(mut self, bound: &'static str, found: &[Finding]) -> Self {
        let worst = found.iter().map(Finding::share).fold(0.0, f64::max);
        let meaning = "worst invariant, as a part of what is allowed";
        self.checks.push(Check { bound, meaning, measured: Some(worst), limit: 1.0 });
        self
    }
}

impl Verdict {
    /// With statistics judged too, where there are any.
    pub fn and_statistics(mut self, found: Option<&Statistics>) -> Self {
        let Some(found) = found else { return self };
        let (bound, measured) = ("statistics", Some(found.worst()));
        let meaning = "worst difference of a mean over many runs, in its standard errors";
        self.checks.push(Check { bound, meaning, measured, limit: MOST_ERRORS });
        self
    }
}

/// Judges the differences of the engine at the scene's own settings.
pub fn verdicts(found: &Differences, bounds: &Bounds) -> Verdict {
    let check = |bound, meaning, measured, limit| Check { bound, meaning, measured, limit };
    let worst = |[proximal, distal]: [Option<f64>; 2]| larger(proximal, distal);
    Verdict {
        checks: vec![
            check("angle_rad", "largest difference of a joint angle", Some(found.angle_rad()), bounds.angle_rad),
            check(
                "contact_time_s",
                "largest difference of a first touch",
                worst(found.contact_time_s),
                bounds.contact_time_s,
            ),
            check(
                "final_force",
                "relative difference of a normal force at the end",
                worst(found.final_force),
                bounds.final_force,
            ),
            check("impulse", "relative difference of the impulse of an impact", worst(found.impulse), bounds.impulse),
            check("loop_gap_m", "largest opening of a joint", Some(found.loop_gap_m), bounds.loop_gap_m),
        ],
    }
}
