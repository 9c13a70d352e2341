//! The error estimate of a run, compared with the known error.

use std::path::Path;

use phalanx::check::{CHAOS_THRESHOLD, Check, PERTURBATION, Verdict, check, perturbed};
use phalanx::scene::{Engine, Scene, Stepping, load, parse};
use phalanx::trace::Model;
use phalanx::validate::{compare, record, reference_scene, sampled_scene};

fn scene(name: &str) -> Scene {
    load(Path::new(&format!("scenes/{name}.toml"))).expect("a scene")
}

fn run_check(model: Model, scene: &Scene) -> Check {
    check(model, scene, &|| true)
}

/// Returns the largest difference of an angle from the reference, rad.
fn reference_error(model: Model, scene: &Scene) -> f64 {
    let reference = record(Model::Analytic, &reference_scene(scene)).expect("a reference");
    compare(&record(model, &sampled_scene(model, scene)).expect("a run"), &reference, scene.bounds.until_s).path_max()
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
        let (result, reference_error) = (run_check(model, &scene), reference_error(model, &scene));
        assert_eq!(result.verdict, Verdict::Accurate, "{name}");
        let estimate = result.errors.path;
        assert!(
            estimate > 0.5 * reference_error && estimate < 2.0 * reference_error,
            "{name}, {model:?}, {rtol}: {estimate:e} for {reference_error:e}"
        );
    }
}

#[test]
fn a_run_with_too_coarse_steps_is_uncertain() {
    let coarse = scene("experiment-95");
    let engine = Engine { stepping: Stepping::Fixed { step_s: 1e-4 }, ..coarse.engine };
    let coarse = Scene { engine, ..coarse };
    let result = run_check(Model::Engine, &coarse);
    let reference_error = reference_error(Model::Engine, &coarse);
    assert_eq!(result.verdict, Verdict::Uncertain);
    assert!(
        result.errors.path > 0.5 * reference_error && result.errors.path < 2.0 * reference_error,
        "{:e} for {reference_error:e}",
        result.errors.path
    );
}

/// Undamped rebounds with a stronger drive.
#[test]
fn a_run_sensitive_to_a_tiny_perturbation_is_chaotic() {
    let text = scene("hard/chaos").source.replace("480 N*mm", "600 N*mm").replace("132.6 N*mm", "600 N*mm");
    let scene = parse(&text, "harder.toml").expect("a scene");
    let reference = record(Model::Analytic, &reference_scene(&scene)).expect("a reference");
    let perturbed_run =
        record(Model::Analytic, &reference_scene(&perturbed(&scene, PERTURBATION))).expect("a reference");
    let effect = compare(&perturbed_run, &reference, scene.bounds.until_s).path_max();
    for model in [Model::Analytic, Model::Engine] {
        let result = run_check(model, &scene);
        assert_eq!(result.verdict, Verdict::Chaotic, "{model:?}");
        assert!(result.sensitivity > CHAOS_THRESHOLD, "{:e}", result.sensitivity);
    }
    // Up to 15 ms, the end of the comparison of trajectories, the run is not chaotic.
    assert!(effect < CHAOS_THRESHOLD, "{effect:e}");
}

/// The reported sensitivity is the effect of the perturbation, also if it is small.
#[test]
fn sensitivity_is_the_effect_of_the_perturbation() {
    let scene = scene("experiment-95");
    let reference = record(Model::Analytic, &reference_scene(&scene)).expect("a reference");
    let perturbed_run =
        record(Model::Analytic, &reference_scene(&perturbed(&scene, PERTURBATION))).expect("a reference");
    let effect = compare(&perturbed_run, &reference, scene.bounds.until_s).path_max();
    let estimate = run_check(Model::Analytic, &scene).sensitivity;
    assert!(estimate > 0.5 * effect && estimate < 2.0 * effect, "{estimate:e} for {effect:e}");
}

/// Quasi-static projection removes a rate. A check that projects in the same way would not detect this error.
#[test]
fn a_rattling_joint_limit_is_resolved_or_uncertain() {
    for name in ["hard/limit-rattles", "hard/limit-rings-on"] {
        let shipped = scene(name);
        let (result, error) = (run_check(Model::Analytic, &shipped), reference_error(Model::Analytic, &shipped));
        assert!(
            result.verdict == Verdict::Uncertain || error < 1e-5,
            "{name}: {:?}, {error:e} rad off",
            result.verdict
        );
        assert!(result.errors.path > 0.5 * error, "{name}: estimated {:e}, actual {error:e}", result.errors.path);
        let finer = Scene { integrator: shipped.integrator.with_rtol(1e-7), ..shipped };
        let error = reference_error(Model::Analytic, &finer);
        assert!(error < 1e-6, "{name} at rtol 1e-7: {error:e} rad off");
    }
}

/// A single sample estimates how thousands of events amplify the last digits, so such a run needs a margin to be sure.
#[test]
fn a_run_with_thousands_of_events_has_a_lower_error_limit() {
    for (name, limit) in [("experiment-95", 1e-5), ("hard/limit-trembles", 1e-6)] {
        let scene = scene(name);
        let events = record(Model::Analytic, &scene).expect("a run").outcome.work.events;
        let result = run_check(Model::Analytic, &scene);
        assert_eq!(events > 1000, limit < 1e-5, "{name}: {events} events");
        assert!((result.max_path_error - limit).abs() < 1e-12, "{name}: {}", result.max_path_error);
        assert_eq!(
            result.verdict == Verdict::Accurate,
            result.errors.path <= limit,
            "{name}: {:?}, {:e}",
            result.verdict,
            result.errors.path
        );
    }
}
