//! Checks of the simulations, and near-chaotic simulations: their class depends on tolerances and on small changes of
//! the torque.
//!
//! A rebound amplifies small differences. After a few rebounds, two nearly equal runs can come to rest at different
//! times, or one of them not at all. The class is then not a property of the design alone. The variations use the runs
//! of the checks: another method at a finer tolerance, without and with a perturbed torque.

use serde::Serialize;

use super::{Run, Simulations, is_stable, step_error};
use crate::check::{Check, PERTURBATION, Verdict, check_with_sinks, perturbed};
use crate::criteria::{Class, StaticGrasp, Tracker, scene_static_grasp};
use crate::scene::Scene;
use crate::trace::{self, Model, RunError, Sink};
use phalanx_parallel::{self, ComputeError, Monitor};

/// Relative perturbation of the torque in the last variation.
const STUDY_PERTURBATION: f64 = 1e-9;

/// Largest difference of two times to stability that count as equal; an impact lasts about a microsecond.
pub(super) const MAX_TTS_DIFFERENCE_S: f64 = 1e-5;

/// Variations that should give the same result as the run of the study: the reference run of the check, with another
/// method at a hundredth of the tolerance; that run with a torque increased by [`PERTURBATION`]; the run of the study
/// with a torque increased by a billionth.
pub(super) const VARIATIONS: [&str; 3] = ["another method, finer", "the same, torque + 1e-7", "torque + 1e-9"];

const _: () = assert!(PERTURBATION == 1e-7, "the value in the name of the variation");

/// Numbers of checked runs, by verdict.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Checks {
    /// Number of completed runs; all of them are checked.
    pub runs: usize,
    /// Runs whose outcome depends on the tolerance.
    pub uncertain_runs: Vec<i64>,
    /// Runs whose outcome depends on the last digits of the input.
    pub chaotic_runs: Vec<i64>,
    /// Runs that could not be checked.
    pub unknown_runs: Vec<i64>,
    /// Largest angle error of all other runs, rad.
    pub worst_error_rad: f64,
}

impl Checks {
    /// Adds the check of a run.
    pub fn add(&mut self, run: i64, check: &Check) {
        self.runs += 1;
        match check.verdict {
            Verdict::Uncertain => self.uncertain_runs.push(run),
            Verdict::Chaotic => self.chaotic_runs.push(run),
            Verdict::Unknown => self.unknown_runs.push(run),
            Verdict::Accurate => self.worst_error_rad = self.worst_error_rad.max(check.errors.path),
        }
    }
}

/// Effect of the variations on the classes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Chaos {
    pub variations: [&'static str; VARIATIONS.len()],
    /// For each condition, the number of dynamically stable (stable or semi-stable) runs.
    pub conditions: Vec<StableRuns>,
    /// Runs that do not have the same class in all variations.
    #[serde(rename = "runs")]
    pub class_changes: Vec<ClassChange>,
    /// Runs whose time to stability changes by more than `drift_s`, or exists in only some of the variations.
    pub drifting_runs: Vec<i64>,
    /// Value of `MAX_TTS_DIFFERENCE_S`, s.
    pub drift_s: f64,
}

/// Number of dynamically stable runs of one condition.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct StableRuns {
    pub study: usize,
    pub by_variation: [usize; VARIATIONS.len()],
    /// Number of runs that are stable in the study and in every variation.
    pub in_all: usize,
    /// Number of runs that are stable in the study or in any variation.
    pub in_any: usize,
}

/// A run whose class differs between variations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClassChange {
    pub run: i64,
    pub design: i64,
    #[serde(skip)]
    pub condition: usize,
    pub class: Class,
    #[serde(rename = "by_variation")]
    pub classes: [Class; VARIATIONS.len()],
}

/// Checks every completed run of the study, and repeats every statically stable run in each variation. Other runs are
/// unstable in every variation. Returns index and check of each checked run.
pub fn chaos(
    simulations: &Simulations,
    threads: usize,
    monitor: &Monitor,
) -> Result<(Vec<(usize, Check)>, Chaos), ComputeError> {
    let runs = &simulations.runs;
    let jobs: Vec<usize> = (0..runs.len()).filter(|&run| runs[run].is_completed).collect();
    let repeated = phalanx_parallel::map(threads, &jobs, |&run| repeat_run(&runs[run], monitor))?;
    let mut checks = Vec::new();
    let mut drifting_runs = Vec::new();
    // Classes in the study and in the variations.
    let mut classes: Vec<[Class; 4]> = runs.iter().map(|run| [run.class.unwrap_or(Class::Unstable); 4]).collect();
    for (index, (check, ends)) in jobs.into_iter().zip(repeated) {
        checks.push((index, check));
        let Some(ends) = ends else { continue };
        classes[index][1..].copy_from_slice(&ends.map(|(class, _)| class));
        let drifts = |&(_, tts_s): &RunEnd| match (runs[index].tts_s, tts_s) {
            (Some(study_s), Some(other_s)) => (study_s - other_s).abs() > MAX_TTS_DIFFERENCE_S,
            (study_s, other_s) => study_s.is_some() != other_s.is_some(),
        };
        drifting_runs.extend(ends.iter().any(drifts).then_some(runs[index].run));
    }
    drifting_runs.sort_unstable();
    let stable_runs = |condition: usize| {
        let of_condition = runs.iter().zip(&classes).filter(|(run, _)| run.condition == condition);
        let stable: Vec<[bool; 4]> = of_condition.map(|(_, all)| all.map(|class| is_stable(Some(class)))).collect();
        let [study, by_variation @ ..] = [0, 1, 2, 3].map(|k| stable.iter().filter(|all| all[k]).count());
        let in_all = stable.iter().filter(|all| **all == [true; 4]).count();
        let in_any = stable.iter().filter(|all| all.contains(&true)).count();
        StableRuns { study, by_variation, in_all, in_any }
    };
    let class_change = |(run, &[class, classes @ ..]): (&Run, &[Class; 4])| ClassChange {
        run: run.run,
        design: run.design,
        condition: run.condition,
        class,
        classes,
    };
    let changed = runs.iter().zip(&classes).filter(|(_, classes)| classes.iter().any(|class| *class != classes[0]));
    let chaos = Chaos {
        variations: VARIATIONS,
        conditions: (0..simulations.conditions.len()).map(stable_runs).collect(),
        class_changes: changed.map(class_change).collect(),
        drifting_runs,
        drift_s: MAX_TTS_DIFFERENCE_S,
    };
    Ok((checks, chaos))
}

/// Class and time to stability of a run.
type RunEnd = (Class, Option<f64>);

/// Checks a run and, if it is statically stable, evaluates its variations.
fn repeat_run(run: &Run, monitor: &Monitor) -> Result<(Check, Option<[RunEnd; VARIATIONS.len()]>), ComputeError> {
    let scene = &run.scene;
    let rest = scene_static_grasp(scene).map_err(step_error("a variation"))?;
    let mut trackers = [Tracker::new(rest.final_angles()), Tracker::new(rest.final_angles())];
    let with_variations = run.is_statically_stable();
    let [reference, perturbed] = &mut trackers;
    let sinks: [&mut dyn Sink; 2] = if with_variations { [reference, perturbed] } else { [&mut (), &mut ()] };
    let check = check_with_sinks(Model::Analytic, scene, sinks, monitor.keep_running());
    let [reference, perturbed] = trackers.map(|tracker| run_end(&tracker, &rest));
    let ends = match with_variations {
        true => Some([reference, perturbed, run_perturbed(scene, &rest)?]),
        false => None,
    };
    // An interrupted check is not valid.
    monitor.check()?;
    Ok((check, ends))
}

fn run_end(tracker: &Tracker, rest: &StaticGrasp) -> RunEnd {
    let criteria = tracker.criteria(rest.static_forces_n());
    criteria.map_or((Class::Unstable, None), |criteria| (criteria.class, criteria.tts_s))
}

/// Runs the scene of the study with a perturbed torque. A failed run is unstable.
fn run_perturbed(scene: &Scene, rest: &StaticGrasp) -> Result<RunEnd, ComputeError> {
    let mut tracker = Tracker::new(rest.final_angles());
    match trace::run_analytic(&perturbed(scene, STUDY_PERTURBATION), &mut tracker) {
        Ok(_) => Ok(run_end(&tracker, rest)),
        Err(RunError::Simulation { .. }) => Ok((Class::Unstable, None)),
        Err(RunError::Sink(reason)) => Err(step_error("a variation")(reason)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_grouped_by_verdict() {
        let mut checks = Checks::default();
        for (run, verdict, path) in [
            (1, Verdict::Accurate, 2e-9),
            (2, Verdict::Accurate, 7e-8),
            (3, Verdict::Uncertain, 1e-3),
            (4, Verdict::Chaotic, f64::INFINITY),
            (5, Verdict::Unknown, 0.0),
        ] {
            let mut check = Check::not_completed(Model::Analytic, 0.0, "");
            (check.verdict, check.errors.path) = (verdict, path);
            checks.add(run, &check);
        }
        let expected = Checks {
            runs: 5,
            uncertain_runs: vec![3],
            chaotic_runs: vec![4],
            unknown_runs: vec![5],
            worst_error_rad: 7e-8,
        };
        assert_eq!(checks, expected);
    }
}
