//! What is said of a run, by the runs that it is compared with.

use super::RESTITUTION_BAR;
use super::path::{self, Errors, Path};
use crate::integrator::Reason;

/// What is to be said of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Two independent resolutions agree.
    Sure,
    /// They do not, or energy is not accounted for, or a joint opens: the outcome depends on the tolerance.
    Uncertain,
    /// The outcome depends on the last digits of the input.
    Chaotic,
    /// Nothing was compared.
    Unknown,
}

impl Verdict {
    /// In results, logs and reports.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Sure => "sure",
            Verdict::Uncertain => "uncertain",
            Verdict::Chaotic => "chaotic",
            Verdict::Unknown => "unknown",
        }
    }
}

/// A completed run, the finer one, the same with a push, and how they compare.
pub struct Compared<'a> {
    pub run: &'a Path,
    pub second: &'a Path,
    pub pushed: &'a Path,
    pub errors: &'a Errors,
    pub sensitivity: f64,
    /// The effect of a push from which on the run is chaotic.
    pub chaotic: f64,
    /// The error of the path, the error of energies and the opening of a joint (m) from which on the run is uncertain.
    pub bar: f64,
    pub energy_bar: f64,
    pub gap_bar_m: f64,
    /// Whether model and method of both runs are the same, so that only steps can differ.
    pub same_method: bool,
}

/// The verdict, and what decided it where the figures of the path do not say it.
pub fn verdict(of: &Compared<'_>) -> (Verdict, Option<String>) {
    let Compared { run, second, pushed, .. } = of;
    let broken = defects(of);
    let with = |reason: String| Some([vec![reason], broken.clone()].concat().join("; "));
    if let Some(reason) = nothing_compared(of) {
        return if broken.is_empty() { (Verdict::Unknown, Some(reason)) } else { (Verdict::Uncertain, with(reason)) };
    }
    if of.sensitivity > of.chaotic || !path::end_alike(second, pushed) {
        return (Verdict::Chaotic, (!broken.is_empty()).then(|| broken.join("; ")));
    }
    if !path::end_alike(run, second) {
        let ends = match (&second.failure, second.ejected) {
            (Some(reason), _) => reason.to_string(),
            (None, true) => "the object has left the gripper".to_string(),
            (None, false) => "completed".to_string(),
        };
        let reason = format!("the run that checks it ends at {:.6} ms: {ends}", second.end_s * 1e3);
        return (Verdict::Uncertain, with(reason));
    }
    let found = [broken, differences(of)].concat();
    let is_off = of.errors.path > of.bar || !found.is_empty();
    let verdict = if is_off { Verdict::Uncertain } else { Verdict::Sure };
    (verdict, (!found.is_empty()).then(|| found.join("; ")))
}

/// Why nothing was compared, if so.
fn nothing_compared(of: &Compared<'_>) -> Option<String> {
    let Compared { run, second, pushed, .. } = of;
    let early = |reason: &&Reason| matches!(reason, Reason::Budget(_) | Reason::SubstepBudget { .. } | Reason::Stopped);
    let mut failures = [second, pushed].into_iter().filter_map(|path| path.failure.as_ref());
    if let Some(reason) = failures.find(early) {
        return Some(format!("the run that was to check it did not get to its end: {reason}"));
    }
    // The start alone is the same in every run.
    if run.points.len().min(second.points.len()) < 2 && path::end_alike(run, second) {
        return Some(format!("it ended after {:.1e} s, and there is nothing to compare", run.end_s));
    }
    let is_same = of.same_method && run.steps == second.steps && run.points == second.points;
    is_same.then(|| {
        let steps = run.steps;
        format!("the run that was to check it is the same run: {steps} equal steps, to the last digit")
    })
}

/// What makes a run uncertain by itself.
fn defects(of: &Compared<'_>) -> Vec<String> {
    let gap_m = of.run.loop_gap_m;
    let within = gap_m <= of.gap_bar_m;
    let gap = (!within).then(|| format!("a joint opens by {gap_m:.1e} m, where {:.1e} m are allowed", of.gap_bar_m));
    let breach = of.run.audit.and_then(|audit| audit.breach()).map(|breach| breach.to_string());
    gap.into_iter().chain(breach).collect()
}

/// What differs beyond its bar, other than the path.
fn differences(of: &Compared<'_>) -> Vec<String> {
    let Errors { energy, restitution, .. } = of.errors;
    let energy = (*energy > of.energy_bar).then(|| {
        format!(
            "an energy or a work is off by {energy:.1e} of the energy exchanged, where {:e} is allowed",
            of.energy_bar
        )
    });
    let worst = restitution.iter().flatten().copied().fold(0.0, f64::max);
    let restitution = (worst > RESTITUTION_BAR).then(|| match worst.is_finite() {
        true => format!("a restitution is off by {worst:.1e}, where {RESTITUTION_BAR:e} is allowed"),
        false => "a restitution is there in one of the runs only".to_string(),
    });
    energy.into_iter().chain(restitution).collect()
}
