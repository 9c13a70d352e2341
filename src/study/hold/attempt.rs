//! One run under one load.

use super::load::{Case, Load};
use super::plan::AFTER_S;
use super::prepared::Prepared;
use super::search::Answer;
use crate::criteria::{Fate, GraspTracker, Travel};
use crate::grasp::run;
use crate::trace::Model;

/// A load, and what came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    pub peak_m_s2: f64,
    /// Or why the run has no end.
    pub found: Result<Found, String>,
}

/// What a run came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    pub fate: Fate,
    /// In the hand since the load began: what `grasp.cycle` calls carried.
    pub slip: Travel,
    /// How far links turned under their brakes, at most; 0 without any.
    pub brake_slip_rad: f64,
    pub end_s: f64,
    pub steps: u64,
}

impl Tried {
    /// Whether it is held and slips by no more than so much.
    pub fn slips(&self, bound_m: f64) -> Answer {
        self.answer(|found| found.slip.displacement_m <= bound_m)
    }

    /// Whether it is held, however far it slips.
    pub fn drops(&self) -> Answer {
        self.answer(|_| true)
    }

    fn answer(&self, holds: impl Fn(&Found) -> bool) -> Answer {
        match &self.found {
            Err(_) => Answer::Unknown,
            Ok(found) if found.fate == Fate::Held && holds(found) => Answer::Held,
            Ok(_) => Answer::Failed,
        }
    }
}

/// Simulates a load; `None` if it was told to stop.
pub(super) fn attempt(
    model: Model,
    prepared: &Prepared,
    case: &Case,
    peak_m_s2: f64,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Option<Tried> {
    let found = under(model, prepared, case.load(&prepared.stage, peak_m_s2), go_on)?;
    Some(Tried { peak_m_s2, found })
}

/// Simulates the gripper under a motion of its palm, and for a while after it is over.
pub(super) fn under(
    model: Model,
    prepared: &Prepared,
    load: Load,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Option<Result<Found, String>> {
    let duration_s = load.over_s + AFTER_S;
    let scene = prepared.scene.moved_by(Some(load.motion), duration_s);
    let mut tracker = GraspTracker::of(&scene).carrying_from(prepared.stage.begins_s);
    let outcome = run(model, &scene, &mut tracker, go_on)?;
    Some(outcome.and_then(|outcome| {
        let criteria = tracker.criteria().ok_or("there is no sample")?;
        Ok(Found {
            fate: criteria.fate,
            // Without it the object was gone before: then the fate says so.
            slip: criteria.cycle.carried.unwrap_or_default(),
            brake_slip_rad: criteria.cycle.brake_slip_rad.into_iter().flatten().fold(0.0, f64::max),
            end_s: outcome.last.time_s,
            steps: outcome.work.steps,
        })
    }))
}
