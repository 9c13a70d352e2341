//! Preparation of a scene for loads: start time, motion and fixed drives, and what limits the loads at their start.

use std::convert::Infallible;

use serde::Serialize;

use super::base::REST_SPEED_M_S;
use super::load::{Load, LoadCase, LoadSetup, moves_start, peak_acceleration, rescale};
use super::plan::{HoldError, Loads, Plan};
use crate::criteria::{Fate, ObjectTracker};
use crate::grasp::{DriveMode, grasp_state, gripper_at_rest, run};
use crate::numeric::elementary::{hypot, sin_cos};
use crate::scene::{Axis, Cycle, Motor, Move, ObjectMotion, PalmMotion, Profile, Scene};
use crate::shape::support;
use crate::statics::{MechanismLimit, mechanism_balance_towards};
use crate::study::bisect;
use crate::trace::{Event, Model, Outcome, RequiredData, Sample, Sink, SinkError};
use phalanx_parallel::Monitor;

/// Reason for the start time of the loads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum StartReason {
    /// The start time was requested.
    #[serde(rename = "given")]
    Requested,
    /// All holding contacts are closed, the brakes are engaged, and the object stays slower than `REST_SPEED_M_S`.
    #[serde(rename = "at rest")]
    AtRest,
    /// The scene ends while the object still moves.
    #[serde(rename = "still moving")]
    StillMoving,
    /// The first of the scene's moves has ended and the brakes are engaged.
    #[serde(rename = "moved")]
    MoveCompleted,
    /// The scene's first own move starts.
    #[serde(rename = "own move")]
    OwnMove,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct PreparedScene {
    /// Scene without motion of the palm, whose drives are fixed from the start of the loads on.
    pub scene: Scene,
    pub setup: LoadSetup,
    pub start_reason: StartReason,
}

/// Runs a scene without a load to its end.
pub(super) fn run_scene(
    model: Model,
    scene: &Scene,
    sink: &mut impl Sink,
    monitor: &Monitor<'_>,
) -> Result<Outcome, HoldError> {
    let outcome = run(model, scene, sink, monitor.keep_running()).ok_or_else(|| monitor.stopped())?;
    outcome.map_err(|reason| HoldError::Scene { reason })
}

/// Standard pick-and-place cycle of robots, 25/305/25 mm, as in scenes/gripper/cycle.toml, with this direction upwards.
pub(super) fn standard_cycle([ux, uy]: [f64; 2]) -> PalmMotion {
    let segments = [([ux, uy], 0.025, 0.0, 0.06), ([-uy, ux], 0.305, 0.05, 0.2), ([ux, uy], -0.025, 0.24, 0.08)];
    let along = |([x, y], distance, start_s, length_s): ([f64; 2], f64, f64, f64)| {
        let parts = [(Axis::X, x), (Axis::Y, y)].into_iter().filter(|(_, part)| *part != 0.0);
        parts.map(move |(axis, part)| Move { axis, distance: part * distance, start_s, length_s })
    };
    PalmMotion { moves: segments.into_iter().flat_map(along).collect(), ..PalmMotion::default() }
}

/// Direction upwards in the frame of a gripper that hangs upside down.
const UP: [f64; 2] = [0.0, -1.0];

/// Finds the start time of the loads and prepares the scene for them.
pub(super) fn prepare(scene: &Scene, plan: &Plan, monitor: &Monitor<'_>) -> Result<PreparedScene, HoldError> {
    if scene.require_fingers(2)?.hand.grasped().motion == ObjectMotion::Fixed {
        return Err(HoldError::FixedObject);
    }
    let cycle = scene.cycle();
    let (start_s, start_reason) = load_start(scene, plan, &cycle, monitor)?;
    if let Some(release_s) = cycle.release_s.filter(|release_s| *release_s <= start_s) {
        return Err(HoldError::ReleasedBeforeLoad { start_s, release_s });
    }
    let palm_motion = scene.hand.palm_motion.clone().unwrap_or_default();
    let scene_motion = match moves_start(&palm_motion) {
        Some(start_s) => rescale(&palm_motion, 1.0, -start_s),
        None => standard_cycle(UP),
    };
    let prior_motion = match plan.loads {
        Loads::Move => PalmMotion::default(),
        _ => completed_motion(&palm_motion, start_s),
    };
    let centre_m = scene.hand.grasped().centre_m;
    let setup = LoadSetup {
        start_s,
        prior_motion,
        scene_peak_m_s2: peak_acceleration(&scene_motion, centre_m),
        scene_motion,
        lever_m: hypot(centre_m[0], centre_m[1]),
    };
    Ok(PreparedScene { scene: with_fixed_drives(scene, start_s), setup, start_reason })
}

/// Evaluates the criteria of a grasp, and the time from which bodies stay slower than [`REST_SPEED_M_S`] up to the last sample.
struct RestDetector<'a> {
    tracker: ObjectTracker,
    /// Indices among the bodies of samples.
    bodies: &'a [usize],
    rest_start_s: Option<f64>,
}

impl Sink for RestDetector<'_> {
    fn required_data(&self) -> RequiredData {
        self.tracker.required_data()
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let is_slow = |body: &usize| {
            let [x, y] = sample.body(*body).velocity_m_s;
            hypot(x, y) < REST_SPEED_M_S
        };
        let is_at_rest = self.bodies.iter().all(is_slow);
        self.rest_start_s = is_at_rest.then(|| self.rest_start_s.unwrap_or(sample.time_s));
        self.tracker.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.tracker.event(event)
    }
}

/// Runs a scene up to its end, at which its object must be held. Returns the time from which bodies are at rest, the grasp is
/// stable and the brakes are engaged, or else the end.
pub(super) fn rest_start(
    model: Model,
    scene: &Scene,
    bodies: &[usize],
    blocked_s: f64,
    monitor: &Monitor<'_>,
) -> Result<(f64, StartReason), HoldError> {
    let end_s = scene.duration_s;
    let tracker = ObjectTracker::for_scene(scene).ok_or_else(HoldError::no_grasp)?;
    let mut detector = RestDetector { tracker, bodies, rest_start_s: None };
    run_scene(model, scene, &mut detector, monitor)?;
    let criteria = detector.tracker.criteria();
    let Some(criteria) = criteria.as_ref().filter(|criteria| criteria.fate == Fate::Held) else {
        let fate = criteria.map_or(Fate::NotGrasped, |criteria| criteria.fate);
        return Err(HoldError::NotGrasped { at_s: fate.lost_at_s().unwrap_or(end_s), fate });
    };
    let stable_s = criteria.tts_s.map(|tts_s| tts_s.max(blocked_s));
    let start_s = detector.rest_start_s.zip(stable_s).map(|(rest_s, stable_s)| rest_s.max(stable_s));
    Ok(match start_s.filter(|start_s| *start_s < end_s) {
        // Rounded up to whole milliseconds: the time is no more precise, and the value is shown to the user.
        Some(start_s) => ((start_s * 1e3).ceil() / 1e3, StartReason::AtRest),
        None => (end_s, StartReason::StillMoving),
    })
}

fn load_start(
    scene: &Scene,
    plan: &Plan,
    cycle: &Cycle,
    monitor: &Monitor<'_>,
) -> Result<(f64, StartReason), HoldError> {
    if let Some(start_s) = plan.start_s {
        return Ok((start_s, StartReason::Requested));
    }
    let blocked_s = cycle.blocked_s.into_iter().flatten().fold(0.0, f64::max);
    if let Some(motion) = &scene.hand.palm_motion
        && let Some(start_s) = moves_start(motion)
    {
        return Ok(match plan.loads {
            Loads::Move => (start_s, StartReason::OwnMove),
            _ => (first_move_end_s(motion, start_s).max(blocked_s), StartReason::MoveCompleted),
        });
    }
    let end_s = cycle.release_s.unwrap_or(scene.duration_s).min(scene.duration_s);
    rest_start(plan.model, &scene.with_palm_motion(None, end_s), &[0], blocked_s, monitor)
}

/// Returns the end time of the moves that start at `start_s`, the earliest start.
pub(super) fn first_move_end_s(motion: &PalmMotion, start_s: f64) -> f64 {
    let first = motion.moves.iter().filter(|segment| segment.start_s == start_s);
    let end_s = first.map(|segment| segment.start_s + segment.length_s).reduce(f64::max);
    // A path has no separate segments.
    end_s.unwrap_or_else(|| motion.moves_end_s())
}

/// Returns the moves and the path that have ended at a time, and the vibrations that have started.
pub(super) fn completed_motion(motion: &PalmMotion, time_s: f64) -> PalmMotion {
    let moves = motion.moves.iter().filter(|segment| segment.start_s + segment.length_s <= time_s);
    let vibrations = motion.vibrations.iter().filter(|vibration| vibration.start_s < time_s);
    let path = motion.path.as_ref().filter(|path| path.points().last().is_some_and(|last| last.0 <= time_s));
    PalmMotion {
        moves: moves.copied().collect(),
        vibrations: vibrations.copied().collect(),
        path: path.cloned(),
        ..PalmMotion::default()
    }
}

/// Returns the scene with the drives fixed from a time on: no torque changes and no brake releases afterwards.
fn with_fixed_drives(scene: &Scene, time_s: f64) -> Scene {
    let mut fixed = scene.with_palm_motion(None, scene.duration_s);
    let fix_motor = |motor: &mut Motor| {
        motor.actuation = fixed_actuation(&motor.actuation, time_s);
        motor.brake.iter_mut().for_each(|brake| brake.release_s = brake.release_s.filter(|end_s| *end_s < time_s));
    };
    fixed.hand.fingers.iter_mut().for_each(|finger| fix_motor(&mut finger.motor));
    fixed.hand.differential.iter_mut().for_each(|differential| fix_motor(&mut differential.motor));
    fixed
}

/// Returns the actuation with the torque constant from a time on.
pub(super) fn fixed_actuation(actuation: &Profile, time_s: f64) -> Profile {
    let now = actuation.at(time_s).0;
    match actuation {
        Profile::Table { points, interpolation } => {
            let before = points.iter().copied().filter(|point| point.0 < time_s);
            Profile::Table { points: before.chain([(time_s, now)]).collect(), interpolation: *interpolation }
        }
        Profile::Reversal { at_s, value: torque_n_m } if *at_s > time_s => Profile::Constant { value: *torque_n_m },
        // A ramp ends at its constant torque anyway.
        other => other.clone(),
    }
}

/// Minimum clearance from the table, m: an allowance for the object sinking in the hand.
const MIN_CLEARANCE_M: f64 = 0.5e-3;
/// Number of time steps at which the clearance of a load is checked.
const CLEARANCE_SAMPLES: usize = 1000;
const CLEARANCE_TOLERANCE: f64 = 1e-3;

/// Returns the largest load of a case: the plan's, or the largest that keeps the object clear of the table. A load that
/// presses the object against the table would test the table and not the hand. The scene's own move is not limited,
/// because it may start and end on the table. An error if the smallest load presses the object against the table.
pub(super) fn largest_clear_load(prepared: &PreparedScene, plan: &Plan, case: &LoadCase) -> Result<f64, HoldError> {
    let is_clear = |peak_m_s2: f64| is_clear(prepared, &case.load(&prepared.setup, peak_m_s2));
    if plan.loads == Loads::Move || is_clear(plan.to_m_s2) {
        return Ok(plan.to_m_s2);
    }
    let smallest = plan.from_m_s2 * (1.0 + CLEARANCE_TOLERANCE);
    if !is_clear(smallest) {
        return Err(HoldError::PressedAgainstTable { peak_m_s2: plan.from_m_s2 });
    }
    let next =
        |clear: f64, pressed: f64| (pressed - clear > CLEARANCE_TOLERANCE * clear).then(|| (clear * pressed).sqrt());
    let Ok([clear, _]) = bisect::<Infallible>([smallest, plan.to_m_s2], next, |load| Ok(is_clear(load)));
    Ok(clear)
}

/// Returns whether the object, fixed in the hand, stays clear of the table from the start of the load.
fn is_clear(prepared: &PreparedScene, load: &Load) -> bool {
    let Some(table) = &prepared.scene.hand.table else { return true };
    let (object, start_s) = (prepared.scene.hand.grasped().placed(), prepared.setup.start_s);
    (0..=CLEARANCE_SAMPLES).all(|index| {
        let time_s = start_s + (load.end_s - start_s) * index as f64 / CLEARANCE_SAMPLES as f64;
        let [_, height, turn] = load.motion.pose(time_s).position;
        let (sin, cos) = sin_cos(turn);
        let [x, y] = object.centre_m;
        height + sin * x + cos * y + support(&object, [sin, cos]).distance < table.level_m - MIN_CLEARANCE_M
    })
}

/// Returns the largest acceleration that contact forces can balance with the hand at rest, in both directions of a load,
/// for the active contacts of a sample; `None` for loads that rotate the palm or change their direction, and where
/// statics has no solution. Engaged brakes hold up to their torque; if a motor has
/// no engaged brake, all motors apply only their actuation torque.
pub(super) fn static_limit(prepared: &PreparedScene, sample: &Sample, case: &LoadCase) -> Option<MechanismLimit> {
    let [cos, sin] = case.direction()?;
    let is_engaged = |blocked_s: Option<f64>| blocked_s.is_some_and(|blocked_s| blocked_s <= prepared.setup.start_s);
    let all_engaged = prepared.scene.cycle().blocked_s.into_iter().all(is_engaged);
    let driven = if all_engaged { DriveMode::Blocked } else { DriveMode::AtTorque };
    let gripper = gripper_at_rest(&prepared.scene.hand, &grasp_state(&prepared.scene, sample), driven).ok()?;
    // A load accelerates in one direction and brakes in the other.
    let limits = [[cos, sin], [-cos, -sin]]
        .map(|direction| Some(mechanism_balance_towards(&gripper.at_rest(), direction).ok()?.largest));
    let [forward, backward] = limits;
    let (forward, backward) = forward.zip(backward)?;
    Some(smaller_limit(forward, backward))
}

/// The smaller of two limits, or else the first one.
pub(super) fn smaller_limit(first: MechanismLimit, second: MechanismLimit) -> MechanismLimit {
    let value = |limit: &MechanismLimit| match limit {
        MechanismLimit::Infeasible { .. } => f64::NEG_INFINITY,
        MechanismLimit::Limited { acceleration_m_s2, .. } => *acceleration_m_s2,
        MechanismLimit::Unlimited => f64::INFINITY,
    };
    if value(&second) < value(&first) { second } else { first }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Interpolation;

    #[test]
    fn torques_are_constant_from_the_start_of_the_loads() {
        let points = vec![(0.0, 0.48), (0.35, -0.24), (0.36, 0.0)];
        for actuation in [
            Profile::Constant { value: 0.48 },
            Profile::Ramp { value: 0.48, rise_s: 5e-3 },
            Profile::Table { points: points.clone(), interpolation: Interpolation::Step },
            Profile::Table { points, interpolation: Interpolation::Linear },
            Profile::Reversal { value: 0.48, at_s: 0.35 },
        ] {
            let fixed = fixed_actuation(&actuation, 0.1);
            for time_s in [0.0, 0.01, 0.05, 0.0999] {
                let (found, expected) = (fixed.at(time_s).0, actuation.at(time_s).0);
                assert!((found - expected).abs() < 1e-15, "{actuation:?} at {time_s}: {found}");
            }
            for time_s in [0.1, 0.2, 0.4, 10.0] {
                let (found, expected) = (fixed.at(time_s).0, actuation.at(0.1).0);
                assert!((found - expected).abs() < 1e-15, "{actuation:?} at {time_s}: {found}");
            }
        }
    }

    #[test]
    fn only_completed_moves_are_retained() {
        let segment = |start_s, length_s| Move { axis: Axis::Y, distance: 0.01, start_s, length_s };
        let motion = PalmMotion {
            moves: vec![segment(0.02, 0.06), segment(0.07, 0.2), segment(0.02, 0.05)],
            ..PalmMotion::default()
        };
        assert_eq!(first_move_end_s(&motion, 0.02), 0.08);
        assert_eq!(completed_motion(&motion, 0.08).moves, [segment(0.02, 0.06), segment(0.02, 0.05)]);
        assert_eq!(completed_motion(&motion, 0.019), PalmMotion::default());
        assert_eq!(moves_start(&motion), Some(0.02));
        assert_eq!(moves_start(&PalmMotion::default()), None);
    }

    #[test]
    fn standard_cycle_ends_305_mm_along_x() {
        let end = standard_cycle(UP).pose(1.0);
        assert!((end.position[0] - 0.305).abs() < 1e-15 && end.position[1].abs() < 1e-15, "{end:?}");
    }
}
