//! One place of the object.

use super::Load;
use crate::criteria::{Fate, GraspCriteria, GraspTracker, Travel, is_form_closed};
use crate::grasp::geometric;
use crate::grasp::run;
use crate::scene::{Scene, Side};
use crate::statics::{Blocked, PerContact, Stance, gripper_closure};
use crate::trace::Model;

/// The object at a place, and what came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// x of its centre at the start.
    pub offset_m: f64,
    /// Whether the grasp would be form-closed if the object stayed there, all four phalanges and the palm touching it; `None` where the
    /// fingers cannot reach around it so.
    pub closed_there: Option<bool>,
    /// Or why there is nothing.
    pub found: Result<Found, String>,
}

/// What a run came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    pub fate: Fate,
    pub tts_s: Option<f64>,
    /// The object at the end.
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
    pub speed_m_s: f64,
    /// Since it is held for good.
    pub slip: Option<Travel>,
    /// Of the contacts that press at the end, where the object is held.
    pub form_closed: Option<bool>,
    pub end_s: f64,
    pub steps: u64,
}

impl Placed {
    pub fn is_captured(&self) -> bool {
        self.found.as_ref().is_ok_and(|found| found.fate == Fate::Held)
    }
}

/// Simulates the gripper with its object at a place; `None` if it was told to stop.
pub(super) fn place(model: Model, offset_m: f64, load: Load<'_>, go_on: &(dyn Fn() -> bool + Sync)) -> Option<Placed> {
    let mut placed = Placed { offset_m, closed_there: None, found: Err(String::new()) };
    let scene = match load(offset_m) {
        Ok(scene) => scene,
        Err(error) => {
            let messages: Vec<&str> = error.problems().iter().map(|problem| problem.message.as_str()).collect();
            placed.found = Err(if messages.is_empty() { error.to_string() } else { messages.join("; ") });
            return Some(placed);
        }
    };
    placed.closed_there = closed_there(&scene);
    let mut tracker = GraspTracker::of(&scene);
    placed.found = run(model, &scene, &mut tracker, go_on)?.and_then(|outcome| {
        let criteria = tracker.criteria().ok_or("there is no sample")?;
        let GraspCriteria { fate, tts_s, end, slip, .. } = &criteria;
        Ok(Found {
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
    Some(placed)
}

/// Form closure of the geometric grasp of an object that does not move.
fn closed_there(scene: &Scene) -> Option<bool> {
    let stance = Stance {
        fingers: Side::BOTH.map(|side| &scene.system.finger(side).linkage),
        angles_rad: geometric(scene).ok()?,
        palm_width_m: scene.system.palm_width_m,
        object: scene.system.grasped().placed(),
    };
    let touching = PerContact { phalanges: [[true; 2]; 2], palm: scene.system.palm.is_some() };
    let blocked = if scene.system.differential.is_some() { Blocked::Input } else { Blocked::Outputs };
    gripper_closure(&stance, &touching, blocked).ok().map(|found| found.closed)
}
