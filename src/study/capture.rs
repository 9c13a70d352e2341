//! Positioning errors that a gripper captures (thesis §4.2.1.3): its object is placed at increasing offsets from the
//! middle of the palm.
//!
//! Motors, springs and initial postures are those of one gripper, designed for the largest error; only the position of
//! the object varies. The object is *captured* if it is held at the end of the run
//! ([held](crate::criteria::Fate::Held)). The results also answer an open question of the thesis: whether the grasp
//! would be form-closed if the object did not move, and whether the final grasp is.

use phalanx_show::format::object::Object;
use serde::{Serialize, Serializer};

use crate::criteria::{Fate, ObjectTracker, Slip, is_form_closed};
use crate::grasp::{geometric_posture, run};
use crate::scene::{Layer, Scene, SceneError, Side, parse_layers};
use crate::statics::{Blocked, GraspConfiguration, PerContact, gripper_closure};
use crate::study::bisect;
use crate::study::sweep::problem_messages;
use crate::trace::Model;
use crate::units::{self, Dimension};
use phalanx_parallel::{ComputeError, Monitor, map};

/// Settings of a capture study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    pub model: Model,
    /// Largest positioning error in either direction, m.
    pub error_m: f64,
    /// Number of positions over the range, including both ends and the middle. It must be odd and at least 3.
    pub position_count: usize,
    /// Tolerance of the edges, m.
    pub tolerance_m: f64,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    pub scene: String,
    pub plan: Plan,
    pub palm_width_m: f64,
    /// Placements from left to right.
    pub placements: Vec<ObjectPlacement>,
    /// The range about the middle in which the object is captured; `None` if it is not captured in the middle.
    pub captured_range: Option<[Edge; 2]>,
}

/// One edge of the captured range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Outermost offset at which the object is captured, m.
    pub captured_m: f64,
    /// Nearest offset farther from the middle than `captured_m` at which the object is not captured, m; `None` if the
    /// object is captured up to the largest positioning error.
    pub lost_m: Option<f64>,
}

/// A position of the object, and the outcome of its run. Figures are `None` if the run was not completed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ObjectPlacement {
    /// Initial x of the centre of the object, m.
    pub offset_m: f64,
    /// Whether the grasp of the object at this position by all four phalanges and the palm is form-closed. `None` if
    /// the fingers cannot reach the object.
    #[serde(rename = "form_closed_there")]
    pub geometric_form_closed: Option<bool>,
    pub fate: Option<&'static str>,
    /// Time to stability, s; `None` if the object is not held.
    pub tts_s: Option<f64>,
    /// Final x of the centre of the object, m.
    pub x_m: Option<f64>,
    /// Final y of the centre of the object, m.
    pub y_m: Option<f64>,
    /// Final angle of the object, rad.
    pub angle_rad: Option<f64>,
    /// Final speed of the object, m/s.
    pub speed_m_s: Option<f64>,
    pub slip: Option<Slip>,
    /// Whether the contacts that are active at the end form-close the object; `None` if the object is not held.
    pub form_closed: Option<bool>,
    pub steps: Option<u64>,
    /// Reason why the run was not completed; `None` if it was.
    pub reason: Option<String>,
}

impl ObjectPlacement {
    /// Whether the object is held at the end.
    pub(crate) fn is_captured(&self) -> bool {
        self.fate == Some(Fate::Held.name())
    }
}

/// Serialises the study; a `lost` edge is null if the object is captured up to the largest error.
impl Serialize for Capture {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let [left, right] = [0, 1].map(|index| self.captured_range.map(|edges| edges[index]));
        Object::default()
            .with("scene", &self.scene)
            .with("model", self.plan.model.name())
            .with("palm_width_m", self.palm_width_m)
            .with("positioning_error_m", self.plan.error_m)
            .with("captured_from_m", left.map(|edge| edge.captured_m))
            .with("captured_to_m", right.map(|edge| edge.captured_m))
            .with("lost_left_m", left.and_then(|edge| edge.lost_m))
            .with("lost_right_m", right.and_then(|edge| edge.lost_m))
            .with("places", &self.placements)
            .serialize(serializer)
    }
}

#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Stopped(#[from] ComputeError),
}

/// Texts of a scene, and additional settings that override them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneSource {
    pub layers: Vec<Layer>,
    pub settings: Vec<Layer>,
}

impl SceneSource {
    /// Loads the gripper designed for the largest error of a plan, with its object `offset_m` from the middle of the
    /// palm.
    fn load_at_offset(&self, plan: &Plan, offset_m: f64) -> Result<Scene, SceneError> {
        let setting = |key: &str, value_m: f64| Layer {
            file: "the study".to_string(),
            text: format!("{key} = \"{}\"", units::format(value_m, Dimension::Length)),
        };
        let added = [setting("positioning_error", plan.error_m), setting("object.offset", offset_m)];
        let scene = parse_layers(&self.layers, &[&self.settings[..], &added].concat())?;
        match scene.finger_count() {
            2 => Ok(scene),
            _ => {
                let file = self.layers.last().map(|layer| layer.file.clone()).unwrap_or_default();
                Err(SceneError::Read { file, reason: "it is not a gripper (kind = \"gripper\")".to_string() })
            }
        }
    }
}

/// Simulates all positions on all cores and locates the edges of the captured range. The monitor counts the positions.
///
/// # Errors
/// Returns an error if the scene is invalid in the middle or at either end, if it is not a gripper, or if the monitor
/// stops the study.
pub fn capture(plan: Plan, source: &SceneSource, monitor: &Monitor<'_>) -> Result<Capture, CaptureError> {
    let middle = source.load_at_offset(&plan, 0.0)?;
    for end in [-plan.error_m, plan.error_m] {
        source.load_at_offset(&plan, end)?;
    }
    let half = (plan.position_count / 2) as f64;
    let offsets: Vec<f64> =
        (0..plan.position_count).map(|index| plan.error_m * ((index as f64 - half) / half)).collect();
    monitor.start(offsets.len(), "positions");
    let simulate = |offset_m: &f64| {
        let placement = simulate_placement(&plan, *offset_m, source, monitor)?;
        monitor.advance(1, "positions");
        Ok::<_, ComputeError>(placement)
    };
    let placements = map(0, &offsets, simulate)?;
    let middle_index = placements.len() / 2;
    let mut captured_range = None;
    if placements[middle_index].is_captured() {
        let left: Vec<&ObjectPlacement> = placements[..=middle_index].iter().rev().collect();
        let right: Vec<&ObjectPlacement> = placements[middle_index..].iter().collect();
        captured_range = Some([find_edge(&plan, &left, source, monitor)?, find_edge(&plan, &right, source, monitor)?]);
    }
    Ok(Capture { scene: middle.name, plan, palm_width_m: middle.hand.palm_width_m, placements, captured_range })
}

/// Locates one edge of the captured range from placements ordered outward from the middle, where the object is captured.
fn find_edge(
    plan: &Plan,
    outward: &[&ObjectPlacement],
    source: &SceneSource,
    monitor: &Monitor<'_>,
) -> Result<Edge, ComputeError> {
    let captured = outward.iter().take_while(|placement| placement.is_captured()).count();
    let captured_m = outward[captured - 1].offset_m;
    let Some(lost) = outward.get(captured) else {
        return Ok(Edge { captured_m, lost_m: None });
    };
    let next =
        |captured: f64, lost: f64| ((lost - captured).abs() > plan.tolerance_m).then_some(0.5 * (captured + lost));
    let is_captured =
        |offset_m| Ok::<_, ComputeError>(simulate_placement(plan, offset_m, source, monitor)?.is_captured());
    let [captured_m, lost_m] = bisect([captured_m, lost.offset_m], next, is_captured)?;
    Ok(Edge { captured_m, lost_m: Some(lost_m) })
}

/// Simulates the gripper with its object at an offset.
fn simulate_placement(
    plan: &Plan,
    offset_m: f64,
    source: &SceneSource,
    monitor: &Monitor<'_>,
) -> Result<ObjectPlacement, ComputeError> {
    let scene = match source.load_at_offset(plan, offset_m) {
        Ok(scene) => scene,
        Err(error) => {
            return Ok(ObjectPlacement {
                offset_m,
                reason: Some(problem_messages(&error)),
                ..ObjectPlacement::default()
            });
        }
    };
    let mut tracker = ObjectTracker::for_scene(&scene);
    let outcome = run(plan.model, &scene, &mut tracker, monitor.keep_running()).ok_or_else(|| monitor.stopped())?;
    let geometric_form_closed = geometric_form_closed(&scene);
    let found = outcome.and_then(|outcome| {
        let criteria = tracker.and_then(|tracker| tracker.criteria());
        Ok((criteria.ok_or("the run has no samples")?, outcome))
    });
    let (criteria, outcome) = match found {
        Ok(found) => found,
        Err(reason) => {
            return Ok(ObjectPlacement {
                offset_m,
                geometric_form_closed,
                reason: Some(reason),
                ..ObjectPlacement::default()
            });
        }
    };
    Ok(ObjectPlacement {
        offset_m,
        geometric_form_closed,
        fate: Some(criteria.fate.name()),
        tts_s: criteria.tts_s,
        x_m: Some(criteria.last.centre_m[0]),
        y_m: Some(criteria.last.centre_m[1]),
        angle_rad: Some(criteria.last.angle_rad),
        speed_m_s: Some(criteria.end_speed_m_s()),
        slip: criteria.slip,
        form_closed: is_form_closed(&scene, &criteria.end).filter(|_| criteria.fate == Fate::Held),
        steps: Some(outcome.work.steps),
        reason: None,
    })
}

/// Form closure of the geometric grasp of the object at its initial position.
fn geometric_form_closed(scene: &Scene) -> Option<bool> {
    let configuration = GraspConfiguration {
        fingers: Side::BOTH.map(|side| &scene.hand.finger(side).linkage),
        angles_rad: geometric_posture(scene).ok()?,
        palm_width_m: scene.hand.palm_width_m,
        object: scene.hand.grasped().placed(),
    };
    let in_contact = PerContact { phalanges: [[true; 2]; 2], palm: scene.hand.palm.is_some() };
    let blocked = if scene.hand.differential.is_some() { Blocked::Input } else { Blocked::Outputs };
    gripper_closure(&configuration, &in_contact, blocked).ok().map(|closure| closure.closed)
}
