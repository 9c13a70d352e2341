//! Both models share one definition of contact: time of contact, penetration, approach speed, and when a figure is
//! undefined.

use crate::support::cli::{directory, path_in, run_json, succeed, write};
use crate::support::laws::{self, BOTH_MODELS, CollectSink, disc, driven, free, mechanism, relative_error, spring};
use crate::support::runs::engineering_settings;
use phalanx::criteria::{Rebound, Rebounds};
use phalanx::law::NormalLaw;
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{Bounds, DiscMotion, Scene, show};
use phalanx::trace::{Event, EventKind, Model, Outcome, run};
use phalanx::validate::validate;
use serde_json::Value;

/// The scene with default settings.
fn with_defaults(scene: Scene) -> Scene {
    let bounds = Bounds::defaults_for_run(SceneKind::Bodies, scene.duration_s);
    Scene { integrator: engineering_settings(), bounds, ..scene }
}

/// A disc that starts 1 mm inside the plane and is pulled out, so fast that the clamped normal force is zero.
fn disc_pulled_out(speed: f64) -> Scene {
    let normal = NormalLaw::step(1e5, 1.0, 1e3, 1e-4);
    let hammer = disc("hammer", 0.01, [0.0, 9e-3], driven([0.0, speed], [0.0; 2]));
    with_defaults(laws::scene_on_plane(vec![hammer], normal, None, 1e-3))
}

/// A ball whose centre starts at a height in mm with a velocity along y in m/s, under gravity along y in m/s².
fn ball(height_mm: f64, velocity: f64, gravity: f64) -> Scene {
    let ball = disc("ball", 0.01, [0.0, 1e-3 * height_mm], free(0.1, None, [0.0, velocity]));
    let mut scene = with_defaults(laws::scene_on_plane(vec![ball], spring(1e8, 1.5), None, 5e-3));
    mechanism(&mut scene).gravity_m_s2 = [0.0, gravity];
    scene
}

/// Returns the outcome of a run, and the rebound and touch-downs of its first pair.
fn first_pair(model: Model, scene: &Scene) -> (Outcome, Rebound, Vec<Event>) {
    let (mut log, mut rebounds) =
        (CollectSink::default(), Rebounds::for_mechanism(scene.mechanism.as_ref().expect("discs")).expect("no joints"));
    let outcome = run(model, scene, &mut log).unwrap_or_else(|error| panic!("{error}"));
    run(model, scene, &mut rebounds).expect("the same run");
    log.events.retain(|event| event.contact == 0 && event.kind == EventKind::TouchDown);
    (outcome, rebounds.pairs()[0], log.events)
}

/// The checks of `validate` that failed, as text.
fn failed_checks(scene: &Scene) -> Vec<String> {
    let checks = validate(scene, &|| true).expect("both models run").verdict.checks;
    checks.iter().filter(|check| !check.passed).map(|check| format!("{} {check:?}", check.bound)).collect()
}

#[test]
fn an_overlap_without_a_force_is_a_contact_in_both_models() {
    for velocity in [10.0, 3.0, 40.0] {
        let scene = disc_pulled_out(velocity);
        for model in BOTH_MODELS {
            let (outcome, rebound, touchdowns) = first_pair(model, &scene);
            let contact = &outcome.contacts[0];
            assert_eq!((contact.first_s, contact.touchdowns), (Some(0.0), 1), "{model:?}");
            // The initial penetration counts although there is no force.
            assert!((contact.max_penetration_m - 1e-3).abs() < 1e-15, "{model:?}: {contact:?}");
            assert!(!contact.passed_through() && contact.depth_m().is_some(), "{model:?}");
            // The surfaces met before the start, so the approach speed is unknown.
            let approaches: Vec<f64> = touchdowns.iter().map(|event| event.approach_speed).collect();
            assert_eq!((approaches, rebound.restitution()), (vec![0.0], None), "{model:?}");
        }
        assert_eq!(failed_checks(&scene), [""; 0], "{velocity} m/s");
    }
}

/// Near the surface the damper is weaker than the spring: k δ − c(δ) v is positive below δ = k t²/(3 c v), for
/// nanoseconds.
#[test]
fn peak_force_within_one_step_is_found() {
    let (outcome, ..) = first_pair(Model::Analytic, &disc_pulled_out(10.0));
    let contact = &outcome.contacts[0];
    let last_m = 1e5 * 1e-4_f64.powi(2) / (3.0 * 1e3 * 10.0);
    let peak_n = 0.25 * 1e5 * last_m;
    assert!(relative_error(contact.peak_normal_n, peak_n) < 1e-2, "{contact:?} instead of {peak_n}");
    assert!(relative_error(contact.impulse_n_s, 2.0 / 3.0 * peak_n * last_m / 10.0) < 1e-2, "{contact:?}");
}

#[test]
fn a_closing_start_at_zero_gap_has_its_approach_speed() {
    for speed in [1.0, 0.1, 7.0] {
        let scene = ball(10.0, -speed, 0.0);
        for model in BOTH_MODELS {
            let (outcome, rebound, touchdowns) = first_pair(model, &scene);
            assert_eq!((outcome.contacts[0].first_s, outcome.contacts[0].touchdowns), (Some(0.0), 1), "{model:?}");
            assert!((touchdowns[0].approach_speed - speed).abs() < 1e-12, "{model:?}: {touchdowns:?}");
            let restitution = rebound.restitution().expect("a rebound");
            assert!((restitution - 1.0).abs() < 1e-3, "{model:?} at {speed} m/s: {restitution}");
        }
        // The invariants are excluded: at low speed the reference exceeds the energy tolerance of 1e-9 by a factor of
        // two.
        let mut failed = failed_checks(&scene);
        failed.retain(|check| !check.contains("_invariants"));
        assert_eq!(failed, [""; 0], "{speed} m/s");
    }
}

#[test]
fn a_zero_gap_that_does_not_close_is_not_a_contact() {
    // Velocity, gravity, touch-downs: at rest without a force, receding, pulled away; the last two rest on the plane.
    let cases = [(0.0, 0.0, 0), (0.5, 0.0, 0), (0.0, 9.81, 0), (0.0, -9.81, 1), (-0.0, -9.81, 1)];
    for (velocity, gravity, touchdowns) in cases {
        for model in BOTH_MODELS {
            let (outcome, ..) = first_pair(model, &ball(10.0, velocity, gravity));
            let contact = &outcome.contacts[0];
            assert_eq!(contact.touchdowns, touchdowns, "{model:?}: {velocity} m/s, {gravity} m/s²");
            assert_eq!(contact.first_s.is_some(), touchdowns > 0, "{model:?}");
            assert_eq!(contact.max_penetration_m > 1e-12, touchdowns > 0, "{model:?}");
        }
    }
}

#[test]
fn a_start_in_an_overlap_has_no_approach_speed() {
    for model in BOTH_MODELS {
        let (outcome, rebound, touchdowns) = first_pair(model, &ball(9.9, -1.0, 0.0));
        assert_eq!((outcome.contacts[0].first_s, outcome.contacts[0].touchdowns), (Some(0.0), 1), "{model:?}");
        assert_eq!((touchdowns[0].approach_speed, rebound.restitution()), (0.0, None), "{model:?}");
        assert!(outcome.contacts[0].max_penetration_m > 1e-4, "{model:?}: not deeper than at the start");
    }
}

#[test]
fn restitution_is_undefined_if_a_drive_causes_the_separation() {
    // Two discs that meet at an approach speed and are separated by the drive of one of them.
    let separated_by_drive = |model, approach: f64, acceleration: f64| {
        let discs = vec![
            disc("a", 0.01, [0.0; 2], free(0.1, None, [approach, 0.0])),
            disc("b", 0.01, [0.02, 0.0], driven([0.0; 2], [acceleration, 0.0])),
        ];
        first_pair(model, &with_defaults(laws::scene(discs, spring(1e5, 1.5), None, 20e-3))).1.restitution()
    };
    for model in BOTH_MODELS {
        // An impact with a disc at rest.
        let impact = separated_by_drive(model, 2.0, 0.0).expect("an impact");
        assert!((impact - 1.0).abs() < 1e-2, "{model:?}: {impact}");
        // Short contacts whose separation speed is caused by the drive.
        for (approach, acceleration) in [(1e-3, 1e3), (1e-2, 1e4), (1e-9, 1e3)] {
            assert_eq!(separated_by_drive(model, approach, acceleration), None, "{model:?}: {approach} m/s");
        }
        // A low speed alone does not make restitution undefined.
        let (_, slow, _) = first_pair(model, &ball(10.0, -1e-3, 0.0));
        assert!(slow.restitution().is_none_or(|ratio| (ratio - 1.0).abs() < 0.05), "{model:?}: {slow:?}");
    }
}

/// A ball of 1 mm radius approaches a post of 1 mm radius at 100 m/s; a step of 0.1 ms takes it past the post.
fn fast_ball(height_mm: f64) -> String {
    let discs = vec![
        disc("ball", 1e-3, [0.0, 1e-3 * height_mm], free(0.1, None, [0.0, -100.0])),
        disc("post", 1e-3, [0.0; 2], DiscMotion::Fixed),
    ];
    show(&with_defaults(laws::scene(discs, spring(1e8, 1.5), None, 1e-3)))
}

#[test]
fn bodies_that_pass_through_each_other_are_reported_without_depth() {
    let directory = directory("passed_through");
    let [log, html] = ["bullet.mcap", "bullet.html"].map(|name| path_in(&directory, name));
    for height_mm in [11.0, 11.1, 10.7] {
        let file = write(&directory, "bullet.toml", &fast_ball(height_mm));
        let fixed_step = ["run", &file, "--model", "engine", "--step", "100 us"];
        let document = run_json(&[&fixed_step[..], &["--json", "--log", &log]].concat());
        let replayed = run_json(&["replay", &log, "--json"]);
        for contact in [&document["contacts"]["ball-post"], &replayed["contacts"]["ball-post"]] {
            assert_eq!((&contact["passed_through"], &contact["touchdowns"]), (&true.into(), &0.into()), "{contact}");
            let figures = (&contact["max_penetration_m"], &contact["restitution"]);
            assert_eq!(figures, (&Value::Null, &Value::Null), "{contact}");
        }
        let text = succeed(&[&fixed_step[..], &["--plot", &html]].concat());
        let page = std::fs::read_to_string(&html).expect("a page");
        for output in [&text, &succeed(&["replay", &log]), &page] {
            assert!(output.contains("WARNING: ball-post: the bodies passed through each other"), "{output}");
        }
        let row = text.lines().find(|line| line.starts_with("ball-post")).expect("a row");
        let cells: Vec<&str> = row.split_whitespace().collect();
        assert_eq!(cells, ["ball-post", "–", "0", "0", "0", "0", "–", "0", "–"]);
    }
    // Adaptive steps detect the contact, and there is no warning.
    let file = write(&directory, "bullet.toml", &fast_ball(11.0));
    let contact = &run_json(&["run", &file, "--model", "engine", "--json"])["contacts"]["ball-post"];
    assert!(contact["passed_through"].is_null() && contact["max_penetration_m"].is_number(), "{contact}");
}

#[test]
fn a_half_plane_has_its_surface_at_its_level() {
    // Free fall over 1 mm onto the plane: the first contact is after √(2 h / g).
    let fall_s = (2.0 * 1e-3 / 100.0_f64).sqrt();
    for level_mm in [-30.0, -0.5, 0.0, 12.5, 40.0] {
        let mut scene = ball(11.0, 0.0, -100.0);
        let of_ball = mechanism(&mut scene);
        of_ball.bodies[0].pose[1] += 1e-3 * level_mm;
        let plane = &mut of_ball.ground_outlines[0].shape;
        *plane = plane.moved([0.0, 1e-3 * level_mm], 0.0);
        for model in BOTH_MODELS {
            let first_s = first_pair(model, &scene).0.contacts[0].first_s.expect("a contact");
            assert!(
                (first_s - fall_s).abs() < 1e-8,
                "{model:?}, level {level_mm} mm: {first_s} s, expected {fall_s} s"
            );
        }
    }
}
