//! Fingers, grippers and discs as scenes of mechanisms: the file that is shown reads back, and moves in the same way.

use std::fs;

use phalanx::criteria::ObjectTracker;
use phalanx::scene::{self, NoMechanismFile, Scene, show};
use phalanx::shipped::SHIPPED_SCENES;
use phalanx::trace::run_analytic;

fn load(name: &str, settings: &[&str]) -> Scene {
    let path = format!("scenes/{name}.toml");
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let layers = scene::load_layers(path.as_ref()).unwrap_or_else(|error| panic!("{text}: {error}"));
    let setting = |text: &&str| scene::parse_setting("--set", text).unwrap_or_else(|error| panic!("{error}"));
    let settings: Vec<_> = settings.iter().map(setting).collect();
    scene::parse_layers(&layers, &settings).unwrap_or_else(|error| panic!("{error}"))
}

/// The scene as a mechanism, written and read.
fn reread(scene: &Scene) -> Scene {
    let mechanism = scene.as_mechanism().unwrap_or_else(|error| panic!("{}: {error}", scene.name));
    let text = show(&mechanism);
    let found = scene::parse_any(&text, "shown.toml").unwrap_or_else(|error| panic!("{}: {error}\n{text}", scene.name));
    let expected = Scene { source: found.source.clone(), ..mechanism };
    // Stiffnesses of bristles and poses of loops are computed from what is written.
    assert_eq!(found.grasp, expected.grasp, "{}", scene.name);
    assert_eq!(found.thresholds, expected.thresholds, "{}", scene.name);
    found
}

#[test]
fn every_shipped_scene_is_a_mechanism() {
    let mut count = 0;
    for shipped in SHIPPED_SCENES {
        let scene = load(shipped.name(), &[]);
        match scene.as_mechanism() {
            // An open loop fails before its first step as well.
            Err(NoMechanismFile::OpenLoop(_)) => {
                assert!(run_analytic(&scene, &mut ()).is_err(), "{}", shipped.file);
                continue;
            }
            Err(NoMechanismFile::Discs { reason }) => {
                let marks = ["rotates = false", "\"driven\"", "stiffness_si = 0"];
                assert!(marks.iter().any(|mark| scene.source.contains(mark)), "{}: {reason}", shipped.file);
                continue;
            }
            Ok(_) => {}
        }
        let found = reread(&scene);
        let (expected, mechanism) =
            (scene.as_mechanism().expect("closed"), found.mechanism.as_ref().expect("a mechanism"));
        let expected = expected.mechanism.as_ref().expect("a mechanism");
        assert_eq!(mechanism.actuators.len(), expected.actuators.len(), "{}", shipped.file);
        for (found, expected) in mechanism.actuators.iter().zip(&expected.actuators) {
            for step in 0..200 {
                let time_s = scene.duration_s * f64::from(step) / 199.0;
                let [found, expected] = [found, expected].map(|actuator| actuator.command.profile().at(time_s));
                assert_eq!(found, expected, "{} at {time_s}", shipped.file);
            }
        }
        count += 1;
    }
    assert!(count > 100, "{count}");
}

#[test]
fn a_mechanism_of_fingers_moves_in_the_same_way() {
    for (name, settings) in [
        ("experiment-95", &[][..]),
        ("soft-start", &[]),
        ("hard/torque-reversal", &[]),
        ("gripper/different", &[]),
        ("gripper/cycle", &["duration=30 ms", "validate.until=30 ms"]),
        ("gripper/seesaw", &[]),
    ] {
        let scene = load(name, settings);
        let mechanism = reread(&scene);
        let [expected, found] = [&scene, &mechanism].map(|scene| {
            let outcome = run_analytic(scene, &mut ()).unwrap_or_else(|error| panic!("{name}: {error}"));
            (outcome.last.energy(), outcome.work.steps)
        });
        let (scale, difference) =
            (expected.0.motor_work_j.abs(), (found.0.motor_work_j - expected.0.motor_work_j).abs());
        assert!(scale > 1e-3 && difference < 1e-5 * scale, "{name}: {difference} of {scale}");
        // A mechanism takes fewer steps in phases that are not stiff.
        let steps = found.1 as f64 / expected.1 as f64;
        assert!((0.4..1.25).contains(&steps), "{name}: {steps}");
    }
}

#[test]
fn a_gripper_as_a_mechanism_has_the_same_fate() {
    for name in ["gripper/design-95", "gripper/cycle", "hard/gripper-squeezed", "gripper/bought"] {
        let scene = load(name, &[]);
        let fates = [&scene, &reread(&scene)].map(|scene| {
            let mut tracker = ObjectTracker::for_scene(scene).expect("a grasp");
            run_analytic(scene, &mut tracker).unwrap_or_else(|error| panic!("{name}: {error}"));
            tracker.criteria().expect("a duration")
        });
        let [expected, found] = &fates;
        assert_eq!(expected.fate.name(), found.fate.name(), "{name}: {} / {}", expected.reason, found.reason);
        let [expected_s, found_s] = [expected, found].map(|grasp| grasp.grasped_s.unwrap_or_default());
        assert!((expected_s - found_s).abs() < 1e-6, "{name}: {expected_s} {found_s}");
    }
}
