//! A gripper under loads on its palm.

use super::load::Load;
use super::plan::{HoldError, LoadOutcome, Plan, SETTLING_S};
use super::prepare::{self, PreparedScene};
use crate::criteria::ObjectTracker;
use crate::grasp::run;
use crate::scene::Scene;
use crate::trace::{Model, Sample};
use phalanx_parallel::{ComputeError, Monitor};

/// A gripper that is prepared for loads, with its state at their start.
pub(super) struct PreparedGripper {
    pub prepared: PreparedScene,
    pub at_start: Sample,
}

/// Prepares the scene of a gripper.
pub(super) fn prepare(scene: &Scene, plan: &Plan, monitor: &Monitor<'_>) -> Result<PreparedGripper, HoldError> {
    let prepared = prepare::prepare(scene, plan, monitor)?;
    let start = prepared.scene.with_palm_motion(Some(prepared.setup.prior_motion.clone()), prepared.setup.start_s);
    let at_start = prepare::run_scene(plan.model, &start, &mut ObjectTracker::for_scene(&start), monitor)?.last;
    Ok(PreparedGripper { prepared, at_start })
}

/// Simulates the gripper under a motion of its palm and for [`SETTLING_S`] afterwards. Returns the outcome, or the reason
/// why the run was not completed.
pub(super) fn simulate(
    model: Model,
    prepared: &PreparedScene,
    load: Load,
    monitor: &Monitor<'_>,
) -> Result<Result<LoadOutcome, String>, ComputeError> {
    let scene = prepared.scene.with_palm_motion(Some(load.motion), load.end_s + SETTLING_S);
    let tracker = ObjectTracker::for_scene(&scene);
    let mut tracker = tracker.map(|tracker| tracker.with_motion_start(prepared.setup.start_s));
    let outcome = run(model, &scene, &mut tracker, monitor.keep_running()).ok_or_else(|| monitor.stopped())?;
    Ok(outcome.and_then(|outcome| {
        let criteria = tracker.and_then(|tracker| tracker.criteria()).ok_or("there is no sample")?;
        Ok(LoadOutcome::new(&criteria, &outcome))
    }))
}
