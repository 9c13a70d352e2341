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

mod limit;
mod load;
mod plan;
mod prepare;

use std::f64::consts::TAU;

use phalanx_show::format::object::Object;
use serde::{Serialize, Serializer};

use crate::criteria::{Fate, ObjectTracker};
use crate::grasp::run;
use crate::scene::Scene;
use crate::thesis::monitor::{Monitor, StudyError, map};
use crate::trace::Model;
use crate::units::MAX_TIME_S;

use prepare::PreparedScene;

pub use limit::{Evaluation, LoadBracket, LoadResult};
pub(crate) use load::axis_name;
pub use load::{Load, LoadCase, LoadSetup, LoadSize};
pub(crate) use plan::SETTLING_S;
pub use plan::{HoldError, LoadOutcome, Loads, Plan};
pub use prepare::StartReason;

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

/// Serialises the study with the parameters of its plan.
impl Serialize for Hold {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Hold { scene, plan, setup, start_reason, unloaded, results } = self;
        let runs = || results.iter().flat_map(|load| &load.evaluations);
        Object::default()
            .with("scene", scene)
            .with("model", plan.model.name())
            .with("begins_s", setup.start_s)
            .with("begins", start_reason)
            .with("slip_bound_m", plan.slip_m)
            .with("from_m_s2", plan.from_m_s2)
            .with("to_m_s2", plan.to_m_s2)
            .with("scan", plan.scan)
            .with("tolerance", plan.tolerance)
            .with("unloaded_slip", unloaded.slip)
            .with("runs", runs().count())
            .with("unfinished", runs().filter(|run| run.outcome.is_err()).count())
            .with("loads", results)
            .serialize(serializer)
    }
}

/// Finds the limits of all kinds of load on the plan's number of threads. The monitor counts the runs.
///
/// # Errors
/// Returns an error if the scene does not hold its object, the loads are not possible, or the monitor stops the study.
///
/// # Panics
/// Panics if the plan's scan has fewer than 2 loads.
pub fn hold(scene: &Scene, plan: Plan, monitor: &Monitor<'_>) -> Result<Hold, HoldError> {
    let prepared = prepare::prepare(scene, &plan, monitor)?;
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
    let unloaded = match simulate(plan.model, &prepared, unloaded, monitor)? {
        Err(reason) => return Err(HoldError::Scene { reason }),
        Ok(outcome) if outcome.fate != Fate::Held || outcome.slip.displacement_m > plan.slip_m => {
            return Err(HoldError::SlipsUnloaded { start_s: prepared.setup.start_s, bound_m: plan.slip_m, outcome });
        }
        Ok(outcome) => outcome,
    };
    let start = prepared.scene.with_palm_motion(Some(prepared.setup.prior_motion.clone()), prepared.setup.start_s);
    let at_start = prepare::run_scene(plan.model, &start, &mut ObjectTracker::for_scene(&start), monitor)?.last;
    let evaluate = |case: &LoadCase, peak_m_s2: f64| {
        let load = case.load(&prepared.setup, peak_m_s2);
        let outcome = simulate(plan.model, &prepared, load, monitor)?;
        monitor.advance(1, "runs");
        Ok::<_, StudyError>(Evaluation { peak_m_s2, size: case.named_size(&prepared.setup, peak_m_s2), outcome })
    };
    let scan = |(case, to_m_s2): (&LoadCase, &f64)| {
        let loads = limit::geometric_loads(plan.from_m_s2, *to_m_s2, plan.scan).into_iter();
        loads.map(|load| (*case, load)).collect::<Vec<_>>()
    };
    let jobs: Vec<(LoadCase, f64)> = cases.iter().zip(&largest_loads).flat_map(scan).collect();
    monitor.start(jobs.len(), "runs");
    let scanned = map(plan.threads, &jobs, |(case, load)| evaluate(case, *load))?;
    let result = |((case, to_m_s2), evaluations): ((&LoadCase, f64), &[Evaluation])| {
        let static_limit = prepare::static_limit(&prepared, &at_start, case);
        let [slips, drops] = [LoadBracket::default(); 2];
        let unknown = LoadResult { case: *case, to_m_s2, static_limit, evaluations: Vec::new(), slips, drops };
        unknown.with_evaluations(evaluations.to_vec(), plan.slip_m)
    };
    let results: Vec<LoadResult> = cases.iter().zip(largest_loads).zip(scanned.chunks(plan.scan)).map(result).collect();
    let bisections: u64 = results.iter().map(|result| result.max_bisections(plan.tolerance)).sum();
    monitor.start(jobs.len() + bisections as usize, "runs");
    // Refines both limits by bisection to the plan's tolerance.
    let refine = |result: &LoadResult| {
        let mut result = result.clone();
        while let Some(load) = result.slips.next_load(plan.tolerance).or(result.drops.next_load(plan.tolerance)) {
            let evaluation = evaluate(&result.case, load)?;
            result = result.with_evaluations(vec![evaluation], plan.slip_m);
        }
        Ok::<_, StudyError>(result)
    };
    let results = map(plan.threads, &results, refine)?;
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

/// Simulates the gripper under a motion of its palm and for [`SETTLING_S`] afterwards. Returns the outcome, or the reason
/// why the run was not completed.
fn simulate(
    model: Model,
    prepared: &PreparedScene,
    load: Load,
    monitor: &Monitor<'_>,
) -> Result<Result<LoadOutcome, String>, StudyError> {
    let scene = prepared.scene.with_palm_motion(Some(load.motion), load.end_s + SETTLING_S);
    let tracker = ObjectTracker::for_scene(&scene);
    let mut tracker = tracker.map(|tracker| tracker.with_motion_start(prepared.setup.start_s));
    let outcome = run(model, &scene, &mut tracker, monitor.keep_running()).ok_or_else(|| monitor.stopped())?;
    Ok(outcome.and_then(|outcome| {
        let criteria = tracker.and_then(|tracker| tracker.criteria()).ok_or("there is no sample")?;
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
