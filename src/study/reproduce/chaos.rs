//! Near-chaotic simulations: their class depends on tolerances and on small changes of the torque.
//!
//! A rebound amplifies small differences. After a few rebounds, two nearly equal runs can come to rest at different
//! times, or one of them not at all. The class is then not a property of the design alone. The variations use the runs
//! of the checks: another method at a finer tolerance, without and with a perturbed torque.

use serde::Serialize;

use super::checks::{Checks, write_check};
use super::{INTERRUPTED, ReproduceError};
use crate::check::{Check, PERTURBATION, check_with_sinks, perturbed};
use crate::criteria::{Class, StaticGrasp, Tracker, static_grasp};
use crate::scene::Scene;
use crate::study::pool;
use crate::study::select::{Candidate, Selection};
use crate::study::sweep::Status;
use crate::table::Table;
use crate::trace::{self, Model, RunError, Sink};

/// Relative perturbation of the torque in [`Variation::Perturbed`].
const STUDY_PERTURBATION: f64 = 1e-9;

/// Largest difference of two times to stability that count as equal; an impact lasts about a microsecond.
pub const MAX_TTS_DIFFERENCE_S: f64 = 1e-5;

/// A variation that should give the same result as the run of the study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Variation {
    /// The reference run of the check: another method, at a hundredth of the tolerance.
    Reference,
    /// The reference run with the motor torque increased by the factor [`PERTURBATION`].
    PerturbedReference,
    /// The run of the study with the motor torque increased by a billionth.
    Perturbed,
}

impl Variation {
    pub const ALL: [Variation; 3] = [Variation::Reference, Variation::PerturbedReference, Variation::Perturbed];

    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Variation::Reference => "another method, finer",
            Variation::PerturbedReference => "the same, torque + 1e-7",
            Variation::Perturbed => "torque + 1e-9",
        }
    }
}

const _: () = assert!(PERTURBATION == 1e-7, "the value in the name of the variation");

/// Effect of the variations on the classes.
#[derive(Clone, Debug, PartialEq)]
pub struct Chaos {
    /// Runs whose class is not the same in all variations.
    pub class_changes: Vec<ClassChange>,
    /// Runs whose time to stability changes by more than [`MAX_TTS_DIFFERENCE_S`], or exists only in some variations.
    pub drifting: Vec<i64>,
    /// Number of dynamically stable runs (stable and semi-stable) by condition: in the study, then in each variation.
    pub stable: Vec<Vec<usize>>,
    /// Number of runs by condition that are stable in the study and in every variation.
    pub stable_in_all: Vec<usize>,
    /// Number of runs by condition that are stable in the study or in any variation.
    pub stable_in_any: Vec<usize>,
}

/// A run whose class changes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClassChange {
    pub run: i64,
    pub design: i64,
    #[serde(skip)]
    pub condition: usize,
    pub class: Class,
    /// Classes in the order of the variations.
    #[serde(rename = "by_variation")]
    pub classes: Vec<Class>,
}

/// Checks every completed run of the study, writes the check into its row, and repeats every statically stable run in
/// each variation. Other runs are unstable in every variation.
pub fn chaos(
    scenes: &[Scene],
    results: &mut Table,
    selection: &Selection,
    threads: usize,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<(Checks, Chaos), ReproduceError> {
    let jobs: Vec<usize> =
        (0..selection.runs.len()).filter(|&run| selection.runs[run].status == Status::Completed).collect();
    let work =
        |&run: &usize, _: &_| repeat_run(&scenes[run], selection.runs[run].force_positive == Some(true), keep_running);
    let repeated: Vec<RepeatedRun> = pool::map(threads, &jobs, work, |()| ()).into_iter().collect::<Result<_, _>>()?;
    let mut checks = Checks::default();
    for (&run, repeat) in jobs.iter().zip(&repeated) {
        checks.add(selection.runs[run].run, &repeat.check);
        write_check(results, selection.runs[run].row, &repeat.check);
    }
    let class = |run: &Candidate| run.class.unwrap_or(Class::Unstable);
    let differs = |study: Option<f64>, other: Option<f64>| match (study, other) {
        (Some(study_s), Some(other_s)) => (study_s - other_s).abs() > MAX_TTS_DIFFERENCE_S,
        (None, None) => false,
        _ => true,
    };
    let mut drifting: Vec<i64> = jobs
        .iter()
        .zip(&repeated)
        .filter(|(run, repeat)| repeat.ends.iter().flatten().any(|end| differs(selection.runs[**run].tts_s, end.1)))
        .map(|(run, _)| selection.runs[*run].run)
        .collect();
    drifting.sort_unstable();
    let unchanged = |run: &Candidate| [class(run); Variation::ALL.len()];
    let mut classes: Vec<[Class; Variation::ALL.len()]> = selection.runs.iter().map(unchanged).collect();
    for (&run, repeat) in jobs.iter().zip(repeated) {
        if let Some(ends) = repeat.ends {
            classes[run] = ends.map(|(class, _)| class);
        }
    }
    let changed =
        selection.runs.iter().zip(&classes).filter(|(run, varied)| varied.iter().any(|varied| *varied != class(run)));
    let class_changes = changed
        .map(|(run, varied)| ClassChange {
            run: run.run,
            design: run.design,
            condition: run.condition,
            class: class(run),
            classes: varied.to_vec(),
        })
        .collect();
    let is_stable = |class: Class| matches!(class, Class::Stable | Class::SemiStable);
    let count = |condition: usize, test: &dyn Fn(Class, &[Class]) -> bool| {
        let runs = selection.runs.iter().zip(&classes).filter(|(run, _)| run.condition == condition);
        runs.filter(|(run, varied)| test(class(run), &varied[..])).count()
    };
    let conditions = 0..selection.conditions.len();
    let by_variation = |condition: usize| {
        let study = count(condition, &|class, _| is_stable(class));
        let others = (0..Variation::ALL.len()).map(|index| count(condition, &|_, varied| is_stable(varied[index])));
        std::iter::once(study).chain(others).collect()
    };
    let chaos = Chaos {
        class_changes,
        drifting,
        stable: conditions.clone().map(by_variation).collect(),
        stable_in_all: conditions
            .clone()
            .map(|condition| {
                count(condition, &|class, varied| is_stable(class) && varied.iter().all(|varied| is_stable(*varied)))
            })
            .collect(),
        stable_in_any: conditions
            .map(|condition| {
                count(condition, &|class, varied| is_stable(class) || varied.iter().any(|varied| is_stable(*varied)))
            })
            .collect(),
    };
    Ok((checks, chaos))
}

/// Class and time to stability of a run.
type RunEnd = (Class, Option<f64>);

/// Result of repeating a run.
struct RepeatedRun {
    check: Check,
    /// Results in the order of the variations; `None` if the run is only checked.
    ends: Option<[RunEnd; Variation::ALL.len()]>,
}

/// Checks a run and, if `with_variations`, evaluates its variations.
fn repeat_run(
    scene: &Scene,
    with_variations: bool,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<RepeatedRun, ReproduceError> {
    let error = ReproduceError::in_step("a variation");
    let object = scene.object().ok_or_else(|| error(&"there is no object"))?;
    let rest = static_grasp(scene, object).map_err(|reason| error(&reason))?;
    let tracker = || Tracker::new(rest.final_angles());
    let (mut reference, mut perturbed_reference) = (tracker(), tracker());
    let sinks: [&mut dyn Sink; 2] =
        if with_variations { [&mut reference, &mut perturbed_reference] } else { [&mut (), &mut ()] };
    let check = check_with_sinks(Model::Analytic, scene, sinks, keep_running);
    let ends = match with_variations {
        true => Some([run_end(&reference, &rest), run_end(&perturbed_reference, &rest), run_perturbed(scene, &rest)?]),
        false => None,
    };
    // An interrupted check is not valid.
    if keep_running() { Ok(RepeatedRun { check, ends }) } else { Err(error(&INTERRUPTED)) }
}

fn run_end(tracker: &Tracker, rest: &StaticGrasp) -> RunEnd {
    let criteria = tracker.criteria(rest.static_forces_n());
    criteria.map_or((Class::Unstable, None), |criteria| (criteria.class, criteria.tts_s))
}

/// Runs the scene of the study with a perturbed torque. A failed run is unstable.
fn run_perturbed(scene: &Scene, rest: &StaticGrasp) -> Result<RunEnd, ReproduceError> {
    let scene = Scene { log: scene.log.without_sample_grid(scene.duration_s), ..perturbed(scene, STUDY_PERTURBATION) };
    let mut tracker = Tracker::new(rest.final_angles());
    match trace::run_analytic(&scene, &mut tracker) {
        Ok(_) => Ok(run_end(&tracker, rest)),
        Err(RunError::Simulation { .. }) => Ok((Class::Unstable, None)),
        Err(RunError::Sink(reason)) => Err(ReproduceError::in_step("a variation")(&reason)),
    }
}
