//! Largest acceleration of the palm under which a gripper holds its object, found by simulation.
//!
//! The scene runs until its object is at rest. Then a load moves the palm: pulses in several directions, vibrations, or
//! a pick-and-place move with a scaled duration. Loads of one kind differ only in their peak acceleration. A run
//! continues for [`SETTLING_S`] after the load. The object *slips* under a load if it is not held at the end, or if it
//! moves further in the hand than the bound after the start of the load (`grasp.cycle.carried` of a run). It is
//! *dropped* if it is not held at the end.
//!
//! The result is not always monotone: contacts rattle, and a larger load can return an object to the hand that a
//! smaller one throws out. Therefore the study first scans the whole range, refines the first failure by bisection, and
//! reports larger loads that are held. A resonance narrower than the spacing of the scan can be missed. Runs that
//! cannot be completed count as neither held nor failed.
//!
//! | file | job |
//! |---|---|
//! | `plan` | parameters |
//! | `error` | errors |
//! | `prepared`, `prepare` | the scene up to the start of the loads |
//! | `rest` | time at which the object comes to rest |
//! | `motion` | scaled, delayed and fading motions |
//! | `load` | palm motions with a given peak acceleration |
//! | `clearance` | clearance from the table |
//! | `evaluation` | evaluation of one load |
//! | `balance` | acceleration that contact forces can balance at rest |
//! | `search` | limits between held and failing loads |

mod balance;
mod clearance;
mod error;
mod evaluation;
mod load;
mod motion;
mod plan;
mod prepare;
mod prepared;
mod rest;
mod search;

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;

use crate::criteria::{Fate, GraspTracker};
use crate::grasp::run;
use crate::numeric::elementary::{ln, log2};
use crate::scene::{Axis, Scene};
use crate::study::pool;
use crate::trace::Sample;
use crate::units::MAX_TIME_S;

use prepared::PreparedScene;

pub use balance::StaticLimit;
pub use error::HoldError;
pub use evaluation::{Evaluation, LoadOutcome};
pub use load::{Load, LoadCase, LoadSetup};
pub use plan::{KeepRunning, Loads, Plan, REST_SPEED_M_S, SETTLING_S};
pub use prepared::StartReason;
pub use search::{Limit, Verdict};

/// Result of a hold study.
#[derive(Clone, Debug, PartialEq)]
pub struct Hold {
    pub scene: String,
    pub plan: Plan,
    pub setup: LoadSetup,
    pub start_reason: StartReason,
    /// Outcome of a run of the same duration without a load.
    pub unloaded: LoadOutcome,
    pub results: Vec<LoadResult>,
}

/// Results for one kind of load.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadResult {
    pub case: LoadCase,
    /// Largest load of the scan: the plan's, or the largest that keeps the object clear of the table.
    pub to_m_s2: f64,
    /// Acceleration that is balanced at rest at the start of the loads; `None` if this kind of load has no such limit.
    pub static_limit: Option<StaticLimit>,
    /// Evaluations, sorted by load.
    pub evaluations: Vec<Evaluation>,
    pub slips: Limit,
    pub drops: Limit,
}

impl LoadResult {
    /// Returns the evaluation of a load.
    pub fn evaluation_at(&self, peak_m_s2: f64) -> Option<&Evaluation> {
        self.evaluations.iter().find(|evaluation| evaluation.peak_m_s2 == peak_m_s2)
    }

    /// Adds evaluations and updates the limits.
    fn with_evaluations(mut self, evaluations: impl IntoIterator<Item = Evaluation>, slip_m: f64) -> Self {
        self.evaluations.extend(evaluations);
        let LoadResult { case, to_m_s2, static_limit, mut evaluations, .. } = self;
        evaluations.sort_by(|a, b| a.peak_m_s2.total_cmp(&b.peak_m_s2));
        let slips = Limit::from_verdicts(evaluations.iter().map(|run| (run.peak_m_s2, run.slips(slip_m))));
        let drops = Limit::from_verdicts(evaluations.iter().map(|run| (run.peak_m_s2, run.drops())));
        LoadResult { case, to_m_s2, static_limit, evaluations, slips, drops }
    }
}

/// Finds the limits of all kinds of load on the plan's number of threads. `progress` receives the completed and the
/// total number of runs.
///
/// # Errors
/// Returns an error if the scene does not hold its object, the loads are not possible, or `keep_running` returned
/// `false`.
///
/// # Panics
/// Panics if the plan's scan has fewer than 2 loads.
pub fn hold(
    scene: &Scene,
    plan: Plan,
    progress: &mut (dyn FnMut(u64, u64) + Send),
    keep_running: KeepRunning<'_>,
) -> Result<Hold, HoldError> {
    let done = AtomicU64::new(0);
    let stopped = || HoldError::Stopped { done: done.load(Ordering::Relaxed) };
    let prepared = prepare::prepare(scene, &plan, keep_running)?.ok_or_else(stopped)?;
    let cases = load_cases(&plan.loads);
    // The scene's own move takes longest under the smallest load.
    let run_end = |case: &LoadCase| case.load(&prepared.setup, plan.from_m_s2).end_s + SETTLING_S;
    let end_s = cases.iter().map(run_end).fold(0.0, f64::max);
    if end_s > MAX_TIME_S {
        return Err(HoldError::TooLong { end_s });
    }
    let largest_loads = clearance::largest_clear_loads(&prepared, &plan, &cases)?;
    let unloaded = run_unloaded(&prepared, &plan, &cases, keep_running)?.ok_or_else(stopped)?;
    let sample = sample_at_start(&prepared, &plan, keep_running)?.ok_or_else(stopped)?;
    let start = &prepared;
    let pending: Vec<LoadResult> = cases
        .iter()
        .zip(largest_loads)
        .map(|(case, to_m_s2)| LoadResult {
            case: *case,
            to_m_s2,
            static_limit: balance::static_limit(start, &sample, case),
            evaluations: Vec::new(),
            slips: Limit::default(),
            drops: Limit::default(),
        })
        .collect();

    let scan = |result: &LoadResult| search::geometric_loads(plan.from_m_s2, result.to_m_s2, plan.scan);
    let jobs: Vec<(LoadCase, f64)> =
        pending.iter().flat_map(|result| scan(result).into_iter().map(|load| (result.case, load))).collect();
    let mut total = jobs.len() as u64;
    let evaluations = pool::map(
        plan.threads,
        &jobs,
        |(case, load), sender: &Sender<u64>| {
            let evaluation = evaluation::evaluate(plan.model, start, case, *load, keep_running);
            // A missing receiver does not end the study.
            let _ = sender.send(done.fetch_add(1, Ordering::Relaxed) + 1);
            evaluation
        },
        |completed| progress(completed, total),
    );
    let mut evaluations = evaluations.into_iter().collect::<Option<Vec<Evaluation>>>().ok_or_else(stopped)?.into_iter();
    let scanned: Vec<LoadResult> = pending
        .into_iter()
        .map(|result| result.with_evaluations(evaluations.by_ref().take(plan.scan), plan.slip_m))
        .collect();
    total += scanned.iter().map(|result| max_bisections(result, plan.tolerance)).sum::<u64>();
    let refined = pool::map(
        plan.threads,
        &scanned,
        |result, sender: &Sender<u64>| {
            refine(result, &plan, start, keep_running, &|| {
                let _ = sender.send(done.fetch_add(1, Ordering::Relaxed) + 1);
            })
        },
        |completed| progress(completed, total.max(completed)),
    );
    let results = refined.into_iter().collect::<Option<_>>().ok_or_else(stopped)?;
    let PreparedScene { setup, start_reason, .. } = prepared;
    Ok(Hold { scene: scene.name.clone(), plan, setup, start_reason, unloaded, results })
}

fn load_cases(loads: &Loads) -> Vec<LoadCase> {
    match loads {
        Loads::Pulses { directions, length_s } => {
            let direction = |index: usize| TAU * index as f64 / *directions as f64;
            (0..*directions)
                .map(|index| LoadCase::Pulse { direction_rad: direction(index), length_s: *length_s })
                .collect()
        }
        Loads::Vibrations { axes, frequencies_hz } => {
            let cases_of_axis = |axis: &Axis| {
                let axis = *axis;
                frequencies_hz.iter().map(move |frequency_hz| LoadCase::Vibration { axis, frequency_hz: *frequency_hz })
            };
            axes.iter().flat_map(cases_of_axis).collect()
        }
        Loads::Move => vec![LoadCase::Move],
    }
}

/// Refines both limits by bisection to the plan's tolerance; `None` if interrupted.
fn refine(
    result: &LoadResult,
    plan: &Plan,
    prepared: &PreparedScene,
    keep_running: KeepRunning<'_>,
    count_run: &dyn Fn(),
) -> Option<LoadResult> {
    let mut result = result.clone();
    while let Some(load) = result.slips.next_load(plan.tolerance).or(result.drops.next_load(plan.tolerance)) {
        let evaluation = evaluation::evaluate(plan.model, prepared, &result.case, load, keep_running)?;
        count_run();
        result = result.with_evaluations([evaluation], plan.slip_m);
    }
    Some(result)
}

/// Largest number of runs that the refinement takes.
fn max_bisections(result: &LoadResult, tolerance: f64) -> u64 {
    let bisections = |limit: &Limit| {
        limit.held.zip(limit.failed).map_or(0.0, |(held, failed)| log2(ln(failed / held) / tolerance).ceil().max(0.0))
    };
    (bisections(&result.slips) + bisections(&result.drops)) as u64
}

/// Runs the scene without a load for the duration of the longest run; `None` if interrupted.
fn run_unloaded(
    prepared: &PreparedScene,
    plan: &Plan,
    cases: &[LoadCase],
    keep_running: KeepRunning<'_>,
) -> Result<Option<LoadOutcome>, HoldError> {
    let longest_s = cases.iter().map(|case| case.load(&prepared.setup, plan.to_m_s2).end_s).fold(0.0, f64::max);
    let load = Load { motion: prepared.setup.prior_motion.clone(), end_s: longest_s };
    match evaluation::simulate(plan.model, prepared, load, keep_running) {
        None => Ok(None),
        Some(Err(reason)) => Err(HoldError::Scene { reason }),
        Some(Ok(outcome)) if outcome.fate != Fate::Held || outcome.slip.displacement_m > plan.slip_m => {
            Err(HoldError::SlipsUnloaded { start_s: prepared.setup.start_s, bound_m: plan.slip_m, outcome })
        }
        Some(Ok(outcome)) => Ok(Some(outcome)),
    }
}

/// Returns the last sample before the loads start; `None` if interrupted.
fn sample_at_start(
    prepared: &PreparedScene,
    plan: &Plan,
    keep_running: KeepRunning<'_>,
) -> Result<Option<Sample>, HoldError> {
    let (motion, duration_s) = (prepared.setup.prior_motion.clone(), prepared.setup.start_s);
    let scene = prepared.scene.with_palm_motion(Some(motion), duration_s);
    match run(plan.model, &scene, &mut GraspTracker::for_scene(&scene), keep_running) {
        None => Ok(None),
        Some(Err(reason)) => Err(HoldError::Scene { reason }),
        Some(Ok(outcome)) => Ok(Some(outcome.last)),
    }
}
