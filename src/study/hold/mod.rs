//! Largest acceleration of the palm under which a gripper holds its object, found by simulation.
//!
//! The scene runs until its object is at rest. Then a load moves the palm: pulses in several directions, vibrations, or
//! a pick-and-place move with a scaled duration. Loads of one kind differ only in their peak acceleration. A run
//! continues for `SETTLING_S` after the load. The object *slips* under a load if it is not held at the end, or if it
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
//! | `plan` | parameters and errors |
//! | `prepare` | the scene up to the start of the loads, clearance from the table, acceleration that is balanced at rest |
//! | `load` | palm motions with a given peak acceleration |
//! | `search` | limits between held and failing loads |

mod load;
mod plan;
mod prepare;
mod search;

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::criteria::{Fate, GraspTracker};
use crate::grasp::run;
use crate::numeric::elementary::{ln, log2};
use crate::scene::Scene;
use crate::statics::AccelerationLimit;
use crate::study::pool;
use crate::trace::Model;
use crate::units::MAX_TIME_S;

use prepare::PreparedScene;

pub use load::{Load, LoadCase, LoadSetup, LoadSize};

pub(crate) use load::axis_name;
pub(crate) use plan::SETTLING_S;
pub use plan::{HoldError, KeepRunning, LoadOutcome, Loads, Plan};
pub use prepare::StartReason;
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
    pub static_limit: Option<AccelerationLimit>,
    /// Evaluations, sorted by load.
    pub evaluations: Vec<Evaluation>,
    pub slips: Limit,
    pub drops: Limit,
}

/// Outcome of the run under one load.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evaluation {
    pub peak_m_s2: f64,
    #[serde(flatten)]
    pub size: LoadSize,
    /// The outcome, or the reason why the run was not completed.
    #[serde(flatten, serialize_with = "outcome_or_reason")]
    pub outcome: Result<LoadOutcome, String>,
}

impl Evaluation {
    /// Verdict on slip: the object must be held at the end and slip by at most `max_slip_m`.
    pub fn slips(&self, max_slip_m: f64) -> Verdict {
        self.verdict(|outcome| outcome.slip.displacement_m <= max_slip_m)
    }

    /// Verdict on dropping: the object must be held at the end, regardless of its slip.
    pub fn drops(&self) -> Verdict {
        self.verdict(|_| true)
    }

    fn verdict(&self, passes: impl Fn(&LoadOutcome) -> bool) -> Verdict {
        match &self.outcome {
            Err(_) => Verdict::Unknown,
            Ok(outcome) if outcome.fate == Fate::Held && passes(outcome) => Verdict::Held,
            Ok(_) => Verdict::Failed,
        }
    }
}

impl LoadResult {
    /// Returns the evaluation of a load.
    pub(crate) fn evaluation_at(&self, peak_m_s2: f64) -> Option<&Evaluation> {
        self.evaluations.iter().find(|evaluation| evaluation.peak_m_s2 == peak_m_s2)
    }

    /// Returns the size of the largest load below the first failure.
    pub(crate) fn held_size(&self, limit: &Limit) -> Option<LoadSize> {
        Some(self.evaluation_at(limit.held?)?.size)
    }

    /// Returns how the object fails at the limit: `slip`, or its fate; `None` if no load fails.
    pub fn ended_by(&self, limit: &Limit) -> Option<&'static str> {
        let run = self.evaluation_at(limit.failed?)?;
        let fate = run.outcome.as_ref().ok()?.fate;
        Some(if run.drops() == Verdict::Held { "slip" } else { fate.name() })
    }

    /// Adds evaluations and updates the limits.
    fn with_evaluations(mut self, evaluations: impl IntoIterator<Item = Evaluation>, slip_m: f64) -> Self {
        self.evaluations.extend(evaluations);
        self.evaluations.sort_by(|a, b| a.peak_m_s2.total_cmp(&b.peak_m_s2));
        self.slips = Limit::from_verdicts(self.evaluations.iter().map(|run| (run.peak_m_s2, run.slips(slip_m))));
        self.drops = Limit::from_verdicts(self.evaluations.iter().map(|run| (run.peak_m_s2, run.drops())));
        self
    }
}

/// Serialises the study with the parameters of its plan.
impl Serialize for Hold {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let runs = || self.results.iter().flat_map(|load| &load.evaluations);
        let start_reason = match self.start_reason {
            StartReason::Requested => "given",
            StartReason::AtRest => "at rest",
            StartReason::StillMoving { .. } => "still moving",
            StartReason::MoveCompleted => "moved",
            StartReason::OwnMove => "own move",
        };
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("scene", &self.scene)?;
        map.serialize_entry("model", self.plan.model.name())?;
        map.serialize_entry("begins_s", &self.setup.start_s)?;
        map.serialize_entry("begins", start_reason)?;
        map.serialize_entry("slip_bound_m", &self.plan.slip_m)?;
        map.serialize_entry("from_m_s2", &self.plan.from_m_s2)?;
        map.serialize_entry("to_m_s2", &self.plan.to_m_s2)?;
        map.serialize_entry("scan", &self.plan.scan)?;
        map.serialize_entry("tolerance", &self.plan.tolerance)?;
        map.serialize_entry("unloaded_slip", &self.unloaded.slip)?;
        map.serialize_entry("runs", &runs().count())?;
        map.serialize_entry("unfinished", &runs().filter(|run| run.outcome.is_err()).count())?;
        map.serialize_entry("loads", &self.results)?;
        map.end()
    }
}

/// Serialises the kind of load with its limits and runs. `quasi_static` is `nothing`, `up to` (`quasi_static_m_s2`) or
/// `any`; null for loads that rotate the palm, and where statics has no solution.
impl Serialize for LoadResult {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Document<'a> {
            #[serde(flatten)]
            case: LoadCase,
            to_m_s2: f64,
            quasi_static: Option<&'static str>,
            quasi_static_m_s2: Option<f64>,
            slips: LimitDocument,
            drops: LimitDocument,
            runs: &'a [Evaluation],
        }
        #[derive(Serialize)]
        struct LimitDocument {
            held_m_s2: Option<f64>,
            failed_m_s2: Option<f64>,
            held_size: Option<LoadSize>,
            ended_by: Option<&'static str>,
            monotone: bool,
            held_above_m_s2: Option<f64>,
            unfinished: usize,
        }
        let (quasi_static, quasi_static_m_s2) = match &self.static_limit {
            None => (None, None),
            Some(AccelerationLimit::Infeasible) => (Some("nothing"), None),
            Some(AccelerationLimit::Limited(limit)) => (Some("up to"), Some(limit.acceleration_m_s2)),
            Some(AccelerationLimit::Unlimited) => (Some("any"), None),
        };
        let limit = |limit: &Limit| LimitDocument {
            held_m_s2: limit.held,
            failed_m_s2: limit.failed,
            held_size: self.held_size(limit),
            ended_by: self.ended_by(limit),
            monotone: limit.held_above.is_none(),
            held_above_m_s2: limit.held_above,
            unfinished: limit.unknown,
        };
        let (slips, drops) = (limit(&self.slips), limit(&self.drops));
        let (case, to_m_s2, runs) = (self.case, self.to_m_s2, &self.evaluations);
        Document { case, to_m_s2, quasi_static, quasi_static_m_s2, slips, drops, runs }.serialize(serializer)
    }
}

/// Serialises the outcome of a run, or nulls and the reason.
fn outcome_or_reason<S: Serializer>(outcome: &Result<LoadOutcome, String>, serializer: S) -> Result<S::Ok, S::Error> {
    let found = outcome.as_ref().ok();
    let mut map = serializer.serialize_map(None)?;
    map.serialize_entry("fate", &found.map(|found| found.fate.name()))?;
    map.serialize_entry("slip", &found.map(|found| found.slip))?;
    map.serialize_entry("brake_slip_rad", &found.map(|found| found.brake_slip_rad))?;
    map.serialize_entry("end_s", &found.map(|found| found.end_s))?;
    map.serialize_entry("steps", &found.map(|found| found.steps))?;
    map.serialize_entry("reason", &outcome.as_ref().err())?;
    map.end()
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
    run_study(scene, plan, progress, &done, keep_running).map_err(|error| match error {
        HoldError::Stopped { .. } => HoldError::Stopped { done: done.load(Ordering::Relaxed) },
        error => error,
    })
}

fn run_study(
    scene: &Scene,
    plan: Plan,
    progress: &mut (dyn FnMut(u64, u64) + Send),
    done: &AtomicU64,
    keep_running: KeepRunning<'_>,
) -> Result<Hold, HoldError> {
    let prepared = prepare::prepare(scene, &plan, keep_running)?;
    let cases = load_cases(&plan.loads);
    let latest_end_s =
        |peak_m_s2: f64| cases.iter().map(|case| case.load(&prepared.setup, peak_m_s2).end_s).fold(0.0, f64::max);
    // The scene's own move takes longest under the smallest load.
    let end_s = latest_end_s(plan.from_m_s2) + SETTLING_S;
    if end_s > MAX_TIME_S {
        return Err(HoldError::TooLong { end_s });
    }
    let largest_loads = cases.iter().map(|case| prepare::largest_clear_load(&prepared, &plan, case));
    let largest_loads = largest_loads.collect::<Result<Vec<f64>, _>>()?;
    let unloaded = Load { motion: prepared.setup.prior_motion.clone(), end_s: latest_end_s(plan.to_m_s2) };
    let unloaded = match simulate(plan.model, &prepared, unloaded, keep_running)? {
        Err(reason) => return Err(HoldError::Scene { reason }),
        Ok(outcome) if outcome.fate != Fate::Held || outcome.slip.displacement_m > plan.slip_m => {
            return Err(HoldError::SlipsUnloaded { start_s: prepared.setup.start_s, bound_m: plan.slip_m, outcome });
        }
        Ok(outcome) => outcome,
    };
    let start = prepared.scene.with_palm_motion(Some(prepared.setup.prior_motion.clone()), prepared.setup.start_s);
    let at_start = prepare::run_scene(plan.model, &start, &mut GraspTracker::for_scene(&start), keep_running)?.last;
    let results = cases.iter().zip(largest_loads).map(|(case, to_m_s2)| LoadResult {
        case: *case,
        to_m_s2,
        static_limit: prepare::static_limit(&prepared, &at_start, case),
        evaluations: Vec::new(),
        slips: Limit::default(),
        drops: Limit::default(),
    });
    let results: Vec<LoadResult> = results.collect();
    let evaluate = |case: &LoadCase, peak_m_s2: f64, sender: &Sender<u64>| -> Result<Evaluation, HoldError> {
        let outcome = simulate(plan.model, &prepared, case.load(&prepared.setup, peak_m_s2), keep_running)?;
        // A missing receiver does not end the study.
        let _ = sender.send(done.fetch_add(1, Ordering::Relaxed) + 1);
        Ok(Evaluation { peak_m_s2, size: case.named_size(&prepared.setup, peak_m_s2), outcome })
    };
    let scan = |result: &LoadResult| search::geometric_loads(plan.from_m_s2, result.to_m_s2, plan.scan);
    let jobs: Vec<(LoadCase, f64)> =
        results.iter().flat_map(|result| scan(result).into_iter().map(|load| (result.case, load))).collect();
    let mut total = jobs.len() as u64;
    let scanned = pool::map(
        plan.threads,
        &jobs,
        |(case, load), sender: &Sender<u64>| evaluate(case, *load, sender),
        |completed| progress(completed, total),
    );
    let mut scanned = scanned.into_iter().collect::<Result<Vec<Evaluation>, _>>()?.into_iter();
    let add_scan = |result: LoadResult| result.with_evaluations(scanned.by_ref().take(plan.scan), plan.slip_m);
    let results: Vec<LoadResult> = results.into_iter().map(add_scan).collect();
    total += results.iter().map(|result| max_bisections(result, plan.tolerance)).sum::<u64>();
    // Refines both limits by bisection to the plan's tolerance.
    let refine = |result: &LoadResult, sender: &Sender<u64>| {
        let mut result = result.clone();
        while let Some(load) = result.slips.next_load(plan.tolerance).or(result.drops.next_load(plan.tolerance)) {
            result = result.clone().with_evaluations([evaluate(&result.case, load, sender)?], plan.slip_m);
        }
        Ok(result)
    };
    let refined = pool::map(plan.threads, &results, refine, |completed| progress(completed, total.max(completed)));
    let results = refined.into_iter().collect::<Result<_, HoldError>>()?;
    let PreparedScene { setup, start_reason, .. } = prepared;
    Ok(Hold { scene: scene.name.clone(), plan, setup, start_reason, unloaded, results })
}

fn load_cases(loads: &Loads) -> Vec<LoadCase> {
    match loads {
        Loads::Pulses { directions, length_s } => {
            let direction = |index: usize| TAU * index as f64 / *directions as f64;
            let pulse = |index| LoadCase::Pulse { direction_rad: direction(index), length_s: *length_s };
            (0..*directions).map(pulse).collect()
        }
        Loads::Vibrations { axes, frequencies_hz } => {
            let pairs = axes.iter().flat_map(|axis| frequencies_hz.iter().map(|frequency_hz| (*axis, *frequency_hz)));
            pairs.map(|(axis, frequency_hz)| LoadCase::Vibration { axis, frequency_hz }).collect()
        }
        Loads::Move => vec![LoadCase::Move],
    }
}

/// Largest number of runs that the refinement takes.
fn max_bisections(result: &LoadResult, tolerance: f64) -> u64 {
    let bisections = |limit: &Limit| {
        limit.held.zip(limit.failed).map_or(0.0, |(held, failed)| log2(ln(failed / held) / tolerance).ceil().max(0.0))
    };
    (bisections(&result.slips) + bisections(&result.drops)) as u64
}

/// Simulates the gripper under a motion of its palm and for [`SETTLING_S`] afterwards. The inner error is the reason why
/// the run was not completed.
fn simulate(
    model: Model,
    prepared: &PreparedScene,
    load: Load,
    keep_running: KeepRunning<'_>,
) -> Result<Result<LoadOutcome, String>, HoldError> {
    let duration_s = load.end_s + SETTLING_S;
    let scene = prepared.scene.with_palm_motion(Some(load.motion), duration_s);
    let mut tracker = GraspTracker::for_scene(&scene).with_motion_start(prepared.setup.start_s);
    let outcome = run(model, &scene, &mut tracker, keep_running).ok_or(HoldError::Stopped { done: 0 })?;
    Ok(outcome.and_then(|outcome| {
        let criteria = tracker.criteria().ok_or("there is no sample")?;
        Ok(LoadOutcome {
            fate: criteria.fate,
            // None only if the object left the hand before the load; `fate` reports this.
            slip: criteria.cycle.motion_travel.unwrap_or_default(),
            brake_slip_rad: criteria.cycle.brake_slip_rad.into_iter().flatten().fold(0.0, f64::max),
            end_s: outcome.last.time_s,
            steps: outcome.work.steps,
        })
    }))
}
