//! Evaluation of one load by simulation.

use super::load::{Load, LoadCase};
use super::plan::SETTLING_S;
use super::prepared::PreparedScene;
use super::search::Verdict;
use crate::criteria::{Fate, GraspTracker, Travel};
use crate::grasp::run;
use crate::trace::Model;

/// Outcome of the run under one load.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    pub peak_m_s2: f64,
    /// The outcome, or the reason why the run was not completed.
    pub outcome: Result<LoadOutcome, String>,
}

/// Outcome of a completed run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadOutcome {
    pub fate: Fate,
    /// Slip in the hand since the start of the load: `grasp.cycle.carried` of a run.
    pub slip: Travel,
    /// Largest rotation of a driven link against its brake; 0 without brakes.
    pub brake_slip_rad: f64,
    pub end_s: f64,
    pub steps: u64,
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

/// Evaluates a load; `None` if interrupted.
pub(super) fn evaluate(
    model: Model,
    prepared: &PreparedScene,
    case: &LoadCase,
    peak_m_s2: f64,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Evaluation> {
    let outcome = simulate(model, prepared, case.load(&prepared.setup, peak_m_s2), keep_running)?;
    Some(Evaluation { peak_m_s2, outcome })
}

/// Simulates the gripper under a motion of its palm and for [`SETTLING_S`] afterwards; `None` if interrupted.
pub(super) fn simulate(
    model: Model,
    prepared: &PreparedScene,
    load: Load,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Result<LoadOutcome, String>> {
    let duration_s = load.end_s + SETTLING_S;
    let scene = prepared.scene.with_palm_motion(Some(load.motion), duration_s);
    let mut tracker = GraspTracker::for_scene(&scene).with_motion_start(prepared.setup.start_s);
    let outcome = run(model, &scene, &mut tracker, keep_running)?;
    Some(outcome.and_then(|outcome| {
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
