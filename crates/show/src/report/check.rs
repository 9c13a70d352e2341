//! What a check found of a run, under the keys of the JSON document and in words.

use serde::Serialize;

use crate::check::{Check, MOST_STEPS, PUSH};
use crate::wording::figures::figure;
use crate::wording::report::Report;

/// The check of a run. Errors are estimates: differences to what the run was held to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunCheckReport {
    /// `sure`, `uncertain` (the outcome depends on the tolerance), `chaotic` (on the last digits of the input) or `unknown` (not checked).
    pub verdict: &'static str,
    /// Largest error of an angle along the path, rad; of a gripper's object, of a coordinate, in its radii; of discs, in m. Null, as all
    /// errors, if the run was not completed or nothing was compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_rad: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_m: Option<f64>,
    /// What a change by `push` of what drives the scene does to the path.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensitivity_rad: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensitivity_m: Option<f64>,
    pub push: f64,
    /// The error from which on a run is uncertain, in the unit of the errors.
    pub bar: f64,
    /// What the bar is a part of.
    pub bar_of: String,
    /// Largest displacement along the path, where the bar is a part of that; null for ordinary motions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion_rad: Option<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion_m: Option<Option<f64>>,
    /// Largest error of an energy or a work, and the error from which on a run is uncertain, as parts of the energy exchanged.
    pub energy_error: f64,
    pub energy_bar: f64,
    /// Errors of the restitution of pairs of discs; null where neither run has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution_errors: Option<Vec<Option<f64>>>,
    /// Errors of q11, q21, q22 of every finger at the end, rad, and of x and y of every body, m; empty where either run was not completed.
    pub final_errors: Vec<f64>,
    /// Errors of first touch-downs, proximal and distal or in the order of the pairs; null where either run has none.
    pub first_errors_s: Vec<Option<f64>>,
    /// Errors of normal forces at the end, in the same order.
    pub normal_errors_n: Vec<f64>,
    pub against: String,
    pub reason: Option<String>,
}

impl RunCheckReport {
    /// Of fingers, or of discs.
    pub fn new(check: &Check, finger: bool) -> Self {
        let angle = |value: f64| finger.then_some(value);
        let length = |value: f64| (!finger).then_some(value);
        RunCheckReport {
            verdict: check.verdict.name(),
            error_rad: angle(check.errors.path),
            error_m: length(check.errors.path),
            sensitivity_rad: angle(check.sensitivity),
            sensitivity_m: length(check.sensitivity),
            push: PUSH,
            bar: check.bar,
            bar_of: check.bar_of.clone(),
            motion_rad: finger.then_some(check.motion),
            motion_m: (!finger).then_some(check.motion),
            energy_error: check.errors.energy,
            energy_bar: check.energy_bar,
            restitution_errors: (!finger).then(|| check.errors.restitution.clone()),
            final_errors: check.errors.last.clone(),
            first_errors_s: check.errors.first_s.clone(),
            normal_errors_n: check.errors.normal_n.clone(),
            against: check.against.clone(),
            reason: check.reason.clone(),
        }
    }
}

/// What to do about an uncertain run.
const MORE: &str = "ask for more with --preset reference, or a smaller --rtol or --tolerance\n";

/// A line for the summary of a run of so many steps; nothing for a short run that was not to be checked.
pub fn line(report: Option<&RunCheckReport>, steps: Option<u64>) -> Option<Report> {
    match report {
        Some(report) => Some(found(report)),
        None if steps? > MOST_STEPS => {
            let words =
                format!("not checked, for it took more than {MOST_STEPS} steps; --check does it all the same\n");
            Some(Report::from(words))
        }
        None => None,
    }
}

fn found(report: &RunCheckReport) -> Report {
    let (error, unit) = match (report.error_rad, report.error_m) {
        (Some(error), _) => (error, "rad"),
        (None, error) => (error.unwrap_or_default(), "m"),
    };
    let moved = report.sensitivity_rad.or(report.sensitivity_m).unwrap_or_default();
    let size = |value: f64| format!("{} {unit}", figure(value, 2));
    let against = &report.against;
    let because = report.reason.as_ref().map_or(String::new(), |reason| format!(";\n{reason}"));
    let reason = report.reason.as_deref().unwrap_or_default();
    match report.verdict {
        "sure" => {
            let motion = report.motion_rad.or(report.motion_m).flatten();
            let part = motion.map(|motion| format!(", {} of the largest displacement", figure(error / motion, 2)));
            Report::from(format!(
                "check     right to about {}{}, against {against}\n          a change of 1e-7 of what drives it moves it by {}\n",
                size(error),
                part.unwrap_or_default(),
                size(moved)
            ))
        }
        "uncertain" if error <= report.bar => Report::from(format!(
            "UNCERTAIN: {reason};\nits path is right to about {}, against {against};\n{MORE}",
            size(error)
        )),
        "uncertain" => Report::from(format!(
            "UNCERTAIN: off by about {} along the path, against {against}, where {} are allowed ({}){because};\n{MORE}",
            size(error),
            size(report.bar),
            report.bar_of
        )),
        "chaotic" => Report::from(format!(
            "CHAOTIC: a change of 1e-7 of what drives it moves the path by {}{because};\nthis one outcome means little: look at \
             the statistics of many (phalanx validate)\n",
            size(moved)
        )),
        _ => Report::from(format!("NOT CHECKED: {reason}\n")),
    }
}
