//! The settings of a scene for the engine model and for the bounds of its validation.

use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{self, Bounds, Construction, Engine, Response, Stepping};

use super::common::{DESIGN, DRIVE, finger_with};

fn engine(keys: &str) -> Engine {
    finger_with(&format!("[engine]\n{keys}\n")).engine
}

#[test]
fn empty_sections_give_the_defaults() {
    let scene = finger_with("[engine]\n[validate]\n");
    assert_eq!((scene.engine, scene.bounds), (Engine::DEFAULT, Bounds::defaults_for_run(SceneKind::Finger, 0.02)));
    let Engine { construction, response, stepping, iterations, max_steps } = Engine::DEFAULT;
    assert_eq!((construction, response), (Construction::Maximal, Response::Laws));
    assert_eq!(stepping, Stepping::Adaptive { tolerance_m: 1e-7, max_step_s: 6e-5 });
    assert_eq!((iterations, max_steps), (2, 10_000_000));
}

#[test]
fn every_engine_key_is_applied() {
    let base = Engine::DEFAULT;
    assert_eq!(engine("construction = \"maximal\"\nlaw = \"scene\"\nstepping = \"adaptive\""), base);
    assert_eq!(engine("construction = \"reduced\""), Engine { construction: Construction::Reduced, ..base });
    let stepping = Stepping::Fixed { step_s: 1e-5 };
    assert_eq!(engine("stepping = \"fixed\"\nstep = \"10 us\""), Engine { stepping, ..base });
    let stepping = Stepping::Adaptive { tolerance_m: 1e-6, max_step_s: 2e-5 };
    assert_eq!(engine("tolerance = \"1e-3 mm\"\nmax_step = \"20 us\""), Engine { stepping, ..base });
    for iterations in [1, 10_000] {
        assert_eq!(engine(&format!("iterations = {iterations}")), Engine { iterations, ..base });
    }
    assert_eq!(engine("max_steps = 7"), Engine { max_steps: 7, ..base });
}

#[test]
fn rapier_friction_defaults_to_the_proximal_contact() {
    let response = |rest: &str| finger_with(rest).engine.response;
    let contact = "[contact.friction]\nmu_static = 0.8\n[contact.distal.friction]\nmu_static = 0.3\n";
    let law = "[engine]\nlaw = \"rapier\"\n";
    assert_eq!(finger_with(law).engine.iterations, 50);
    assert_eq!(finger_with(&format!("{law}iterations = 7\n")).engine.iterations, 7);
    assert_eq!(response(&format!("{contact}{law}")), Response::Rapier { friction: 0.8, restitution: 0.0 });
    let with_values = format!("{contact}{law}friction = 0.5\nrestitution = 1\n");
    assert_eq!(response(&with_values), Response::Rapier { friction: 0.5, restitution: 1.0 });
    let without = Response::Rapier { friction: 0.0, restitution: 0.0 };
    assert_eq!([response(law), response(&format!("{contact}{law}friction = 0\n"))], [without; 2]);
}

#[test]
fn every_bound_is_applied_and_until_defaults_to_the_duration() {
    let bounds = |keys: &str| finger_with(&format!("[validate]\n{keys}\n")).bounds;
    let base = Bounds::defaults_for_run(SceneKind::Finger, 0.02);
    assert_eq!(bounds("angle = \"1e-3 rad\""), Bounds { angle_rad: 1e-3, ..base });
    assert_eq!(bounds("contact_time = \"2 us\""), Bounds { contact_time_s: 2e-6, ..base });
    assert_eq!(bounds("final_force = 0.5"), Bounds { final_force: 0.5, ..base });
    assert_eq!(bounds("impulse = 2"), Bounds { impulse: 2.0, ..base });
    assert_eq!(bounds("loop_gap = \"1 mm\""), Bounds { loop_gap_m: 1e-3, ..base });
    assert_eq!(bounds("until = \"8 ms\""), Bounds { until_s: 0.008, ..base });
    assert_eq!(bounds("until = \"20 ms\""), base);
    let scene = scene::parse(&format!("duration = \"7 ms\"\n{DESIGN}{DRIVE}"), "test.toml").expect("scene");
    assert_eq!(scene.bounds, Bounds::defaults_for_run(SceneKind::Finger, 0.007));
}

/// `tests/broken` has the other messages. Only the wrong value is reported; keys that depend on it are not checked.
#[test]
fn wrong_settings_are_reported_once() {
    let iterations = "`engine.iterations` is 4294967297, but must be a whole number from 1 to 10000";
    for (keys, problem) in [
        ("engine.step = \"10 us\"", "`engine.step` has no effect with stepping = \"adaptive\""),
        ("engine.friction = 0.8", "`engine.friction` has no effect with law = \"scene\""),
        ("engine.law = \"scene\"\nengine.restitution = 0", "`engine.restitution` has no effect with law = \"scene\""),
        ("engine.stepping = \"fixed\"", "`engine.step` is missing"),
        ("engine.max_step = \"-1 us\"", "`engine.max_step` is -1 us, but must be above 0"),
        ("engine.iterations = 10001", "`engine.iterations` is 10001, but must be a whole number from 1 to 10000"),
        ("engine.iterations = 4294967297", iterations),
        ("engine.max_steps = 0", "`engine.max_steps` is 0, but must be a whole number from 1"),
        ("validate.contact_time = \"0 s\"", "`validate.contact_time` is 0 s, but must be above 0"),
        ("validate.impulse = inf", "`validate.impulse` is inf, but must be finite"),
        ("validate.loop_gap = \"-1 mm\"", "`validate.loop_gap` is -1 mm, but must be above 0"),
        ("validate.until = \"21 ms\"", "`validate.until` is 21 ms, but must be at most the duration of 20 ms"),
        ("engine.stepping = \"fix\"\nengine.step = \"10 us\"", "\"fix\" is not a valid value of `engine.stepping`"),
        ("engine.law = \"rapir\"\nengine.friction = 0.8", "\"rapir\" is not a valid value of `engine.law`"),
        ("duration = \"0 ms\"\nvalidate.until = \"30 ms\"", "`duration` is 0 ms, but must be above 0"),
    ] {
        let error = scene::parse(&format!("{keys}\n{DESIGN}{DRIVE}"), "test.toml").expect_err(keys);
        let messages: Vec<&str> = error.problems().iter().map(|p| p.message.as_str()).collect();
        assert_eq!(messages, [problem]);
    }
}
