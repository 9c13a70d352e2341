//! Runs a capture study's scene with the object at one position.

use super::SceneLoader;
use crate::criteria::{Fate, GraspCriteria, GraspTracker, Travel, is_form_closed};
use crate::grasp::geometric_posture;
use crate::grasp::run;
use crate::scene::{Scene, Side};
use crate::statics::{Blocked, GraspConfiguration, PerContact, gripper_closure};
use crate::trace::Model;

/// A position of the object and the outcome of its run.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// x of the centre of the object at the start, m.
    pub offset_m: f64,
    /// Whether the grasp of the object at this position by all four phalanges and the palm is form-closed; `None` if
    /// the fingers cannot reach it.
    pub geometric_form_closed: Option<bool>,
    /// Outcome, or the reason why there is none.
    pub outcome: Result<RunOutcome, String>,
}

/// Outcome of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunOutcome {
    pub fate: Fate,
    pub tts_s: Option<f64>,
    /// Position of the object at the end, m.
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
    pub speed_m_s: f64,
    /// Slip after the time from which the object is held to the end.
    pub slip: Option<Travel>,
    /// Form closure by the contacts active at the end; `None` if the object is not held.
    pub form_closed: Option<bool>,
    pub end_s: f64,
    pub steps: u64,
}

impl Placement {
    /// Whether the object is held at the end.
    pub fn is_captured(&self) -> bool {
        self.outcome.as_ref().is_ok_and(|outcome| outcome.fate == Fate::Held)
    }
}

/// Simulates the gripper with its object at an offset; `None` if it was interrupted.
pub(super) fn simulate_placement(
    model: Model,
    offset_m: f64,
    load: SceneLoader<'_>,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Placement> {
    let mut placement = Placement { offset_m, geometric_form_closed: None, outcome: Err(String::new()) };
    let scene = match load(offset_m) {
        Ok(scene) => scene,
        Err(error) => {
            let messages: Vec<&str> = error.problems().iter().map(|problem| problem.message.as_str()).collect();
            placement.outcome = Err(if messages.is_empty() { error.to_string() } else { messages.join("; ") });
            return Some(placement);
        }
    };
    placement.geometric_form_closed = geometric_form_closed(&scene);
    let mut tracker = GraspTracker::for_scene(&scene);
    placement.outcome = run(model, &scene, &mut tracker, keep_running)?.and_then(|outcome| {
        let criteria = tracker.criteria().ok_or("the run has no samples")?;
        let GraspCriteria { fate, tts_s, end, slip, .. } = &criteria;
        Ok(RunOutcome {
            fate: *fate,
            tts_s: *tts_s,
            centre_m: end.centre_m,
            angle_rad: end.angle_rad,
            speed_m_s: criteria.end_speed_m_s(),
            slip: *slip,
            form_closed: is_form_closed(&scene, &outcome.last).filter(|_| *fate == Fate::Held),
            end_s: outcome.last.time_s,
            steps: outcome.work.steps,
        })
    });
    Some(placement)
}

/// Form closure of the geometric grasp of the object at its initial position.
fn geometric_form_closed(scene: &Scene) -> Option<bool> {
    let configuration = GraspConfiguration {
        fingers: Side::BOTH.map(|side| &scene.system.finger(side).linkage),
        angles_rad: geometric_posture(scene).ok()?,
        palm_width_m: scene.system.palm_width_m,
        object: scene.system.grasped().placed(),
    };
    let in_contact = PerContact { phalanges: [[true; 2]; 2], palm: scene.system.palm.is_some() };
    let blocked = if scene.system.differential.is_some() { Blocked::Input } else { Blocked::Outputs };
    gripper_closure(&configuration, &in_contact, blocked).ok().map(|closure| closure.closed)
}
