//! Measured against bounds.

use super::{Differences, MOST_ERRORS, Statistics, largest};
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

/// A bound: its key, its meaning, what was measured and the limit.
type Measured = (&'static str, &'static str, (Option<f64>, f64));

/// All bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    pub checks: Vec<Check>,
}

impl Verdict {
    fn new<const N: usize>(bounds: [Measured; N]) -> Self {
        let check = |(bound, meaning, (measured, limit))| Check { bound, meaning, measured, limit };
        Verdict { checks: bounds.map(check).to_vec() }
    }

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

/// Judges the differences of the engine at the settings of a scene of a finger.
pub fn verdicts(found: &Differences, bounds: &Bounds) -> Verdict {
    let worst = |figures: &[Option<f64>], limit| (largest(figures), limit);
    let path = (Some(found.path_max()), bounds.angle_rad);
    Verdict::new([
        ("angle_rad", "largest difference of a joint angle", path),
        ("contact_time_s", "largest difference of a first touch", worst(&found.contact_time_s, bounds.contact_time_s)),
        (
            "final_force",
            "relative difference of a normal force at the end",
            worst(&found.final_force, bounds.final_force),
        ),
        ("impulse", "relative difference of the impulse of an impact", worst(&found.impulse, bounds.impulse)),
        ("loop_gap_m", "largest opening of a joint", (Some(found.loop_gap_m), bounds.loop_gap_m)),
    ])
}

/// The same of a scene of discs.
pub(super) fn verdicts_of_discs(found: &Differences, bounds: &Bounds) -> Verdict {
    let worst = |figures: &[Option<f64>], limit| (largest(figures), limit);
    let path = (Some(found.path_max()), bounds.position_m);
    Verdict::new([
        ("position_m", "largest distance of a disc", path),
        ("contact_time_s", "largest difference of a first touch", worst(&found.contact_time_s, bounds.contact_time_s)),
        ("impulse", "relative difference of the impulse of a pair", worst(&found.impulse, bounds.impulse)),
        ("peak_force", "relative difference of a largest normal force", worst(&found.peak_force, bounds.peak_force)),
    ])
}

/// The same of a gripper.
pub(super) fn verdicts_of_gripper(found: &Differences, bounds: &Bounds) -> Verdict {
    let worst = |figures: &[Option<f64>], limit| (largest(figures), limit);
    Verdict::new([
        ("angle_rad", "largest difference of a joint angle", (Some(found.angle_max()), bounds.angle_rad)),
        ("position_m", "largest distance of the object", (Some(found.centre_max()), bounds.position_m)),
        ("contact_time_s", "largest difference of a first touch", worst(&found.contact_time_s, bounds.contact_time_s)),
        (
            "final_force",
            "relative difference of a normal force at the end",
            worst(&found.final_force, bounds.final_force),
        ),
        ("impulse", "relative difference of the impulse of an impact", worst(&found.impulse, bounds.impulse)),
        ("loop_gap_m", "largest opening of a joint", (Some(found.loop_gap_m), bounds.loop_gap_m)),
    ])
}
