//! How much acceleration grippers hold their objects against: symmetry, both models, statics, and what is refused.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};

use phalanx::criteria::Fate;
use phalanx::scene::words::SceneKind;
use phalanx::scene::{self, Axis, Layer, Scene};
use phalanx::study::hold::{AtRest, Case, Hold, HoldError, Loads, Plan, Since, hold};
use phalanx::trace::Model;

/// A shipped gripper with lines that go over it.
fn gripper(name: &str, over: &[&str]) -> Scene {
    let over: Vec<Layer> =
        over.iter().map(|text| Layer { file: "test".to_string(), text: (*text).to_string() }).collect();
    match scene::load_any_with(format!("scenes/gripper/{name}.toml"), &over) {
        Ok(scene) if scene.kind() == SceneKind::Gripper => scene,
        Ok(_) => panic!("{name} is no gripper"),
        Err(error) => panic!("{error}"),
    }
}

fn plan(loads: Loads) -> Plan {
    Plan {
        model: Model::Analytic,
        loads,
        begins_s: None,
        slip_m: 0.5e-3,
        from_m_s2: 4.0,
        to_m_s2: 1024.0,
        scan: 5,
        tolerance: 0.1,
        threads: 1,
    }
}

fn pulses(directions: usize) -> Loads {
    Loads::Pulses { directions, length_s: 40e-3 }
}

#[track_caller]
fn found(scene: &Scene, plan: Plan) -> Hold {
    hold(scene, plan, &mut |_, _| {}, &|| true).unwrap_or_else(|error| panic!("{}: {error}", scene.name))
}

#[track_caller]
fn refused(scene: &Scene, plan: Plan) -> HoldError {
    hold(scene, plan, &mut |_, _| {}, &|| true).expect_err("refused")
}

#[test]
fn mirrored_loads_have_one_limit_and_threads_do_not_matter() {
    let scene = gripper("hold", &[]);
    let one = found(&scene, plan(pulses(8)));
    assert_eq!(one.since, Since::Rest);
    assert!(one.stage.begins_s > 7.3e-3 && one.stage.begins_s < 20e-3, "{}", one.stage.begins_s);
    // 45° and 135°, 0° and 180°, 225° and 315°: the gripper is its own mirror image.
    for (right, left) in [(0, 4), (1, 3), (7, 5)] {
        let [right, left] = [right, left].map(|index| &one.held[index]);
        assert_eq!((right.slips, right.drops), (left.slips, left.drops), "{:?} {:?}", right.case, left.case);
        let slips = right.tried.iter().zip(&left.tried).filter_map(|(right, left)| {
            let slip = |tried: &phalanx::study::hold::Tried| tried.found.as_ref().ok().map(|found| found.slip);
            slip(right).zip(slip(left))
        });
        for (right, left) in slips.filter(|(right, _)| right.displacement_m < 1e-3) {
            assert!(
                (right.displacement_m - left.displacement_m).abs() < 1e-3 * left.displacement_m,
                "{right:?} {left:?}"
            );
        }
    }
    for held in &one.held {
        let (slips, drops) = (held.slips.held.zip(held.slips.failed), held.drops.held.zip(held.drops.failed));
        let ((slips, _), (drops, lost)) = slips.zip(drops).expect("limits within the scan");
        assert!(slips < drops && drops < lost && lost - drops <= 0.1 * lost, "{held:?}");
        assert!(held.tried.windows(2).all(|pair| pair[0].peak_m_s2 < pair[1].peak_m_s2));
    }
    // Two of these directions on three threads: the same, to the last bit.
    let three = found(&scene, Plan { threads: 3, ..plan(pulses(2)) });
    assert_eq!(three.held, [one.held[0].clone(), one.held[4].clone()]);
    assert_eq!(three.unloaded, one.unloaded);
}

#[test]
fn both_models_have_the_same_limits() {
    let scene = gripper("hold", &[]);
    for loads in [pulses(2), Loads::Vibrations { axes: vec![Axis::Y], frequencies_hz: vec![100.0] }] {
        let fine = Plan { tolerance: 0.01, to_m_s2: 64.0, ..plan(loads) };
        let analytic = found(&scene, fine.clone());
        let engine = found(&scene, Plan { model: Model::Engine, ..fine });
        for (analytic, engine) in analytic.held.iter().zip(&engine.held) {
            let [one, other] = [analytic, engine].map(|held| held.slips.held.expect("something is held"));
            assert!((one - other).abs() < 0.03 * one, "{:?}: {one} {other}", analytic.case);
        }
    }
}

/// Slowly enough, what some contact forces can balance is the most that can be held, and beyond it the object goes.
#[test]
fn nothing_is_held_slowly_that_cannot_be_balanced_at_rest() {
    let scene = gripper("hold", &["contact.friction.mu_static = 0.4"]);
    let slow = Loads::Pulses { directions: 4, length_s: 0.2 };
    let held = found(&scene, Plan { slip_m: 20e-6, to_m_s2: 512.0, scan: 8, ..plan(slow) });
    for held in &held.held {
        let Case::Pulse { direction_rad, .. } = held.case else { panic!("{:?}", held.case) };
        let Some(AtRest::UpTo { acceleration_m_s2: most }) = held.at_rest else { panic!("{:?}", held.at_rest) };
        let limit = held.slips.held.expect("something is held");
        println!("{:.0}°: {limit:.4} held of {most:.4}", direction_rad.to_degrees());
        assert!(limit <= 1.05 * most, "{:.0}°: {limit} of {most}", direction_rad.to_degrees());
    }
    let [there, back] = [0, 2].map(|index| match held.held[index].at_rest {
        Some(AtRest::UpTo { acceleration_m_s2 }) => acceleration_m_s2,
        other => panic!("{other:?}"),
    });
    assert!((there - back).abs() < 1e-9 * there, "there and back are one load: {there} {back}");
}

#[test]
fn blocked_motors_hold_what_their_torque_does_not() {
    let over = ["contact.friction.law = \"bristle\"", "motor.brake_law = \"bristle\""];
    let at = |brake_n_m: f64| {
        let brake = format!("motor.brake_torque = \"{brake_n_m} N*m\"");
        let scene = gripper("lift", &[over[0], over[1], &brake]);
        found(&scene, plan(Loads::Vibrations { axes: vec![Axis::X], frequencies_hz: vec![50.0] }))
    };
    let (weak, strong) = (at(0.1), at(2.0));
    assert_eq!((weak.since, weak.stage.begins_s), (Since::Moved, 60e-3));
    let limit = |hold: &Hold| hold.held[0].slips.held.expect("something is held");
    assert!(limit(&strong) > 2.0 * limit(&weak), "{} {}", limit(&strong), limit(&weak));
    // The lift is 25 mm: more than a vibration may come back by.
    assert_eq!(strong.held[0].to_m_s2, 1024.0);
    let down = Loads::Pulses { directions: 4, length_s: 40e-3 };
    let lifted = found(&gripper("lift", &over), Plan { scan: 2, tolerance: 0.9, ..plan(down) });
    // Out of the palm is down: 24.5 mm of clearance are 24.5e-3 · 7.513 / 0.04² m/s².
    let most = 24.5e-3 * 3.36 * 5f64.sqrt() / 0.0016;
    assert!((lifted.held[1].to_m_s2 - most).abs() < 2e-3 * most, "{} {most}", lifted.held[1].to_m_s2);
    assert_eq!(lifted.held[0].to_m_s2, 1024.0);
}

#[test]
fn a_move_is_the_scene_s_own_in_another_time() {
    let scene = gripper("cycle", &[]);
    let held = found(&scene, Plan { scan: 3, from_m_s2: 20.0, to_m_s2: 80.0, ..plan(Loads::Move) });
    assert_eq!((held.since, held.stage.begins_s), (Since::OwnMove, 20e-3));
    // 305 mm in 0.2 s are most of it.
    let across = 0.305 * 3.36 * 5f64.sqrt() / 0.04;
    assert!((held.stage.own_peak_m_s2 - across).abs() < 1e-5 * across, "{}", held.stage.own_peak_m_s2);
    let own_s = Case::Move.size(&held.stage, held.stage.own_peak_m_s2);
    assert!((own_s - 1.0).abs() < 1e-12);
    let slips: Vec<f64> =
        held.held[0].tried.iter().map(|tried| tried.found.as_ref().expect("finished").slip.displacement_m).collect();
    // Brakes hold it all along, as they do at its own pace: 3.5 µm.
    assert!(slips.len() == 3 && slips.iter().all(|slip| (2e-6..20e-6).contains(slip)), "{slips:?}");
    assert_eq!((held.held[0].slips.failed, held.held[0].drops.failed), (None, None));
}

#[test]
fn what_cannot_be_asked_is_refused_with_a_way_out() {
    let said = |error: HoldError, parts: &[&str]| {
        let text = error.to_string();
        assert!(parts.iter().all(|part| text.contains(part)), "{parts:?}: {text}");
    };
    said(refused(&gripper("fixed", &[]), plan(pulses(1))), &["fixed in the world", "object.motion = \"free\""]);
    said(refused(&gripper("table", &[]), plan(pulses(1))), &["on a table", "moves.lift.y", "table.present=false"]);
    let creeping = refused(&gripper("design-95", &[]), plan(pulses(1)));
    said(creeping, &["without any load, the object slips by", "is held then", "bristle", "--slip"]);
    let late = Plan { begins_s: Some(0.36), ..plan(pulses(1)) };
    said(refused(&gripper("cycle", &["table.present = false"]), late), &["360.000 ms", "let go at 350.000 ms", "--at"]);
    let slippery = ["contact.friction.mu_static = 0.0", "duration = \"60 ms\""];
    let thrown = refused(&gripper("design-95", &slippery), plan(pulses(1)));
    assert!(matches!(thrown, HoldError::NotGrasped { fate, .. } if fate != Fate::Held), "{thrown:?}");
    said(thrown, &["there is nothing to be loaded", "--at"]);
    // Told to stop, at once or after some runs.
    for most in [0, 2000] {
        let asked = AtomicUsize::new(0);
        let go_on = || asked.fetch_add(1, Ordering::Relaxed) < most;
        let stopped = hold(&gripper("hold", &[]), plan(pulses(2)), &mut |_, _| {}, &go_on).expect_err("stopped");
        assert!(matches!(stopped, HoldError::Stopped { .. }), "{stopped:?}");
    }
}

/// A pulse along a line at an angle is the sum of its parts.
#[test]
fn directions_are_counted_from_the_palm_s_x() {
    let held = found(&gripper("hold", &[]), Plan { scan: 2, to_m_s2: 5.0, ..plan(pulses(3)) });
    let directions: Vec<f64> = held
        .held
        .iter()
        .map(|held| match held.case {
            Case::Pulse { direction_rad, .. } => direction_rad,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(directions, [0.0, 2.0 * PI / 3.0, 4.0 * PI / 3.0]);
    let load = held.held[1].case.load(&held.stage, 10.0);
    let pose = load.motion.pose(1.0).place;
    let distance = 10.0 * 0.0016 / (3.36 * 5f64.sqrt());
    assert!(
        (pose[0] + 0.5 * distance).abs() < 1e-15 && (pose[1] - 0.75f64.sqrt() * distance).abs() < 1e-15,
        "{pose:?}"
    );
    assert!(held.held.iter().all(|held| held.slips.held == Some(5.0) && held.slips.failed.is_none()));
}

#[test]
fn a_scene_without_two_fingers_holds_nothing() {
    for path in ["scenes/experiment-95.toml", "scenes/laws/impact.toml"] {
        let scene = scene::load_any(path).unwrap_or_else(|error| panic!("{error}"));
        let error = refused(&scene, plan(Loads::Move));
        assert!(matches!(&error, HoldError::Kind(_)), "{error}");
        assert!(error.to_string().contains("only one of kind \"gripper\""), "{error}");
    }
}
