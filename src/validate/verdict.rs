//! Measured against bounds.

use super::{Differences, MOST_ERRORS, Statistics, largest};
use crate::check;
use crate::invariants::Finding;
use crate::scene::Bounds;

/// What the reference may be off by, as a part of what the engine may.
pub const REFERENCE_SHARE: f64 = 0.1;

/// Bounds that do not depend on the engine: where one fails, the analytic model is no reference.
pub const REFERENCE_BOUNDS: [&str; 2] = ["reference", "analytic_invariants"];

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

    /// Whether any of these bounds fails.
    pub fn fails(&self, bounds: &[&str]) -> bool {
        self.checks.iter().any(|check| bounds.contains(&check.bound) && !check.passed())
    }

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

    /// With the criteria of both runs judged too.
    pub fn and_criteria(mut self, checks: Vec<Check>) -> Self {
        self.checks.extend(checks);
        self
    }

    /// With the invariants of a run judged too: the worst of them, as a part of what is allowed.
    pub fn and_invariants(mut self, bound: &'static str, found: &[Finding]) -> Self {
        let worst = found.iter().map(Finding::share).fold(0.0, f64::max);
        let meaning = "worst invariant, as a part of what is allowed";
        self.checks.push(Check { bound, meaning, measured: Some(worst), limit: 1.0 });
        self
    }

    /// With statistics judged too, where there are any.
    pub fn and_statistics(mut self, found: Option<&Statistics>) -> Self {
        let Some(found) = found else { return self };
        let (bound, measured) = ("statistics", Some(found.worst()));
        let meaning = "worst difference of a mean over many runs, in its standard errors";
        self.checks.push(Check { bound, meaning, measured, limit: MOST_ERRORS });
        self
    }
}

/// Judges the differences of the engine at the settings of the scene: of fingers their angles and what they hold in the end, of bodies
/// their places, of discs alone what they hit each other with.
pub fn verdicts(found: &Differences, bounds: &Bounds) -> Verdict {
    let (fingers, bodies) = (found.has_fingers(), found.has_bodies());
    let [place, impulse] = match fingers {
        true => ["largest distance of the object", "relative difference of the impulse of an impact"],
        false => ["largest distance of a disc", "relative difference of the impulse of a pair"],
    };
    let (touch, last) = ("largest difference of a first touch", "relative difference of a normal force at the end");
    let peak = "relative difference of a largest normal force";
    let all = [
        (fingers, "angle_rad", "largest difference of a joint angle", Some(found.angle_max()), bounds.angle_rad),
        (bodies, "position_m", place, Some(found.centre_max()), bounds.position_m),
        (true, "contact_time_s", touch, largest(&found.contact_time_s), bounds.contact_time_s),
        (fingers, "final_force", last, largest(&found.final_force), bounds.final_force),
        (true, "impulse", impulse, largest(&found.impulse), bounds.impulse),
        (!fingers, "peak_force", peak, largest(&found.peak_force), bounds.peak_force),
        (fingers, "loop_gap_m", "largest opening of a joint", Some(found.loop_gap_m), bounds.loop_gap_m),
    ];
    let checks = all.into_iter().filter(|(there, ..)| *there);
    let check = |(_, bound, meaning, measured, limit)| Check { bound, meaning, measured, limit };
    Verdict { checks: checks.map(check).collect() }
}
