//! Both models share one definition of contact: time of contact, penetration, approach speed, and when a figure is
//! undefined.

use std::path::Path;

use crate::support::cli::{directory, json, phalanx, stderr, stdout, write};
use phalanx::criteria::{Rebound, Rebounds};
use phalanx::scene::{self, Scene};
use phalanx::trace::{Event, EventKind, Model, Outcome, Sample, Sink, SinkError, run};
use phalanx::validate::validate;
use serde_json::Value;

const BOTH_MODELS: [Model; 2] = [Model::Analytic, Model::Engine];

/// A disc that starts 1 mm inside the plane and is pulled out at 10 m/s, so that the clamped normal force is zero.
const DISC_PULLED_OUT: &str = r#"
kind = "bodies"
duration = "1 ms"
[discs.hammer]
radius = "10 mm"
centre = ["0 mm", "9 mm"]
velocity = ["0 m/s", "10 m/s"]
motion = "driven"
[half_plane]
[contact]
stiffness_si = 1e5
exponent = 1.0
damping = "1e3 N*s/m"
transition = "0.1 mm"
"#;

/// A ball whose centre starts at a height in mm with a velocity along y in m/s, under gravity along y in m/s².
fn ball(height_mm: f64, velocity: f64, gravity: f64) -> Scene {
    parse(&format!(
        r#"
kind = "bodies"
duration = "5 ms"
gravity = ["0 m/s^2", "{gravity:?} m/s^2"]
[discs.ball]
radius = "10 mm"
centre = ["0 mm", "{height_mm:?} mm"]
velocity = ["0 m/s", "{velocity:?} m/s"]
mass = "0.1 kg"
[half_plane]
[contact]
stiffness_si = 1e8
exponent = 1.5
damping = "0 N*s/m"
"#
    ))
}

fn parse(text: &str) -> Scene {
    scene::parse_any(text, "contact.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Collects events and rebounds of a run.
struct ContactSink {
    rebounds: Rebounds,
    events: Vec<Event>,
}

impl Sink for ContactSink {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.rebounds.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.events.push(*event);
        self.rebounds.event(event)
    }
}

/// Returns the outcome of a run, and the rebound and touch-downs of its first pair.
fn first_pair(model: Model, scene: &Scene) -> (Outcome, Rebound, Vec<Event>) {
    let mut sink = ContactSink { rebounds: Rebounds::for_system(&scene.system), events: Vec::new() };
    let outcome = run(model, scene, &mut sink).unwrap_or_else(|error| panic!("{error}"));
    sink.events.retain(|event| event.contact == 0 && event.kind == EventKind::TouchDown);
    (outcome, sink.rebounds.pairs()[0], sink.events)
}

#[test]
fn an_overlap_without_a_force_is_a_contact_in_both_models() {
    for velocity in [10.0, 3.0, 40.0] {
        let scene = parse(&DISC_PULLED_OUT.replace("\"10 m/s\"", &format!("\"{velocity:?} m/s\"")));
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
        let validation = validate(&scene, &|| true).expect("both models run");
        let failed: Vec<_> = validation.verdict.checks.iter().filter(|check| !check.passed).collect();
        assert!(failed.is_empty(), "{velocity} m/s: {failed:?}");
    }
}

/// Near the surface the damper is weaker than the spring: k δ − c(δ) v is positive below δ = k t²/(3 c v), for
/// nanoseconds.
#[test]
fn peak_force_within_one_step_is_found() {
    let (outcome, ..) = first_pair(Model::Analytic, &parse(DISC_PULLED_OUT));
    let contact = &outcome.contacts[0];
    let last_m = 1e5 * 1e-4_f64.powi(2) / (3.0 * 1e3 * 10.0);
    let peak_n = 0.25 * 1e5 * last_m;
    assert!((contact.peak_normal_n / peak_n - 1.0).abs() < 1e-2, "{contact:?} instead of {peak_n}");
    assert!((contact.impulse_n_s / (2.0 / 3.0 * peak_n * last_m / 10.0) - 1.0).abs() < 1e-2, "{contact:?}");
}

#[test]
fn a_closing_start_at_zero_gap_has_its_approach_speed() {
    for speed in [1.0, 0.1, 7.0] {
        for model in BOTH_MODELS {
            let (outcome, rebound, touchdowns) = first_pair(model, &ball(10.0, -speed, 0.0));
            assert_eq!((outcome.contacts[0].first_s, outcome.contacts[0].touchdowns), (Some(0.0), 1), "{model:?}");
            assert!((touchdowns[0].approach_speed - speed).abs() < 1e-12, "{model:?}: {touchdowns:?}");
            let restitution = rebound.restitution().unwrap_or(f64::NAN);
            assert!((restitution - 1.0).abs() < 1e-3, "{model:?} at {speed} m/s: {restitution}");
        }
        // The invariants are excluded: at low speed the reference exceeds the energy tolerance of 1e-9 by a factor of
        // two.
        let mut checks = validate(&ball(10.0, -speed, 0.0), &|| true).expect("both run").verdict.checks;
        checks.retain(|check| !check.passed && !check.bound.ends_with("_invariants"));
        assert!(checks.is_empty(), "{speed} m/s: {checks:?}");
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

/// Two discs that meet at an approach speed and are separated by the drive of one of them.
fn separated_by_drive(approach: f64, acceleration: f64) -> String {
    format!(
        r#"
kind = "bodies"
duration = "20 ms"
[discs.a]
radius = "10 mm"
centre = ["0 mm", "0 mm"]
velocity = ["{approach:?} m/s", "0 m/s"]
mass = "0.1 kg"
[discs.b]
radius = "10 mm"
centre = ["20 mm", "0 mm"]
velocity = ["0 m/s", "0 m/s"]
acceleration = ["{acceleration:?} m/s^2", "0 m/s^2"]
motion = "driven"
[contact]
stiffness_si = 1e5
exponent = 1.5
damping = "0 N*s/m"
"#
    )
}

#[test]
fn restitution_is_undefined_if_a_drive_causes_the_separation() {
    for model in BOTH_MODELS {
        // An impact with a disc at rest.
        let (_, impact, _) = first_pair(model, &parse(&separated_by_drive(2.0, 0.0)));
        assert!((impact.restitution().expect("an impact") - 1.0).abs() < 1e-2, "{model:?}: {impact:?}");
        // Short contacts whose separation speed is caused by the drive.
        for (approach, acceleration) in [(1e-3, 1e3), (1e-2, 1e4), (1e-9, 1e3)] {
            let (_, brief_contact, _) = first_pair(model, &parse(&separated_by_drive(approach, acceleration)));
            assert_eq!(brief_contact.restitution(), None, "{model:?}: {brief_contact:?}");
        }
        // A low speed alone does not make restitution undefined.
        let (_, slow, _) = first_pair(model, &ball(10.0, -1e-3, 0.0));
        assert!(slow.restitution().is_none_or(|ratio| (ratio - 1.0).abs() < 0.05), "{model:?}: {slow:?}");
    }
}

/// A ball of 1 mm radius approaches a post of 1 mm radius at 100 m/s; a step of 0.1 ms takes it past the post.
fn fast_ball(height_mm: f64) -> String {
    format!(
        r#"
kind = "bodies"
duration = "1 ms"
[discs.ball]
radius = "1 mm"
centre = ["0 mm", "{height_mm:?} mm"]
velocity = ["0 m/s", "-100 m/s"]
mass = "0.1 kg"
[discs.post]
radius = "1 mm"
centre = ["0 mm", "0 mm"]
motion = "fixed"
[contact]
stiffness_si = 1e8
exponent = 1.5
damping = "0 N*s/m"
"#
    )
}

#[test]
fn bodies_that_pass_through_each_other_are_reported_without_depth() {
    let directory = directory("passed_through");
    for height_mm in [11.0, 11.1, 10.7] {
        let file = write(&directory, "bullet.toml", &fast_ball(height_mm));
        let log = directory.join("bullet.mcap");
        let log = log.to_str().expect("text");
        let fixed_step_args = ["run", file.as_str(), "--model", "engine", "--step", "100 us"];
        let document = json(&phalanx(&[&fixed_step_args[..], &["--json", "--log", log]].concat()));
        let replayed = json(&phalanx(&["replay", log, "--json"]));
        for contact in [&document["contacts"]["ball-post"], &replayed["contacts"]["ball-post"]] {
            assert_eq!((&contact["passed_through"], &contact["touchdowns"]), (&true.into(), &0.into()), "{contact}");
            assert_eq!(
                (&contact["max_penetration_m"], &contact["restitution"]),
                (&Value::Null, &Value::Null),
                "{contact}"
            );
        }
        let html = directory.join("bullet.html");
        let text = phalanx(&[&fixed_step_args[..], &["--html", html.to_str().expect("text")]].concat());
        let page = std::fs::read_to_string(html).expect("a page");
        for output_text in [stdout(&text), stdout(&phalanx(&["replay", log])), &page] {
            assert!(output_text.contains("WARNING: ball-post: the bodies passed through each other"), "{output_text}");
        }
        let row = stdout(&text).lines().find(|line| line.starts_with("ball-post")).expect("a row").to_string();
        let cells: Vec<&str> = row.split_whitespace().collect();
        assert_eq!(cells, ["ball-post", "–", "0", "0", "0", "0", "–", "0", "–"]);
    }
    // Adaptive steps detect the contact, and there is no warning.
    let file = write(Path::new(&directory), "bullet.toml", &fast_ball(11.0));
    let output = phalanx(&["run", &file, "--model", "engine", "--json"]);
    let contact = &json(&output)["contacts"]["ball-post"];
    assert!(contact["passed_through"].is_null() && contact["max_penetration_m"].is_number(), "{}", stderr(&output));
}

#[test]
fn a_half_plane_has_its_surface_at_its_level() {
    // Free fall over 1 mm onto the plane: the first contact is after √(2 h / g).
    let fall_s = (2.0 * 1e-3 / 100.0_f64).sqrt();
    for level_mm in [-30.0, -0.5, 0.0, 12.5, 40.0] {
        let mut scene = ball(11.0, 0.0, -100.0);
        scene.system.discs[0].centre_m[1] += 1e-3 * level_mm;
        scene.system.palm.as_mut().expect("a half plane").level_m = 1e-3 * level_mm;
        for model in BOTH_MODELS {
            let (outcome, ..) = first_pair(model, &scene);
            let first_s = outcome.contacts[0].first_s.unwrap_or(f64::NAN);
            assert!(
                (first_s - fall_s).abs() < 1e-8,
                "{model:?}, level {level_mm} mm: {first_s} s instead of {fall_s} s"
            );
        }
    }
}
