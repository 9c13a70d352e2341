//! Offsets of the object of a mechanism that its hand captures: the object starts at offsets along x, along y or by an angle, in
//! the frame of the base of the grasp.
//!
//! Everything else is as in the scene. The object is *captured* if it is held at the end of the run
//! ([held](crate::criteria::Fate::Held)). Along one axis, bisection finds the edges of the captured range; along two axes, the
//! results are a map. An offset at which the object would start inside another outline is not simulated.

use phalanx_show::format::object::Object;
use serde::{Serialize, Serializer};

use crate::criteria::{Fate, ObjectTracker, Slip};
use crate::grasp::run;
use crate::mechanism::{Mechanism, Pose, assemble};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{rotate, sub};
use crate::scene::{Axis, Scene};
use crate::statics::{GraspRoles, NoGrasp};
use crate::study::bisect;
use crate::study::hold::axis_name;
use crate::trace::{BodyState, Model, Sample};
use phalanx_parallel::{ComputeError, Monitor, map};

/// Depth by which an object may start farther inside another outline than in the scene, m: there it may lie on a table.
const MAX_START_DEPTH_M: f64 = 1e-5;

/// Settings of a study of offsets.
#[derive(Clone, Debug, PartialEq)]
pub struct OffsetPlan {
    pub model: Model,
    /// One or two axes, each with the largest offset in either direction, m or rad.
    pub axes: Vec<(Axis, f64)>,
    /// Number of offsets along each axis, including both ends and zero. It must be odd and at least 3.
    pub count: usize,
    /// Tolerance of the edges for a single axis, m or rad.
    pub tolerance: f64,
}

/// Largest number of runs of a map.
const MAX_RUNS: usize = 10_000;

impl OffsetPlan {
    /// Checks the settings.
    ///
    /// # Errors
    /// Returns an error that names the invalid setting and the allowed values.
    pub fn check(&self) -> Result<(), String> {
        let OffsetPlan { axes, count, .. } = self;
        match axes[..] {
            [_] => {}
            [(a, _), (b, _)] if a != b => {}
            _ => {
                return Err(
                    "--along names one or two of x, y and angle, each once, such as --along x,angle".to_string()
                );
            }
        }
        let runs = count.pow(axes.len() as u32);
        if runs > MAX_RUNS {
            return Err(format!(
                "--places {count} along two axes are {runs} runs, but at most {MAX_RUNS} are allowed; give fewer"
            ));
        }
        Ok(())
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Offsets {
    pub scene: String,
    pub object: String,
    pub base: String,
    pub plan: OffsetPlan,
    /// Placements, ordered by the first axis, then by the second one.
    pub placements: Vec<OffsetPlacement>,
    /// The range about zero in which the object is captured. `None` for two axes, or if the object is not captured at
    /// zero.
    pub captured_range: Option<[OffsetEdge; 2]>,
}

/// One edge of the captured range, m or rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OffsetEdge {
    /// Outermost offset at which the object is captured.
    pub captured: f64,
    /// Nearest offset farther from zero than `captured` at which the object is not captured; `None` if the object is
    /// captured up to the largest offset.
    pub lost: Option<f64>,
}

/// An offset, and the outcome of its run. Figures are `None` if the run was not completed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OffsetPlacement {
    /// Offsets along x and y, m, and of the angle, rad.
    pub offset: Pose,
    pub fate: Option<&'static str>,
    pub fate_reason: Option<String>,
    /// Time to stability; `None` if the object is not held.
    pub tts_s: Option<f64>,
    /// Final pose of the object relative to the base.
    pub end: Option<Pose>,
    pub slip: Option<Slip>,
    pub steps: Option<u64>,
    /// Reason why the run was not completed; `None` if it was.
    pub reason: Option<String>,
}

impl OffsetPlacement {
    /// Whether the object is held at the end.
    pub(crate) fn is_captured(&self) -> bool {
        self.fate == Some(Fate::Held.name())
    }
}

impl Serialize for OffsetPlacement {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let [x, y, angle] = self.offset;
        let end = |axis: usize| self.end.map(|end| end[axis]);
        Object::default()
            .with("offset_x_m", x)
            .with("offset_y_m", y)
            .with("offset_angle_rad", angle)
            .with("fate", self.fate)
            .with("fate_reason", &self.fate_reason)
            .with("tts_s", self.tts_s)
            .with("x_m", end(0))
            .with("y_m", end(1))
            .with("angle_rad", end(2))
            .with("slip", self.slip)
            .with("steps", self.steps)
            .with("reason", &self.reason)
            .serialize(serializer)
    }
}

/// Serialises the study; an edge that is not reached is null.
impl Serialize for Offsets {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Offsets { scene, object, base, plan, placements, captured_range } = self;
        let axes: Vec<&str> = plan.axes.iter().map(|(axis, _)| axis_name(*axis)).collect();
        let largest: Vec<f64> = plan.axes.iter().map(|(_, largest)| *largest).collect();
        let edge = |index: usize| captured_range.map(|edges| edges[index]);
        let mut document = Object::default()
            .with("scene", scene)
            .with("model", plan.model.name())
            .with("object", object)
            .with("base", base)
            .with("along", axes)
            .with("largest", largest);
        if let [(axis, _)] = plan.axes[..] {
            let keys = match axis {
                Axis::Angle => ["captured_from_rad", "captured_to_rad", "lost_below_rad", "lost_above_rad"],
                Axis::X | Axis::Y => ["captured_from_m", "captured_to_m", "lost_below_m", "lost_above_m"],
            };
            document = document
                .with(keys[0], edge(0).map(|edge| edge.captured))
                .with(keys[1], edge(1).map(|edge| edge.captured))
                .with(keys[2], edge(0).and_then(|edge| edge.lost))
                .with(keys[3], edge(1).and_then(|edge| edge.lost));
        }
        document.with("places", placements).serialize(serializer)
    }
}

#[derive(Debug, thiserror::Error)]
pub enum OffsetError {
    #[error("the scene has no grasp: {0}")]
    NoGrasp(NoGrasp),
    #[error("the scene cannot start: {0}; check it with `phalanx scene check`")]
    Start(String),
    #[error(transparent)]
    Stopped(#[from] ComputeError),
}

/// The scene with the frame in which the object is placed.
struct Placing<'a> {
    scene: &'a Scene,
    mechanism: &'a Mechanism,
    roles: &'a GraspRoles,
    /// Poses of all bodies at the start.
    start: Vec<Pose>,
}

/// Simulates all offsets on all cores. For a single axis, it also locates the edges of the captured range. The monitor
/// counts the offsets.
///
/// # Errors
/// Returns an error if the scene has no grasp or cannot be assembled, or if the monitor stops the study.
///
/// # Panics
/// Panics if there is no axis.
pub fn offsets(plan: OffsetPlan, scene: &Scene, monitor: &Monitor<'_>) -> Result<Offsets, OffsetError> {
    let roles = scene.grasp_roles().map_err(OffsetError::NoGrasp)?;
    let mechanism = scene.mechanism.as_ref().ok_or(OffsetError::NoGrasp(NoGrasp::Nothing))?;
    let start = assemble(mechanism).map_err(|error| OffsetError::Start(error.to_string()))?.poses;
    let placing = Placing { scene, mechanism, roles: &roles, start };
    let half = (plan.count / 2) as f64;
    let along = |(axis, largest): (Axis, f64)| {
        let offset = move |index: usize| largest * ((index as f64 - half) / half);
        (0..plan.count).map(move |index| on_axis(axis, offset(index)))
    };
    let all: Vec<Pose> = match plan.axes[..] {
        [first] => along(first).collect(),
        [first, second, ..] => {
            let add = |a: Pose, b: Pose| std::array::from_fn(|axis| a[axis] + b[axis]);
            along(first).flat_map(|a| along(second).map(move |b| add(a, b))).collect()
        }
        [] => panic!("a study of offsets needs an axis"),
    };
    monitor.start(all.len(), "positions");
    let simulate = |offset: &Pose| {
        let placement = placing.simulate(plan.model, *offset, monitor)?;
        monitor.advance(1, "positions");
        Ok::<_, ComputeError>(placement)
    };
    let placements = map(0, &all, simulate)?;
    let middle = placements.len() / 2;
    let mut captured_range = None;
    if let [(axis, _)] = plan.axes[..]
        && placements[middle].is_captured()
    {
        let below: Vec<&OffsetPlacement> = placements[..=middle].iter().rev().collect();
        let above: Vec<&OffsetPlacement> = placements[middle..].iter().collect();
        let edge = |outward: &[&OffsetPlacement]| placing.edge(&plan, axis, outward, monitor);
        captured_range = Some([edge(&below)?, edge(&above)?]);
    }
    let name = |body: Option<usize>| mechanism.body_name(body).to_string();
    let (object, base) = (name(Some(roles.object)), name(roles.base));
    Ok(Offsets { scene: scene.name.clone(), object, base, plan, placements, captured_range })
}

/// An offset along one axis.
fn on_axis(axis: Axis, offset: f64) -> Pose {
    let mut all = [0.0; 3];
    all[axis as usize] = offset;
    all
}

impl Placing<'_> {
    /// Locates one edge of the captured range from placements ordered outward from zero, where the object is captured.
    fn edge(
        &self,
        plan: &OffsetPlan,
        axis: Axis,
        outward: &[&OffsetPlacement],
        monitor: &Monitor<'_>,
    ) -> Result<OffsetEdge, ComputeError> {
        let count = outward.iter().take_while(|placement| placement.is_captured()).count();
        let at = |placement: &OffsetPlacement| placement.offset[axis as usize];
        let captured = at(outward[count - 1]);
        let Some(lost) = outward.get(count) else { return Ok(OffsetEdge { captured, lost: None }) };
        let next =
            |captured: f64, lost: f64| ((lost - captured).abs() > plan.tolerance).then_some(0.5 * (captured + lost));
        let is_captured = |offset: f64| {
            Ok::<_, ComputeError>(self.simulate(plan.model, on_axis(axis, offset), monitor)?.is_captured())
        };
        let [captured, lost] = bisect([captured, at(lost)], next, is_captured)?;
        Ok(OffsetEdge { captured, lost: Some(lost) })
    }

    /// The scene with its object at an offset, or the reason why it cannot start there.
    fn scene_at(&self, [x, y, angle]: Pose) -> Result<Scene, String> {
        let (mut scene, mut start, object) = (self.scene.clone(), self.start.clone(), self.roles.object);
        let [.., turn] = self.roles.base.map_or([0.0; 3], |base| start[base]);
        let (sin, cos) = sin_cos(turn);
        let [dx, dy] = rotate([x, y], [cos, sin]);
        let Some(mechanism) = &mut scene.mechanism else { return Err(NoGrasp::Nothing.to_string()) };
        let place = |pose: &mut Pose| *pose = [pose[0] + dx, pose[1] + dy, pose[2] + angle];
        place(&mut mechanism.bodies[object].pose);
        place(&mut start[object]);
        let own = mechanism.deep_overlaps(&self.start, 0.0);
        let is_deeper = |(index, depth_m): &(usize, f64)| {
            let pair = &mechanism.contacts[*index];
            let own_m = own.iter().find(|(other, _)| other == index).map_or(0.0, |(_, depth_m)| *depth_m);
            [pair.points.body, pair.face.body].contains(&Some(object)) && *depth_m > own_m + MAX_START_DEPTH_M
        };
        match mechanism.deep_overlaps(&start, MAX_START_DEPTH_M).into_iter().find(is_deeper) {
            None => Ok(scene),
            Some((index, depth_m)) => {
                let pair = &mechanism.contacts[index];
                let other = if pair.points.body == Some(object) { pair.face } else { pair.points };
                let (name, depth) = (mechanism.outline_name(other), depth_m * 1e3);
                Err(format!("the object starts {depth:.3} mm inside `{name}`"))
            }
        }
    }

    /// Simulates the scene with its object at an offset.
    fn simulate(&self, model: Model, offset: Pose, monitor: &Monitor<'_>) -> Result<OffsetPlacement, ComputeError> {
        let not_run = |reason: String| OffsetPlacement { offset, reason: Some(reason), ..OffsetPlacement::default() };
        let scene = match self.scene_at(offset) {
            Ok(scene) => scene,
            Err(reason) => return Ok(not_run(reason)),
        };
        let Some(mut tracker) = ObjectTracker::for_scene(&scene) else {
            return Ok(not_run(NoGrasp::Nothing.to_string()));
        };
        let outcome = run(model, &scene, &mut tracker, monitor.keep_running()).ok_or_else(|| monitor.stopped())?;
        let found = outcome.and_then(|outcome| Ok((tracker.criteria().ok_or("the run has no samples")?, outcome)));
        Ok(match found {
            Err(reason) => not_run(reason),
            Ok((criteria, outcome)) => OffsetPlacement {
                offset,
                fate: Some(criteria.fate.name()),
                fate_reason: Some(criteria.reason),
                tts_s: criteria.tts_s,
                end: Some(self.relative_pose(&criteria.end)),
                slip: criteria.slip,
                steps: Some(outcome.work.steps),
                reason: None,
            },
        })
    }

    /// Pose of the object relative to the base in a sample.
    fn relative_pose(&self, sample: &Sample) -> Pose {
        let palm = self.mechanism.palm().map(|(palm, _)| palm);
        let state = |body: usize| {
            self.mechanism.reported_index(body).map_or_else(BodyState::default, |index| sample.body(index))
        };
        let object = state(self.roles.object);
        // Samples are relative to a base that moves by prescription.
        let base = self.roles.base.filter(|base| Some(*base) != palm).map_or_else(BodyState::default, state);
        let (sin, cos) = sin_cos(base.angle_rad);
        let [x, y] = rotate(sub(object.centre_m, base.centre_m), [cos, -sin]);
        [x, y, object.angle_rad - base.angle_rad]
    }
}
