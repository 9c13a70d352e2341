//! The result of a check of a run, as JSON document and as text.

use serde::Serialize;

use crate::check::{Check, MAX_CHECKED_STEPS, PERTURBATION};
use crate::format::numbers::format_number;
use crate::format::report::Report;

/// The check of a run. Errors are estimates: differences from the run used for comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunCheckReport {
    /// `sure`, `uncertain` (the outcome depends on the tolerance), `chaotic` (on the last digits of the input) or
    /// `unknown` (not checked).
    pub verdict: &'static str,
    /// Largest error along the path: of angles in rad, of coordinates of a gripper's object in its radii, of discs in
    /// m. Like all errors, it is null if the run was not completed or nothing was compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_rad: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_m: Option<f64>,
    /// Change of the path caused by a relative change of the drive of `perturbation`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensitivity_rad: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensitivity_m: Option<f64>,
    #[serde(rename = "push")]
    pub perturbation: f64,
    /// Path error above which the run is uncertain, in the unit of the errors.
    #[serde(rename = "bar")]
    pub max_path_error: f64,
    /// Quantity to which the largest error is relative.
    #[serde(rename = "bar_of")]
    pub max_path_error_basis: String,
    /// Largest displacement along the path if the largest error is relative to it; null for ordinary motions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion_rad: Option<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion_m: Option<Option<f64>>,
    /// Largest error of an energy or a work, relative to the energy exchanged.
    pub energy_error: f64,
    /// Largest `energy_error` of a run with the verdict "sure".
    #[serde(rename = "energy_bar")]
    pub max_energy_error: f64,
    /// Errors of the restitution of pairs of discs; null if neither run has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution_errors: Option<Vec<Option<f64>>>,
    /// Errors at the end of q11, q21, q22 of every finger, rad, and of x and y of every body, m; empty if either run
    /// was not completed.
    pub final_errors: Vec<f64>,
    /// Errors of the first touch-downs: of the proximal and the distal contact, or of each pair of discs. Null if
    /// either run has none.
    pub first_errors_s: Vec<Option<f64>>,
    /// Errors of normal forces at the end, in the same order.
    pub normal_errors_n: Vec<f64>,
    #[serde(rename = "against")]
    pub reference: String,
    pub reason: Option<String>,
}

impl RunCheckReport {
    /// Builds the report of a scene with fingers or of discs.
    pub fn new(check: &Check, has_fingers: bool) -> Self {
        let angle = |value: f64| has_fingers.then_some(value);
        let length = |value: f64| (!has_fingers).then_some(value);
        RunCheckReport {
            verdict: check.verdict.name(),
            error_rad: angle(check.errors.path),
            error_m: length(check.errors.path),
            sensitivity_rad: angle(check.sensitivity),
            sensitivity_m: length(check.sensitivity),
            perturbation: PERTURBATION,
            max_path_error: check.max_path_error,
            max_path_error_basis: check.max_path_error_basis.clone(),
            motion_rad: has_fingers.then_some(check.largest_displacement),
            motion_m: (!has_fingers).then_some(check.largest_displacement),
            energy_error: check.errors.energy,
            max_energy_error: check.max_energy_error,
            restitution_errors: (!has_fingers).then(|| check.errors.restitution.clone()),
            final_errors: check.errors.last.clone(),
            first_errors_s: check.errors.first_s.clone(),
            normal_errors_n: check.errors.normal_n.clone(),
            reference: check.reference.clone(),
            reason: check.reason.clone(),
        }
    }
}

/// Advice for an uncertain run.
const ADVICE: &str = "increase the accuracy with --preset reference, or a smaller --rtol or --tolerance\n";

/// Returns the line on the check in the summary of a run. For a run without check it is a note if the run has too many
/// steps to be checked by default, otherwise `None`.
pub fn summary_line(report: Option<&RunCheckReport>, steps: Option<u64>) -> Option<Report> {
    match report {
        Some(report) => Some(verdict_line(report)),
        None if steps? > MAX_CHECKED_STEPS => {
            let note = format!(
                "not checked because the run took more than {MAX_CHECKED_STEPS} steps; --check checks it anyway\n"
            );
            Some(Report::from(note))
        }
        None => None,
    }
}

fn verdict_line(report: &RunCheckReport) -> Report {
    let (error, unit) = match (report.error_rad, report.error_m) {
        (Some(error), _) => (error, "rad"),
        (None, error) => (error.unwrap_or_default(), "m"),
    };
    let path_change = report.sensitivity_rad.or(report.sensitivity_m).unwrap_or_default();
    let size = |value: f64| format!("{} {unit}", format_number(value, 2));
    let reference = &report.reference;
    let reason_line = report.reason.as_ref().map_or(String::new(), |reason| format!(";\n{reason}"));
    let reason = report.reason.as_deref().unwrap_or_default();
    match report.verdict {
        "sure" => {
            let motion = report.motion_rad.or(report.motion_m).flatten();
            let motion_fraction =
                motion.map(|motion| format!(", {} of the largest displacement", format_number(error / motion, 2)));
            Report::from(format!(
                "check     accurate to about {}{}, compared with {reference}\n          a relative change of the drive of 1e-7 changes the path by {}\n",
                size(error),
                motion_fraction.unwrap_or_default(),
                size(path_change)
            ))
        }
        "uncertain" if error <= report.max_path_error => Report::from(format!(
            "UNCERTAIN: {reason};\nthe path is accurate to about {}, compared with {reference};\n{ADVICE}",
            size(error)
        )),
        "uncertain" => Report::from(format!(
            "UNCERTAIN: path error of about {}, compared with {reference}; limit {} ({}){reason_line};\n{ADVICE}",
            size(error),
            size(report.max_path_error),
            report.max_path_error_basis
        )),
        "chaotic" => Report::from(format!(
            "CHAOTIC: a relative change of the drive of 1e-7 changes the path by {}{reason_line};\na single outcome means little: \
             evaluate the statistics of many runs (phalanx validate)\n",
            size(path_change)
        )),
        _ => Report::from(format!("NOT CHECKED: {reason}\n")),
    }
}
