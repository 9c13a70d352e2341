//! What a run says of itself, where the truth is known.

use std::path::Path;

use phalanx::check::{CHAOTIC, Check, PUSH, Verdict, check, pushed};
use phalanx::scene::{Engine, Scene, Stepping, load, parse};
use phalanx::trace::Model;
use phalanx::validate::{compare, record, reference, sampled};

fn scene(name: &str) -> Scene {
    load(Path::new(&format!("scenes/{name}.toml"))).expect("a scene")
}

fn checked(model: Model, scene: &Scene) -> Check {
    check(model, scene, &|| true)
}

/// Largest difference of an angle from the reference.
fn off(model: Model, scene: &Scene) -> f64 {
    let exact = record(Model::Analytic, &reference(scene)).expect("a reference");
    compare(&record(model, &sampled(model, scene)).expect("a run"), &exact, scene.bounds.until_s).path_max()
}

#[test]
fn the_error_of_a_run_is_estimated_within_a_factor_of_two() {
    for (model, name, rtol) in [
        (Model::Analytic, "experiment-95", 1e-5),
        (Model::Analytic, "experiment-95", 1e-3),
        (Model::Analytic, "hard/friction-2", 1e-5),
        (Model::Engine, "experiment-95", 1e-5),
    ] {
        let scene = scene(name);
        let scene = Scene { integrator: scene.integrator.with_rtol(rtol), ..scene };
        let (said, off) = (checked(model, &scene), off(model, &scene));
        assert_eq!(said.verdict, Verdict::Sure, "{name}");
        let estimate = said.errors.path;
        assert!(estimate > 0.5 * off && estimate < 2.0 * off, "{name}, {model:?}, {rtol}: {estimate:e} for {off:e}");
    }
}

#[test]
fn a_run_whose_tolerance_is_too_coarse_is_uncertain() {
    let coarse = scene("experiment-95");
    let engine = Engine { stepping: Stepping::Fixed { step_s: 1e-4 }, ..coarse.engine };
    let coarse = Scene { engine, ..coarse };
    let said = checked(Model::Engine, &coarse);
    let off = off(Model::Engine, &coarse);
    assert_eq!(said.verdict, Verdict::Uncertain);
    assert!(said.errors.path > 0.5 * off && said.errors.path < 2.0 * off, "{:e} for {off:e}", said.errors.path);
}

/// Rebounds without any loss, driven harder.
#[test]
fn a_run_that_the_last_digits_of_its_input_decide_is_chaotic() {
    let text = scene("hard/chaos").source.replace("480 N*mm", "600 N*mm").replace("132.6 N*mm", "600 N*mm");
    let scene = parse(&text, "harder.toml").expect("a scene");
    let exact = record(Model::Analytic, &reference(&scene)).expect("a reference");
    let moved = record(Model::Analytic, &reference(&pushed(&scene, PUSH))).expect("a reference");
    let moves = compare(&moved, &exact, scene.bounds.until_s).path_max();
    for model in [Model::Analytic, Model::Engine] {
        let said = checked(model, &scene);
        assert_eq!(said.verdict, Verdict::Chaotic, "{model:?}");
        assert!(said.sensitivity > CHAOTIC, "{:e}", said.sensitivity);
    }
    // Up to 15 ms, where trajectories are compared, it is not.
    assert!(moves < CHAOTIC, "{moves:e}");
}

/// What the push does is what it is said to do, also where it does little.
#[test]
fn sensitivity_is_what_a_push_does() {
    let scene = scene("experiment-95");
    let exact = record(Model::Analytic, &reference(&scene)).expect("a reference");
    let moved = record(Model::Analytic, &reference(&pushed(&scene, PUSH))).expect("a reference");
    let moves = compare(&moved, &exact, scene.bounds.until_s).path_max();
    let said = checked(Model::Analytic, &scene).sensitivity;
    assert!(said > 0.5 * moves && said < 2.0 * moves, "{said:e} for {moves:e}");
}

/// What is brought to rest leaves with another rate: a check that rests it in the same way would see nothing.
#[test]
fn a_limit_that_rattles_is_either_resolved_or_said_to_be_uncertain() {
    for name in ["hard/limit-rattles", "hard/limit-rings-on"] {
        let everyday = scene(name);
        let (said, off_by) = (checked(Model::Analytic, &everyday), off(Model::Analytic, &everyday));
        assert!(said.verdict == Verdict::Uncertain || off_by < 1e-5, "{name}: {:?}, {off_by:e} rad off", said.verdict);
        assert!(said.errors.path > 0.5 * off_by, "{name}: said {:e}, {off_by:e} off", said.errors.path);
        let finer = Scene { integrator: everyday.integrator.with_rtol(1e-7), ..everyday };
        let off_by = off(Model::Analytic, &finer);
        assert!(off_by < 1e-6, "{name} at rtol 1e-7: {off_by:e} rad off");
    }
}

/// What thousands of events make of last digits is estimated by one draw: such a run is sure only of what is far below the bar.
#[test]
fn a_run_of_thousands_of_events_is_held_to_a_lower_bar() {
    for (name, bar) in [("experiment-95", 1e-5), ("hard/limit-trembles", 1e-6)] {
        let scene = scene(name);
        let events = record(Model::Analytic, &scene).expect("a run").outcome.work.events;
        let said = checked(Model::Analytic, &scene);
        assert_eq!(events > 1000, bar < 1e-5, "{name}: {events} events");
        assert!((said.bar - bar).abs() < 1e-12, "{name}: {}", said.bar);
        assert_eq!(
            said.verdict == Verdict::Sure,
            said.errors.path <= bar,
            "{name}: {:?}, {:e}",
            said.verdict,
            said.errors.path
        );
    }
}
