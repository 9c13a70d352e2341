//! How a scene comes to where loads begin.

use super::error::HoldError;
use super::load::Stage;
use super::motion::{delayed, peak};
use super::plan::{Loads, Plan};
use super::prepared::{Prepared, Since};
use super::rest::Rest;
use crate::criteria::{Fate, GraspTracker};
use crate::grasp::run;
use crate::numeric::elementary::hypot;
use crate::scene::words::SceneKind;
use crate::scene::{Actuation, Axis, Cycle, DiscMotion, Motor, Move, PalmMotion, Scene, torque};

/// The standard cycle of pick-and-place robots, 25/305/25 mm, as scenes/gripper/cycle.toml goes it.
fn standard_cycle() -> PalmMotion {
    let one = |axis, distance, start_s, length_s| Move { axis, distance, start_s, length_s };
    let moves = vec![one(Axis::Y, -0.025, 0.0, 0.06), one(Axis::X, 0.305, 0.05, 0.2), one(Axis::Y, 0.025, 0.24, 0.08)];
    PalmMotion { moves, ..PalmMotion::default() }
}

/// Finds when loads begin, and makes the scene ready for them; `None` if it was told to stop.
pub(super) fn prepare(
    scene: &Scene,
    plan: &Plan,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Option<Prepared>, HoldError> {
    if scene.only(SceneKind::Gripper)?.system.grasped().motion == DiscMotion::Fixed {
        return Err(HoldError::Fixed);
    }
    let cycle = scene.cycle();
    let Some((begins_s, since)) = begins(scene, plan, &cycle, go_on)? else {
        return Ok(None);
    };
    if let Some(releases_s) = cycle.releases_s.filter(|releases_s| *releases_s <= begins_s) {
        return Err(HoldError::LetGo { begins_s, releases_s });
    }
    let given = scene.system.palm_motion.clone().unwrap_or_default();
    let own = match moves_of(&given) {
        Some(start_s) => delayed(&given, -start_s),
        None => standard_cycle(),
    };
    let before = if plan.loads == Loads::Move { PalmMotion::default() } else { over_by(&given, begins_s) };
    let centre_m = scene.system.grasped().centre_m;
    let stage =
        Stage { begins_s, before, own_peak_m_s2: peak(&own, centre_m), own, lever_m: hypot(centre_m[0], centre_m[1]) };
    Ok(Some(Prepared { scene: held_from(scene, begins_s), stage, since }))
}

/// When moves and path begin, if there are any.
fn moves_of(motion: &PalmMotion) -> Option<f64> {
    let moves = PalmMotion { vibrations: Vec::new(), ..motion.clone() };
    Some(moves.starts_s()).filter(|start_s| start_s.is_finite())
}

/// When loads begin; `None` if it was told to stop.
fn begins(
    scene: &Scene,
    plan: &Plan,
    cycle: &Cycle,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Option<(f64, Since)>, HoldError> {
    if let Some(begins_s) = plan.begins_s {
        return Ok(Some((begins_s, Since::Given)));
    }
    let given = scene.system.palm_motion.as_ref();
    let blocked_s = cycle.blocked_s.into_iter().flatten().fold(0.0, f64::max);
    if let Some(start_s) = given.and_then(moves_of) {
        return Ok(Some(match plan.loads {
            Loads::Move => (start_s, Since::OwnMove),
            _ => (first_arrives_s(given, start_s).max(blocked_s), Since::Moved),
        }));
    }
    let ends_s = cycle.releases_s.unwrap_or(scene.duration_s).min(scene.duration_s);
    let alone = scene.moved_by(None, ends_s);
    let mut rest = Rest::new(GraspTracker::of(&alone));
    match run(plan.model, &alone, &mut rest, go_on) {
        None => return Ok(None),
        Some(Err(reason)) => return Err(HoldError::Scene { reason }),
        Some(Ok(_)) => {}
    }
    let Some(found) = rest.criteria().filter(|found| found.fate == Fate::Held) else {
        let fate = rest.criteria().map_or(Fate::NotGrasped, |found| found.fate);
        return Err(HoldError::NotGrasped { ends_s, fate });
    };
    let stable_s = found.tts_s.map(|tts_s| tts_s.max(blocked_s)).filter(|stable_s| *stable_s < ends_s);
    Ok(Some(match rest.since_s().zip(stable_s) {
        // To a whole millisecond: it is no sharper than that, and is read by people.
        Some((rest_s, stable_s)) => ((rest_s.max(stable_s) * 1e3).ceil() / 1e3, Since::Rest),
        None => (ends_s, Since::Moving { speed_m_s: found.end_speed_m_s() }),
    }))
}

/// When those moves are over that begin first.
fn first_arrives_s(motion: Option<&PalmMotion>, start_s: f64) -> f64 {
    let moves = motion.iter().flat_map(|motion| &motion.moves);
    let first = moves.filter(|one| one.start_s == start_s).map(|one| one.start_s + one.length_s).reduce(f64::max);
    // A path has no parts.
    first.unwrap_or_else(|| motion.map_or(0.0, PalmMotion::arrives_s))
}

/// What is over by a time, and vibrations that have begun.
fn over_by(motion: &PalmMotion, time_s: f64) -> PalmMotion {
    let moves = motion.moves.iter().filter(|one| one.start_s + one.length_s <= time_s);
    let vibrations = motion.vibrations.iter().filter(|one| one.start_s < time_s);
    let path = motion.path.as_ref().filter(|path| path.points().last().is_some_and(|last| last.0 <= time_s));
    PalmMotion {
        moves: moves.copied().collect(),
        vibrations: vibrations.copied().collect(),
        path: path.cloned(),
        ..PalmMotion::default()
    }
}

/// The scene whose drives stay as they are at a time: nothing lets go or changes after it.
fn held_from(scene: &Scene, time_s: f64) -> Scene {
    let mut held = scene.moved_by(None, scene.duration_s);
    let motor = |motor: &mut Motor| {
        motor.actuation = steady_from(&motor.actuation, time_s);
        motor.brake.iter_mut().for_each(|brake| brake.release_s = brake.release_s.filter(|end_s| *end_s < time_s));
    };
    held.system.fingers.iter_mut().for_each(|finger| motor(&mut finger.motor));
    held.system.differential.iter_mut().for_each(|differential| motor(&mut differential.motor));
    held
}

/// A torque that is the same up to a time, and stays what it is then.
fn steady_from(actuation: &Actuation, time_s: f64) -> Actuation {
    let now = torque(actuation, time_s).0;
    match actuation {
        Actuation::Constant { .. } => actuation.clone(),
        // It grows to where it stays.
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
    fn torques_stay_what_they_are_when_loads_begin() {
        let points = vec![(0.0, 0.48), (0.35, -0.24), (0.36, 0.0)];
        for actuation in [
            Actuation::Constant { torque_n_m: 0.48 },
            Actuation::Ramp { torque_n_m: 0.48, rise_s: 5e-3 },
            Actuation::Table { points: points.clone(), interpolation: Interpolation::Step },
            Actuation::Table { points, interpolation: Interpolation::Linear },
            Actuation::Reversal { torque_n_m: 0.48, at_s: 0.35 },
        ] {
            let held = steady_from(&actuation, 0.1);
            for time_s in [0.0, 0.01, 0.05, 0.0999] {
                let (found, given) = (torque(&held, time_s).0, torque(&actuation, time_s).0);
                assert!((found - given).abs() < 1e-15, "{actuation:?} at {time_s}: {found}");
            }
            for time_s in [0.1, 0.2, 0.4, 10.0] {
                let (found, given) = (torque(&held, time_s).0, torque(&actuation, 0.1).0);
                assert!((found - given).abs() < 1e-15, "{actuation:?} at {time_s}: {found}");
            }
        }
    }

    #[test]
    fn only_what_is_over_stays() {
        let one = |start_s, length_s| Move { axis: Axis::Y, distance: 0.01, start_s, length_s };
        let motion =
            PalmMotion { moves: vec![one(0.02, 0.06), one(0.07, 0.2), one(0.02, 0.05)], ..PalmMotion::default() };
        assert_eq!(first_arrives_s(Some(&motion), 0.02), 0.08);
        assert_eq!(over_by(&motion, 0.08).moves, [one(0.02, 0.06), one(0.02, 0.05)]);
        assert_eq!(over_by(&motion, 0.019), PalmMotion::default());
        assert_eq!(moves_of(&motion), Some(0.02));
        assert_eq!(moves_of(&PalmMotion::default()), None);
    }

    #[test]
    fn the_standard_cycle_is_that_of_robots() {
        let end = standard_cycle().pose(1.0);
        assert!((end.place[0] - 0.305).abs() < 1e-15 && end.place[1].abs() < 1e-15, "{end:?}");
    }
}
