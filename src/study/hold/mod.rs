//! Largest acceleration of the base under which a hand holds its object, found by simulation.
//!
//! The scene runs until its object is at rest. Then a load moves the palm of a gripper, or the base of a mechanism: pulses in several directions, vibrations, or
//! a pick-and-place move with a scaled duration. Loads of one kind differ only in their peak acceleration. A run
//! continues for `SETTLING_S` after the load. The object *slips* under a load if it is not held at the end, or if it
//! moves further in the hand than the bound after the start of the load (`grasp.cycle.carried` of a run). It is
//! *dropped* if it is not held at the end.
//!
//! The result is not always monotone: contacts rattle, and a larger load can return an object to the hand that a
//! smaller one throws out. Therefore the study first scans the whole range, refines the first failure by bisection, and
//! reports larger loads that are held. A resonance narrower than the spacing of the scan can be missed. Runs that
//! cannot be completed count as neither held nor failed.

mod base;
mod gripper;
mod limit;
mod load;
mod mechanism;
mod plan;
mod prepare;

use std::f64::consts::TAU;

use phalanx_show::format::object::Object;
use serde::{Serialize, Serializer};

use crate::criteria::Fate;
use crate::scene::Scene;
use crate::statics::MechanismLimit;
use crate::trace::Model;
use crate::units::MAX_TIME_S;
use phalanx_parallel::{ComputeError, Monitor, map};

use gripper::PreparedGripper;
use mechanism::PreparedMechanism;

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
    /// Name of the base of a mechanism, which follows the loads; `None` for the palm of a gripper.
    pub base: Option<String>,
    /// Outlines of the surroundings of a mechanism that the loads would hit. They are removed from the start of the
    /// loads on.
    pub removed: Vec<String>,
    /// Names of the outlines of the ground that move with the base, because they count as part of the hand although no
    /// key says so.
    pub assumed_hand: Vec<String>,
    /// Outcome of a run with the same duration and without a load.
    pub unloaded: LoadOutcome,
    pub results: Vec<LoadResult>,
}

/// Serialises the study with the parameters of its plan.
impl Serialize for Hold {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Hold { scene, plan, setup, start_reason, base, removed, unloaded, results, .. } = self;
        let runs = || results.iter().flat_map(|load| &load.evaluations);
        let mut object = Object::default().with("scene", scene).with("model", plan.model.name());
        if let Some(base) = base {
            object = object.with("base", base).with("removed", removed);
        }
        object
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

/// Finds the limits of all kinds of load, on the number of threads of the plan. The monitor counts the runs.
///
/// # Errors
/// Returns an error if the scene does not hold its object, if the loads are not possible, or if the monitor stops the
/// study.
///
/// # Panics
/// Panics if the scan of the plan has fewer than 2 loads.
pub fn hold(scene: &Scene, plan: Plan, monitor: &Monitor<'_>) -> Result<Hold, HoldError> {
    let cases = load_cases(&plan.loads);
    let prepared = match scene.finger_count() {
        0 => Prepared::Mechanism(Box::new(mechanism::prepare(scene, &plan, &cases, monitor)?)),
        _ => Prepared::Gripper(Box::new(gripper::prepare(scene, &plan, monitor)?)),
    };
    let setup = prepared.setup();
    let latest_end_s = |peak_m_s2: f64| cases.iter().map(|case| case.load(setup, peak_m_s2).end_s).fold(0.0, f64::max);
    // The scene's own move takes longest under the smallest load.
    let end_s = latest_end_s(plan.from_m_s2) + SETTLING_S;
    if end_s > MAX_TIME_S {
        return Err(HoldError::TooLong { end_s });
    }
    let largest_loads = cases.iter().map(|case| prepared.largest_clear_load(&plan, case));
    let largest_loads = largest_loads.collect::<Result<Vec<f64>, _>>()?;
    let unloaded = Load { motion: setup.prior_motion.clone(), end_s: latest_end_s(plan.to_m_s2) };
    let unloaded = match prepared.simulate(plan.model, unloaded, monitor)? {
        Err(reason) => return Err(HoldError::Scene { reason }),
        Ok(outcome) if outcome.fate != Fate::Held || outcome.slip.displacement_m > plan.slip_m => {
            return Err(HoldError::SlipsUnloaded { start_s: setup.start_s, bound_m: plan.slip_m, outcome });
        }
        Ok(outcome) => outcome,
    };
    let evaluate = |case: &LoadCase, peak_m_s2: f64| {
        let outcome = prepared.simulate(plan.model, case.load(setup, peak_m_s2), monitor)?;
        monitor.advance(1, "runs");
        Ok::<_, ComputeError>(Evaluation { peak_m_s2, size: case.named_size(setup, peak_m_s2), outcome })
    };
    let scan = |(case, to_m_s2): (&LoadCase, &f64)| {
        let loads = limit::geometric_loads(plan.from_m_s2, *to_m_s2, plan.scan).into_iter();
        loads.map(|load| (*case, load)).collect::<Vec<_>>()
    };
    let jobs: Vec<(LoadCase, f64)> = cases.iter().zip(&largest_loads).flat_map(scan).collect();
    monitor.start(jobs.len(), "runs");
    let scanned = map(plan.threads, &jobs, |(case, load)| evaluate(case, *load))?;
    let result = |((case, to_m_s2), evaluations): ((&LoadCase, f64), &[Evaluation])| {
        let static_limit = prepared.static_limit(case);
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
        Ok::<_, ComputeError>(result)
    };
    let results = map(plan.threads, &results, refine)?;
    let (base, removed, assumed_hand) = match &prepared {
        Prepared::Gripper(_) => (None, Vec::new(), Vec::new()),
        Prepared::Mechanism(of) => (Some(of.base_name().to_string()), of.removed.clone(), of.assumed_hand()),
    };
    let (setup, start_reason) = (setup.clone(), prepared.start_reason());
    Ok(Hold { scene: scene.name.clone(), plan, setup, start_reason, base, removed, assumed_hand, unloaded, results })
}

/// A scene that is prepared for loads.
enum Prepared {
    Gripper(Box<PreparedGripper>),
    Mechanism(Box<PreparedMechanism>),
}

impl Prepared {
    fn setup(&self) -> &LoadSetup {
        match self {
            Prepared::Gripper(of) => &of.prepared.setup,
            Prepared::Mechanism(of) => &of.setup,
        }
    }

    fn start_reason(&self) -> StartReason {
        match self {
            Prepared::Gripper(of) => of.prepared.start_reason,
            Prepared::Mechanism(of) => of.start_reason,
        }
    }

    /// Largest load of a case. The surroundings of a mechanism that a load would hit are removed.
    fn largest_clear_load(&self, plan: &Plan, case: &LoadCase) -> Result<f64, HoldError> {
        match self {
            Prepared::Gripper(of) => prepare::largest_clear_load(&of.prepared, plan, case),
            Prepared::Mechanism(_) => Ok(plan.to_m_s2),
        }
    }

    fn static_limit(&self, case: &LoadCase) -> Option<MechanismLimit> {
        match self {
            Prepared::Gripper(of) => prepare::static_limit(&of.prepared, &of.at_start, case),
            Prepared::Mechanism(of) => of.static_limit(case),
        }
    }

    /// Simulates the scene under a load. Returns the outcome, or the reason why the run was not completed.
    fn simulate(
        &self,
        model: Model,
        load: Load,
        monitor: &Monitor<'_>,
    ) -> Result<Result<LoadOutcome, String>, ComputeError> {
        match self {
            Prepared::Gripper(of) => gripper::simulate(model, &of.prepared, load, monitor),
            Prepared::Mechanism(of) => of.simulate(model, load, monitor),
        }
    }
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
