//! Preparation of a scene for loads: start time, motion and fixed drives.

use super::error::HoldError;
use super::load::LoadSetup;
use super::motion::{delay, peak_acceleration};
use super::plan::{Loads, Plan};
use super::prepared::{PreparedScene, StartReason};
use super::rest::RestDetector;
use crate::criteria::{Fate, GraspTracker};
use crate::grasp::run;
use crate::numeric::elementary::hypot;
use crate::scene::keywords::SceneKind;
use crate::scene::{Actuation, Axis, Cycle, DiscMotion, Motor, Move, PalmMotion, Scene, torque};

/// Standard pick-and-place cycle of robots, 25/305/25 mm, as in scenes/gripper/cycle.toml.
fn standard_cycle() -> PalmMotion {
    let segment = |axis, distance, start_s, length_s| Move { axis, distance, start_s, length_s };
    let moves = vec![
        segment(Axis::Y, -0.025, 0.0, 0.06),
        segment(Axis::X, 0.305, 0.05, 0.2),
        segment(Axis::Y, 0.025, 0.24, 0.08),
    ];
    PalmMotion { moves, ..PalmMotion::default() }
}

/// Finds the start time of the loads and prepares the scene for them; `None` if interrupted.
pub(super) fn prepare(
    scene: &Scene,
    plan: &Plan,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<Option<PreparedScene>, HoldError> {
    if scene.require_kind(SceneKind::Gripper)?.system.grasped().motion == DiscMotion::Fixed {
        return Err(HoldError::FixedObject);
    }
    let cycle = scene.cycle();
    let Some((start_s, start_reason)) = load_start(scene, plan, &cycle, keep_running)? else {
        return Ok(None);
    };
    if let Some(release_s) = cycle.release_s.filter(|release_s| *release_s <= start_s) {
        return Err(HoldError::ReleasedBeforeLoad { start_s, release_s });
    }
    let palm_motion = scene.system.palm_motion.clone().unwrap_or_default();
    let scene_motion = match moves_start(&palm_motion) {
        Some(start_s) => delay(&palm_motion, -start_s),
        None => standard_cycle(),
    };
    let prior_motion =
        if plan.loads == Loads::Move { PalmMotion::default() } else { completed_motion(&palm_motion, start_s) };
    let centre_m = scene.system.grasped().centre_m;
    let setup = LoadSetup {
        start_s,
        prior_motion,
        scene_peak_m_s2: peak_acceleration(&scene_motion, centre_m),
        scene_motion,
        lever_m: hypot(centre_m[0], centre_m[1]),
    };
    Ok(Some(PreparedScene { scene: with_fixed_drives(scene, start_s), setup, start_reason }))
}

/// Returns the start time of the moves and the path, if there are any.
fn moves_start(motion: &PalmMotion) -> Option<f64> {
    let moves = PalmMotion { vibrations: Vec::new(), ..motion.clone() };
    Some(moves.start_s()).filter(|start_s| start_s.is_finite())
}

/// Returns the start time of the loads; `None` if interrupted.
fn load_start(
    scene: &Scene,
    plan: &Plan,
    cycle: &Cycle,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<Option<(f64, StartReason)>, HoldError> {
    if let Some(start_s) = plan.start_s {
        return Ok(Some((start_s, StartReason::Requested)));
    }
    let palm_motion = scene.system.palm_motion.as_ref();
    let blocked_s = cycle.blocked_s.into_iter().flatten().fold(0.0, f64::max);
    if let Some(start_s) = palm_motion.and_then(moves_start) {
        return Ok(Some(match plan.loads {
            Loads::Move => (start_s, StartReason::OwnMove),
            _ => (first_move_end_s(palm_motion, start_s).max(blocked_s), StartReason::MoveCompleted),
        }));
    }
    let end_s = cycle.release_s.unwrap_or(scene.duration_s).min(scene.duration_s);
    let resting_scene = scene.with_palm_motion(None, end_s);
    let mut detector = RestDetector::new(GraspTracker::for_scene(&resting_scene));
    match run(plan.model, &resting_scene, &mut detector, keep_running) {
        None => return Ok(None),
        Some(Err(reason)) => return Err(HoldError::Scene { reason }),
        Some(Ok(_)) => {}
    }
    let Some(criteria) = detector.criteria().filter(|criteria| criteria.fate == Fate::Held) else {
        let fate = detector.criteria().map_or(Fate::NotGrasped, |criteria| criteria.fate);
        return Err(HoldError::NotGrasped { end_s, fate });
    };
    let stable_s = criteria.tts_s.map(|tts_s| tts_s.max(blocked_s)).filter(|stable_s| *stable_s < end_s);
    Ok(Some(match detector.rest_start_s().zip(stable_s) {
        // Rounded up to whole milliseconds: the time is no more precise, and the value is shown to the user.
        Some((rest_s, stable_s)) => ((rest_s.max(stable_s) * 1e3).ceil() / 1e3, StartReason::AtRest),
        None => (end_s, StartReason::StillMoving { speed_m_s: criteria.end_speed_m_s() }),
    }))
}

/// Returns the end time of the moves that start at `start_s`, the earliest start.
fn first_move_end_s(motion: Option<&PalmMotion>, start_s: f64) -> f64 {
    let moves = motion.iter().flat_map(|motion| &motion.moves);
    let first_end_s = moves
        .filter(|segment| segment.start_s == start_s)
        .map(|segment| segment.start_s + segment.length_s)
        .reduce(f64::max);
    // A path has no separate segments.
    first_end_s.unwrap_or_else(|| motion.map_or(0.0, PalmMotion::moves_end_s))
}

/// Returns the moves and the path that have ended at a time, and the vibrations that have started.
fn completed_motion(motion: &PalmMotion, time_s: f64) -> PalmMotion {
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
    fixed.system.fingers.iter_mut().for_each(|finger| fix_motor(&mut finger.motor));
    fixed.system.differential.iter_mut().for_each(|differential| fix_motor(&mut differential.motor));
    fixed
}

/// Returns the actuation with the torque constant from a time on.
fn fixed_actuation(actuation: &Actuation, time_s: f64) -> Actuation {
    let now = torque(actuation, time_s).0;
    match actuation {
        Actuation::Constant { .. } => actuation.clone(),
        // A ramp ends at its constant torque anyway.
        Actuation::Ramp { .. } => actuation.clone(),
        Actuation::Table { points, interpolation } => {
            let before = points.iter().copied().filter(|point| point.0 < time_s);
            Actuation::Table { points: before.chain([(time_s, now)]).collect(), interpolation: *interpolation }
        }
        Actuation::Reversal { at_s, torque_n_m } if *at_s > time_s => Actuation::Constant { torque_n_m: *torque_n_m },
        Actuation::Reversal { .. } | Actuation::HalfSine { .. } => actuation.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Interpolation;

    #[test]
    fn torques_are_constant_from_the_start_of_the_loads() {
        let points = vec![(0.0, 0.48), (0.35, -0.24), (0.36, 0.0)];
        for actuation in [
            Actuation::Constant { torque_n_m: 0.48 },
            Actuation::Ramp { torque_n_m: 0.48, rise_s: 5e-3 },
            Actuation::Table { points: points.clone(), interpolation: Interpolation::Step },
            Actuation::Table { points, interpolation: Interpolation::Linear },
            Actuation::Reversal { torque_n_m: 0.48, at_s: 0.35 },
        ] {
            let fixed = fixed_actuation(&actuation, 0.1);
            for time_s in [0.0, 0.01, 0.05, 0.0999] {
                let (found, expected) = (torque(&fixed, time_s).0, torque(&actuation, time_s).0);
                assert!((found - expected).abs() < 1e-15, "{actuation:?} at {time_s}: {found}");
            }
            for time_s in [0.1, 0.2, 0.4, 10.0] {
                let (found, expected) = (torque(&fixed, time_s).0, torque(&actuation, 0.1).0);
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
        assert_eq!(first_move_end_s(Some(&motion), 0.02), 0.08);
        assert_eq!(completed_motion(&motion, 0.08).moves, [segment(0.02, 0.06), segment(0.02, 0.05)]);
        assert_eq!(completed_motion(&motion, 0.019), PalmMotion::default());
        assert_eq!(moves_start(&motion), Some(0.02));
        assert_eq!(moves_start(&PalmMotion::default()), None);
    }

    #[test]
    fn standard_cycle_ends_305_mm_along_x() {
        let end = standard_cycle().pose(1.0);
        assert!((end.position[0] - 0.305).abs() < 1e-15 && end.position[1].abs() < 1e-15, "{end:?}");
    }
}
