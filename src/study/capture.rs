//! Positioning errors that a gripper captures (thesis §4.2.1.3): its object is placed at increasing offsets from the
//! middle of the palm.
//!
//! Motors, springs and initial postures are those of one gripper, designed for the largest error; only the position of
//! the object varies. The object is *captured* if it is held at the end of the run
//! ([held](crate::criteria::Fate::Held)). The results also answer an open question of the thesis: whether the grasp
//! would be form-closed if the object did not move, and whether the final grasp is.

use std::sync::atomic::{AtomicU64, Ordering};

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::criteria::{Fate, GraspCriteria, GraspTracker, is_form_closed};
use crate::grasp::{geometric_posture, run};
use crate::scene::keywords::SceneKind;
use crate::scene::{Layer, Scene, SceneError, Side, parse_any, parse_layers};
use crate::statics::{Blocked, GraspConfiguration, PerContact, gripper_closure};
use crate::study::sweep::problem_messages;
use crate::study::{bisect, pool};
use crate::trace::Model;
use crate::units::{self, Dimension};

/// Settings of a capture study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    pub model: Model,
    /// Largest positioning error in either direction, m.
    pub error_m: f64,
    /// Number of positions over the range including both ends and the middle: odd, at least 3.
    pub position_count: usize,
    /// Tolerance of the edges, m.
    pub tolerance_m: f64,
}

/// Result of a capture study.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    pub scene: String,
    pub plan: Plan,
    pub palm_width_m: f64,
    /// Placements from left to right.
    pub placements: Vec<Placement>,
    /// The range about the middle in which the object is captured; `None` if it is not captured in the middle.
    pub captured_range: Option<[Edge; 2]>,
}

/// One edge of the captured range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Outermost offset at which the object is captured, m.
    pub captured_m: f64,
    /// Nearest offset farther out at which it is not captured, m; `None` if it is captured at the largest error.
    pub lost_m: Option<f64>,
}

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
#[derive(Clone, Debug, PartialEq)]
pub struct RunOutcome {
    /// Fate, time to stability, final state and slip of the object.
    pub criteria: GraspCriteria,
    /// Form closure by the contacts active at the end; `None` if the object is not held.
    pub form_closed: Option<bool>,
    pub steps: u64,
}

impl Placement {
    /// Whether the object is held at the end.
    pub(crate) fn is_captured(&self) -> bool {
        self.outcome.as_ref().is_ok_and(|outcome| outcome.criteria.fate == Fate::Held)
    }
}

/// Serialises the study; a `lost` edge is null if the object is captured up to the largest error.
impl Serialize for Capture {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let [left, right] = [0, 1].map(|index| self.captured_range.map(|edges| edges[index]));
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("scene", &self.scene)?;
        map.serialize_entry("model", self.plan.model.name())?;
        map.serialize_entry("palm_width_m", &self.palm_width_m)?;
        map.serialize_entry("positioning_error_m", &self.plan.error_m)?;
        map.serialize_entry("captured_from_m", &left.map(|edge| edge.captured_m))?;
        map.serialize_entry("captured_to_m", &right.map(|edge| edge.captured_m))?;
        map.serialize_entry("lost_left_m", &left.and_then(|edge| edge.lost_m))?;
        map.serialize_entry("lost_right_m", &right.and_then(|edge| edge.lost_m))?;
        map.serialize_entry("places", &self.placements)?;
        map.end()
    }
}

/// Serialises the figures of a placement; they are null if the run was not completed, for a `reason`.
impl Serialize for Placement {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let found = self.outcome.as_ref().ok();
        let criteria = found.map(|found| &found.criteria);
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("offset_m", &self.offset_m)?;
        map.serialize_entry("form_closed_there", &self.geometric_form_closed)?;
        map.serialize_entry("fate", &criteria.map(|found| found.fate.name()))?;
        map.serialize_entry("tts_s", &criteria.and_then(|found| found.tts_s))?;
        map.serialize_entry("x_m", &criteria.map(|found| found.end.centre_m[0]))?;
        map.serialize_entry("y_m", &criteria.map(|found| found.end.centre_m[1]))?;
        map.serialize_entry("angle_rad", &criteria.map(|found| found.end.angle_rad))?;
        map.serialize_entry("speed_m_s", &criteria.map(GraspCriteria::end_speed_m_s))?;
        map.serialize_entry("slip", &criteria.and_then(|found| found.slip))?;
        map.serialize_entry("form_closed", &found.and_then(|found| found.form_closed))?;
        map.serialize_entry("steps", &found.map(|found| found.steps))?;
        map.serialize_entry("reason", &self.outcome.as_ref().err())?;
        map.end()
    }
}

/// Error during a capture study.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error("interrupted after {done} of {total} positions")]
    Stopped { done: u64, total: u64 },
}

/// Loads the scene with its object at an offset, designed for the largest error of the plan.
pub(crate) type SceneLoader<'a> = &'a (dyn Fn(f64) -> Result<Scene, SceneError> + Sync);

/// Texts of a scene and additional settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneSource {
    pub layers: Vec<Layer>,
    pub settings: Vec<Layer>,
}

impl SceneSource {
    /// Loads the gripper designed for errors up to `error_m`, with its object `offset_m` from the middle of the palm.
    ///
    /// # Errors
    /// Returns an error if the scene is invalid with these values, or is not a gripper.
    pub fn load_at_offset(&self, error_m: f64, offset_m: f64) -> Result<Scene, SceneError> {
        let setting = |key: &str, value_m: f64| Layer {
            file: "the study".to_string(),
            text: format!("{key} = \"{}\"", units::format(value_m, Dimension::Length)),
        };
        let added = [setting("positioning_error", error_m), setting("object.offset", offset_m)];
        let settings: Vec<Layer> = self.settings.iter().cloned().chain(added).collect();
        let scene = parse_layers(&self.layers, &settings, parse_any)?;
        match scene.kind() {
            SceneKind::Gripper => Ok(scene),
            _ => {
                let file = self.layers.last().map(|scene_layer| scene_layer.file.clone()).unwrap_or_default();
                Err(SceneError::Read { file, reason: "it is not a gripper (kind = \"gripper\")".to_string() })
            }
        }
    }
}

/// Simulates all positions on all cores and locates the edges. `on_progress` is called with the number of finished
/// positions and the total.
///
/// # Errors
/// Returns an error if the scene is invalid in the middle or at either end, or `keep_running` returned false.
pub fn capture(
    plan: Plan,
    load: SceneLoader<'_>,
    on_progress: &mut (dyn FnMut(u64, u64) + Send),
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<Capture, CaptureError> {
    let middle = load(0.0)?;
    for end in [-plan.error_m, plan.error_m] {
        load(end)?;
    }
    let half = (plan.position_count / 2) as f64;
    let offsets: Vec<f64> =
        (0..plan.position_count).map(|index| plan.error_m * ((index as f64 - half) / half)).collect();
    let (total, done) = (offsets.len() as u64, AtomicU64::new(0));
    let results = pool::map(
        0,
        &offsets,
        |offset_m, messages| {
            let placement = simulate_placement(plan.model, *offset_m, load, keep_running);
            // The receiver may have been dropped.
            let _ = messages.send(done.fetch_add(1, Ordering::Relaxed) + 1);
            placement
        },
        |finished| on_progress(finished, total),
    );
    let interrupted = || CaptureError::Stopped { done: done.load(Ordering::Relaxed), total };
    let placements: Vec<Placement> = results.into_iter().collect::<Option<_>>().ok_or_else(interrupted)?;
    let middle_index = placements.len() / 2;
    let outward = [placements[..=middle_index].iter().rev().collect(), placements[middle_index..].iter().collect()];
    let edges = outward.map(|outward: Vec<&Placement>| find_edge(&plan, &outward, load, keep_running));
    let captured_range = match (edges, placements[middle_index].is_captured()) {
        (_, false) => None,
        ([Some(left), Some(right)], true) => Some([left, right]),
        _ => return Err(interrupted()),
    };
    Ok(Capture { scene: middle.name, plan, palm_width_m: middle.system.palm_width_m, placements, captured_range })
}

/// Locates one edge of the captured range from placements ordered outward from the middle; `None` if interrupted.
fn find_edge(
    plan: &Plan,
    outward: &[&Placement],
    load: SceneLoader<'_>,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Edge> {
    let captured = outward.iter().take_while(|placement| placement.is_captured()).count();
    let captured_m = captured.checked_sub(1).map_or(0.0, |last| outward[last].offset_m);
    let Some(lost) = outward.get(captured).filter(|_| captured > 0) else {
        return Some(Edge { captured_m, lost_m: None });
    };
    let next =
        |captured: f64, lost: f64| ((lost - captured).abs() > plan.tolerance_m).then_some(0.5 * (captured + lost));
    let is_captured = |offset_m| Some(simulate_placement(plan.model, offset_m, load, keep_running)?.is_captured());
    let [captured_m, lost_m] = bisect([captured_m, lost.offset_m], next, is_captured)?;
    Some(Edge { captured_m, lost_m: Some(lost_m) })
}

/// Simulates the gripper with its object at an offset; `None` if it was interrupted.
fn simulate_placement(
    model: Model,
    offset_m: f64,
    load: SceneLoader<'_>,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Placement> {
    let scene = match load(offset_m) {
        Ok(scene) => scene,
        Err(error) => {
            return Some(Placement { offset_m, geometric_form_closed: None, outcome: Err(problem_messages(&error)) });
        }
    };
    let mut tracker = GraspTracker::for_scene(&scene);
    let outcome = run(model, &scene, &mut tracker, keep_running)?.and_then(|outcome| {
        let criteria = tracker.criteria().ok_or("the run has no samples")?;
        let form_closed = is_form_closed(&scene, &outcome.last).filter(|_| criteria.fate == Fate::Held);
        Ok(RunOutcome { criteria, form_closed, steps: outcome.work.steps })
    });
    Some(Placement { offset_m, geometric_form_closed: geometric_form_closed(&scene), outcome })
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
