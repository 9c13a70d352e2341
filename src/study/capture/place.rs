//! One place of the object.

use super::Load;
use crate::criteria::{Fate, GraspCriteria, GraspTracker, Travel, is_form_closed};
use crate::gripper::{Circle, final_posture};
use crate::scene::{GripperScene, LogRates, Side};
use crate::statics::{Blocked, PerContact, Stance, gripper_closure};
use crate::trace::{self, Model, RunError};
use crate::validate::While;

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
        // The criteria follow the steps: a grid between them would only cost.
        Ok(scene) => GripperScene { log: LogRates { numeric_hz: 1.0 / scene.duration_s, ..scene.log }, ..scene },
        Err(error) => {
            let messages: Vec<&str> = error.problems().iter().map(|problem| problem.message.as_str()).collect();
            placed.found = Err(if messages.is_empty() { error.to_string() } else { messages.join("; ") });
            return Some(placed);
        }
    };
    placed.closed_there = closed_there(&scene);
    let mut tracker = GraspTracker::of(&scene);
    placed.found = match trace::run(model, &scene, &mut While { sink: &mut tracker, go_on }) {
        Ok(outcome) => tracker.criteria().map_or(Err("there is no sample".to_string()), |criteria| {
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
        }),
        Err(error) if error.is_stop() => return None,
        Err(RunError::Simulation { failure, .. }) => Err(failure.to_string()),
        Err(RunError::Sink(error)) => Err(error.to_string()),
    };
    Some(placed)
}

/// Form closure of the geometric grasp of an object that does not move.
fn closed_there(scene: &GripperScene) -> Option<bool> {
    let [x, y] = scene.object.centre_m;
    let radius_m = scene.object.radius_m;
    let mut angles_rad = [[0.0; 2]; 2];
    for side in Side::BOTH {
        let finger = &scene.finger(side).finger;
        let disc = Circle { radius_m, centre_m: [side.mirror() * x - 0.5 * scene.palm_width_m, y] };
        let end = final_posture(&finger.lengths, finger.assembly, disc).ok()?;
        angles_rad[side as usize] = [end.posture.q11_rad, end.posture.q21_rad];
    }
    let stance = Stance {
        fingers: Side::BOTH.map(|side| &scene.finger(side).finger),
        angles_rad,
        palm_width_m: scene.palm_width_m,
        object: Circle { radius_m, centre_m: [x, y] },
    };
    let touching = PerContact { phalanges: [[true; 2]; 2], palm: scene.palm.is_some() };
    let blocked = if scene.differential.is_some() { Blocked::Input } else { Blocked::Outputs };
    gripper_closure(&stance, &touching, blocked).ok().map(|found| found.closed)
}
