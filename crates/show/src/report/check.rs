//! The result of a check of a run, as JSON document and as text.

use serde::{Serialize, Serializer};

use super::named::Object;
use crate::check::{Check, MAX_CHECKED_STEPS, PERTURBATION, Verdict};
use crate::format::numbers::format_number;

/// The check of a run. Errors are estimates: the differences from the reference run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunCheckReport {
    pub check: Check,
    /// Whether the scene has fingers, whose errors are angles, or only discs, whose errors are lengths.
    has_fingers: bool,
}

impl RunCheckReport {
    /// Builds the report of a scene with fingers or of discs.
    pub fn new(check: &Check, has_fingers: bool) -> Self {
        RunCheckReport { check: check.clone(), has_fingers }
    }

    /// Unit of the errors of the path.
    fn unit(&self) -> &'static str {
        if self.has_fingers { "rad" } else { "m" }
    }
}

impl Serialize for RunCheckReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Check { errors, .. } = &self.check;
        let [error_key, sensitivity_key, motion_key] = match self.has_fingers {
            true => ["error_rad", "sensitivity_rad", "motion_rad"],
            false => ["error_m", "sensitivity_m", "motion_m"],
        };
        Object::default()
            // `sure`, `uncertain` (the outcome depends on the tolerance), `chaotic` (on the last digits of the input)
            // or `unknown` (not checked).
            .with("verdict", self.check.verdict.name())
            // Largest error along the path: of angles in rad, of coordinates of a gripper's object in its radii, of
            // discs in m. Like all errors, it is null if the run was not completed or nothing was compared.
            .with(error_key, errors.path)
            // Change of the path caused by a relative change of the drive of `push`.
            .with(sensitivity_key, self.check.sensitivity)
            .with("push", PERTURBATION)
            // Path error above which the run is uncertain, and the quantity to which it is relative.
            .with("bar", self.check.max_path_error)
            .with("bar_of", &self.check.max_path_error_basis)
            // Largest displacement along the path if `bar` is relative to it; null for ordinary motions.
            .with(motion_key, self.check.largest_displacement)
            // Largest error of an energy or a work, relative to the energy exchanged, and its limit.
            .with("energy_error", errors.energy)
            .with("energy_bar", self.check.max_energy_error)
            .with_some("restitution_errors", (!self.has_fingers).then_some(&errors.restitution))
            // Of q11, q21, q22 of every finger, rad, and of x and y of every body, m.
            .with("final_errors", &errors.last)
            // Of the first touch-downs of the contacts; null if either run has none.
            .with("first_errors_s", &errors.first_s)
            .with("normal_errors_n", &errors.normal_n)
            .with("against", &self.check.reference)
            .with("reason", &self.check.reason)
            .serialize(serializer)
    }
}

/// Advice for an uncertain run.
const ADVICE: &str = "increase the accuracy with --preset reference, or a smaller --rtol or --tolerance\n";

/// Returns the line about the check in the summary of a run. Without a check, it is a note if the run has too many
/// steps to be checked by default; otherwise `None`.
pub fn summary_line(report: Option<&RunCheckReport>, steps: Option<u64>) -> Option<String> {
    let unchecked =
        || format!("not checked because the run took more than {MAX_CHECKED_STEPS} steps; --check checks it anyway\n");
    report.map(verdict_line).or_else(|| steps.filter(|steps| *steps > MAX_CHECKED_STEPS).map(|_| unchecked()))
}

fn verdict_line(report: &RunCheckReport) -> String {
    let Check { verdict, errors, reference, reason, .. } = &report.check;
    let size = |value: f64| format!("{} {}", format_number(value, 2), report.unit());
    let [error, limit, path_change] = [errors.path, report.check.max_path_error, report.check.sensitivity].map(size);
    let reason_line = reason.as_ref().map_or(String::new(), |reason| format!(";\n{reason}"));
    let reason = reason.as_deref().unwrap_or_default();
    match verdict {
        Verdict::Accurate => {
            let fraction = report.check.largest_displacement.map_or(String::new(), |displacement| {
                format!(", {} of the largest displacement", format_number(errors.path / displacement, 2))
            });
            format!(
                "check     accurate to about {error}{fraction}, compared with {reference}\n          a relative change of the drive of 1e-7 changes the path by {path_change}\n"
            )
        }
        Verdict::Uncertain if errors.path <= report.check.max_path_error => {
            format!("UNCERTAIN: {reason};\nthe path is accurate to about {error}, compared with {reference};\n{ADVICE}")
        }
        Verdict::Uncertain => format!(
            "UNCERTAIN: path error of about {error}, compared with {reference}; limit {limit} ({}){reason_line};\n{ADVICE}",
            report.check.max_path_error_basis
        ),
        Verdict::Chaotic => format!(
            "CHAOTIC: a relative change of the drive of 1e-7 changes the path by {path_change}{reason_line};\na single outcome means little: \
             evaluate the statistics of many runs (phalanx validate)\n"
        ),
        Verdict::Unknown => format!("NOT CHECKED: {reason}\n"),
    }
}
