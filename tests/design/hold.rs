//! Accelerations that grippers withstand: symmetry, agreement of both models, comparison with statics, and rejected scenes.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};

use phalanx::criteria::Fate;
use phalanx::parallel::Monitor;
use phalanx::scene::{self, Axis, Layer, Scene};
use phalanx::statics::MechanismLimit;
use phalanx::study::hold::{Evaluation, Hold, HoldError, LoadCase, LoadResult, Loads, Plan, StartReason, hold};
use phalanx::trace::Model;

use crate::support::cli::assert_contains;
use crate::support::designs::assert_near;

/// Loads a shipped gripper with overrides.
fn gripper(name: &str, overrides: &[&str]) -> Scene {
    let layers: Vec<Layer> =
        overrides.iter().map(|text| Layer { file: "test".to_string(), text: (*text).to_string() }).collect();
    scene::load_any_with(format!("scenes/gripper/{name}.toml"), &layers).unwrap_or_else(|error| panic!("{error}"))
}

fn load(path: &str) -> Scene {
    scene::load_any(path).unwrap_or_else(|error| panic!("{error}"))
}

fn plan(loads: Loads) -> Plan {
    Plan { loads, from_m_s2: 4.0, to_m_s2: 1024.0, scan: 5, tolerance: 0.1, threads: 1, ..Plan::default() }
}

fn pulses(directions: usize) -> Loads {
    Loads::Pulses { directions, length_s: 40e-3 }
}

#[track_caller]
fn run_hold(scene: &Scene, plan: Plan) -> Hold {
    hold(scene, plan, &Monitor::silent(&|| true)).unwrap_or_else(|error| panic!("{}: {error}", scene.name))
}

#[track_caller]
fn hold_error(scene: &Scene, plan: Plan) -> HoldError {
    hold(scene, plan, &Monitor::silent(&|| true)).expect_err("an error")
}

#[test]
fn mirrored_loads_have_equal_limits_for_any_number_of_threads() {
    let scene = gripper("hold", &[]);
    let single = run_hold(&scene, plan(pulses(8)));
    assert_eq!(single.start_reason, StartReason::AtRest);
    assert!(single.setup.start_s > 7.3e-3 && single.setup.start_s < 20e-3, "{}", single.setup.start_s);
    // Pairs 45° and 135°, 0° and 180°, 225° and 315°: the gripper is mirror-symmetric.
    for (right, left) in [(0, 4), (1, 3), (7, 5)] {
        let [right, left] = [right, left].map(|index| &single.results[index]);
        assert_eq!((right.slips, right.drops), (left.slips, left.drops), "{:?} {:?}", right.case, left.case);
        let slips = right.evaluations.iter().zip(&left.evaluations).filter_map(|(right, left)| {
            let slip = |run: &Evaluation| run.outcome.as_ref().ok().map(|outcome| outcome.slip);
            slip(right).zip(slip(left))
        });
        for (right, left) in slips.filter(|(right, _)| right.displacement_m < 1e-3) {
            assert_near(right.displacement_m, left.displacement_m, 1e-3 * left.displacement_m);
        }
    }
    for result in &single.results {
        let (slips, drops) = (result.slips.held.zip(result.slips.failed), result.drops.held.zip(result.drops.failed));
        let ((slips, _), (drops, lost)) = slips.zip(drops).expect("limits within the scan");
        assert!(slips < drops && drops < lost && lost - drops <= 0.1 * lost, "{result:?}");
        assert!(result.evaluations.windows(2).all(|pair| pair[0].peak_m_s2 < pair[1].peak_m_s2));
    }
    // Two of these directions on three threads: identical to the last bit.
    let three = run_hold(&scene, Plan { threads: 3, ..plan(pulses(2)) });
    assert_eq!(three.results, [single.results[0].clone(), single.results[4].clone()]);
    assert_eq!(three.unloaded, single.unloaded);
}

#[test]
fn both_models_have_equal_limits() {
    let scene = gripper("hold", &[]);
    for loads in [pulses(2), Loads::Vibrations { axes: vec![Axis::Y], frequencies_hz: vec![100.0] }] {
        let fine = Plan { tolerance: 0.01, to_m_s2: 64.0, ..plan(loads) };
        let analytic = run_hold(&scene, fine.clone());
        let engine = run_hold(&scene, Plan { model: Model::Engine, ..fine });
        for (analytic, engine) in analytic.results.iter().zip(&engine.results) {
            let [analytic_m_s2, engine_m_s2] =
                [analytic, engine].map(|result| result.slips.held.expect("something is held"));
            assert_near(engine_m_s2, analytic_m_s2, 0.03 * analytic_m_s2);
        }
    }
}

/// Slow loads are held only up to the acceleration that contact forces can balance at rest.
#[test]
fn slow_loads_above_the_static_limit_are_not_held() {
    let scene = gripper("hold", &["contact.friction.mu_static = 0.4"]);
    let slow = Loads::Pulses { directions: 4, length_s: 0.2 };
    let study = run_hold(&scene, Plan { slip_m: 20e-6, to_m_s2: 512.0, scan: 8, ..plan(slow) });
    let static_limit_m_s2 = |result: &LoadResult| {
        result.static_limit.as_ref().and_then(MechanismLimit::acceleration_m_s2).expect("a limit at rest")
    };
    for result in &study.results {
        let LoadCase::Pulse { direction_rad, .. } = result.case else { panic!("{:?}", result.case) };
        let static_limit = static_limit_m_s2(result);
        let limit = result.slips.held.expect("something is held");
        println!("{:.0}°: {limit:.4} held of {static_limit:.4}", direction_rad.to_degrees());
        assert!(limit <= 1.05 * static_limit, "{:.0}°: {limit} of {static_limit}", direction_rad.to_degrees());
    }
    let [forward, backward] = [0, 2].map(|index| static_limit_m_s2(&study.results[index]));
    assert!((forward - backward).abs() < 1e-9 * forward, "opposite directions have one limit: {forward} {backward}");
}

#[test]
fn blocked_motors_hold_more_than_their_torque_does() {
    let bristles = ["contact.friction.law = \"bristle\"", "motor.brake_law = \"bristle\""];
    let with_brake = |brake_n_m: f64| {
        let brake = format!("motor.brake_torque = \"{brake_n_m} N*m\"");
        let scene = gripper("lift", &[bristles[0], bristles[1], &brake]);
        run_hold(&scene, plan(Loads::Vibrations { axes: vec![Axis::X], frequencies_hz: vec![50.0] }))
    };
    let (weak, strong) = (with_brake(0.1), with_brake(2.0));
    assert_eq!((weak.start_reason, weak.setup.start_s), (StartReason::MoveCompleted, 60e-3));
    let limit = |study: &Hold| study.results[0].slips.held.expect("something is held");
    assert!(limit(&strong) > 2.0 * limit(&weak), "{} {}", limit(&strong), limit(&weak));
    // The lift of 25 mm exceeds the amplitude of the vibration.
    assert_eq!(strong.results[0].to_m_s2, 1024.0);
    let down = Loads::Pulses { directions: 4, length_s: 40e-3 };
    let lifted = run_hold(&gripper("lift", &bristles), Plan { scan: 2, tolerance: 0.9, ..plan(down) });
    // The direction out of the palm is down. The clearance of 24.5 mm allows 24.5e-3 · 7.513 / 0.04² m/s².
    let largest_m_s2 = 24.5e-3 * 3.36 * 5f64.sqrt() / 0.0016;
    assert_near(lifted.results[1].to_m_s2, largest_m_s2, 2e-3 * largest_m_s2);
    assert_eq!(lifted.results[0].to_m_s2, 1024.0);
}

#[test]
fn move_load_scales_the_duration_of_the_scenes_own_moves() {
    let scene = gripper("cycle", &[]);
    let study = run_hold(&scene, Plan { scan: 3, from_m_s2: 20.0, to_m_s2: 80.0, ..plan(Loads::Move) });
    assert_eq!((study.start_reason, study.setup.start_s), (StartReason::OwnMove, 20e-3));
    // The transfer of 305 mm in 0.2 s has the peak acceleration.
    let transfer_m_s2 = 0.305 * 3.36 * 5f64.sqrt() / 0.04;
    assert_near(study.setup.scene_peak_m_s2, transfer_m_s2, 1e-5 * transfer_m_s2);
    let own_s = LoadCase::Move.size(&study.setup, study.setup.scene_peak_m_s2);
    assert!((own_s - 1.0).abs() < 1e-12);
    let slips: Vec<f64> = study.results[0]
        .evaluations
        .iter()
        .map(|run| run.outcome.as_ref().expect("finished").slip.displacement_m)
        .collect();
    // The brakes hold the object at every speed; at the scene's own speed it slips by 3.5 µm.
    assert!(slips.len() == 3 && slips.iter().all(|slip| (2e-6..20e-6).contains(slip)), "{slips:?}");
    assert_eq!((study.results[0].slips.failed, study.results[0].drops.failed), (None, None));
}

#[test]
fn errors_name_the_cause_and_a_remedy() {
    let slippery = ["contact.friction.mu_static = 0.0", "duration = \"60 ms\""];
    let late_start = Plan { start_s: Some(0.36), ..plan(pulses(1)) };
    for (scene, plan, words) in [
        (gripper("fixed", &[]), plan(pulses(1)), &["fixed in the world", "object.motion = \"free\""][..]),
        (gripper("table", &[]), plan(pulses(1)), &["on a table", "moves.lift.y", "table.present=false"]),
        (
            gripper("design-95", &[]),
            plan(pulses(1)),
            &["without a load, the object slips by", "is held at the end", "bristle", "--slip"],
        ),
        (gripper("cycle", &["table.present = false"]), late_start, &["360.000 ms", "release at 350.000 ms", "--at"]),
        (gripper("design-95", &slippery), plan(pulses(1)), &["no load can be applied", "--at"]),
        (load("scenes/experiment-95.toml"), plan(Loads::Move), &["a scene of kind \"gripper\" is required"]),
        (load("scenes/laws/impact.toml"), plan(Loads::Move), &["the scene has no grasp"]),
    ] {
        assert_contains(&hold_error(&scene, plan).to_string(), words);
    }
    let thrown = hold_error(&gripper("design-95", &slippery), plan(pulses(1)));
    assert!(matches!(thrown, HoldError::NotGrasped { fate, .. } if fate != Fate::Held), "{thrown:?}");
    // Interrupted immediately or after some steps.
    for max_calls in [0, 2000] {
        let calls = AtomicUsize::new(0);
        let keep_running = || calls.fetch_add(1, Ordering::Relaxed) < max_calls;
        let stopped = hold(&gripper("hold", &[]), plan(pulses(2)), &Monitor::silent(&keep_running));
        assert!(matches!(stopped, Err(HoldError::Stopped(_))), "{stopped:?}");
    }
}

/// A pulse along an oblique line is the sum of its components.
#[test]
fn directions_are_measured_from_the_x_axis_of_the_palm() {
    let study = run_hold(&gripper("hold", &[]), Plan { scan: 2, to_m_s2: 5.0, ..plan(pulses(3)) });
    let directions = study.results.iter().map(|result| match result.case {
        LoadCase::Pulse { direction_rad, .. } => direction_rad,
        other => panic!("{other:?}"),
    });
    assert!(directions.eq([0.0, 2.0 * PI / 3.0, 4.0 * PI / 3.0]));
    let load = study.results[1].case.load(&study.setup, 10.0);
    let pose = load.motion.pose(1.0).position;
    let distance = 10.0 * 0.0016 / (3.36 * 5f64.sqrt());
    assert_near(pose[0], -0.5 * distance, 1e-15);
    assert_near(pose[1], 0.75f64.sqrt() * distance, 1e-15);
    assert!(study.results.iter().all(|result| result.slips.held == Some(5.0) && result.slips.failed.is_none()));
}
