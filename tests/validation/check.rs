//! The error estimate of a run, compared with the known error.

use crate::hard_scenes::load;
use crate::support::checked_run::record_run;
use phalanx::check::{CHAOS_THRESHOLD, PERTURBATION, Verdict, check, perturbed};
use phalanx::scene::{Scene, Stepping, parse};
use phalanx::trace::Model;
use phalanx::validate::{compare, reference_scene, sampled_scene};

/// Returns the largest difference of an angle from the reference, rad.
fn reference_error(model: Model, scene: &Scene) -> f64 {
    let reference = record_run(Model::Analytic, &reference_scene(scene));
    compare(&record_run(model, &sampled_scene(model, scene)), &reference, scene.bounds.until_s).path_max()
}

/// Returns the effect of a tiny perturbation on the angles, rad.
fn perturbation_effect(scene: &Scene) -> f64 {
    let [reference, perturbed_run] =
        [scene, &perturbed(scene, PERTURBATION)].map(|scene| record_run(Model::Analytic, &reference_scene(scene)));
    compare(&perturbed_run, &reference, scene.bounds.until_s).path_max()
}

#[test]
fn the_error_of_a_run_is_estimated_within_a_factor_of_two() {
    let with_rtol = |name: &str, rtol: f64| {
        let scene = load(name);
        Scene { integrator: scene.integrator.with_rtol(rtol), ..scene }
    };
    let mut coarse = load("experiment-95");
    coarse.engine.stepping = Stepping::Fixed { step_s: 1e-4 };
    for (model, scene, verdict) in [
        (Model::Analytic, with_rtol("experiment-95", 1e-5), Verdict::Accurate),
        (Model::Analytic, with_rtol("experiment-95", 1e-3), Verdict::Accurate),
        (Model::Analytic, with_rtol("hard/friction-2", 1e-5), Verdict::Accurate),
        (Model::Engine, with_rtol("experiment-95", 1e-5), Verdict::Accurate),
        (Model::Engine, coarse, Verdict::Uncertain),
    ] {
        let (result, error) = (check(model, &scene, &|| true), reference_error(model, &scene));
        let (name, estimate) = (&scene.name, result.errors.path);
        assert_eq!(result.verdict, verdict, "{name}");
        let ratio = estimate / error;
        assert!(ratio > 0.5 && ratio < 2.0, "{name}, {model:?}: {estimate:e} for {error:e}");
    }
}

/// Undamped rebounds with a stronger drive.
#[test]
fn a_run_sensitive_to_a_tiny_perturbation_is_chaotic() {
    let text = load("hard/chaos").source.replace("480 N*mm", "600 N*mm").replace("132.6 N*mm", "600 N*mm");
    let scene = parse(&text, "harder.toml").expect("a scene");
    for model in [Model::Analytic, Model::Engine] {
        let result = check(model, &scene, &|| true);
        assert_eq!(result.verdict, Verdict::Chaotic, "{model:?}");
        assert!(result.sensitivity > CHAOS_THRESHOLD, "{:e}", result.sensitivity);
    }
    // Up to 15 ms, the end of the comparison of trajectories, the run is not chaotic.
    let effect = perturbation_effect(&scene);
    assert!(effect < CHAOS_THRESHOLD, "{effect:e}");
}

/// The reported sensitivity is the effect of the perturbation, also if it is small.
#[test]
fn sensitivity_is_the_effect_of_the_perturbation() {
    let scene = load("experiment-95");
    let (estimate, effect) = (check(Model::Analytic, &scene, &|| true).sensitivity, perturbation_effect(&scene));
    assert!(estimate > 0.5 * effect && estimate < 2.0 * effect, "{estimate:e} for {effect:e}");
}

/// Quasi-static projection removes a rate. A check that projects in the same way would not detect this error.
#[test]
fn a_rattling_joint_limit_is_resolved_or_uncertain() {
    for name in ["hard/limit-rattles", "hard/limit-rings-on"] {
        let shipped = load(name);
        let (result, error) = (check(Model::Analytic, &shipped, &|| true), reference_error(Model::Analytic, &shipped));
        assert!(result.verdict == Verdict::Uncertain || error < 1e-5, "{name}: {result:?}, {error:e} rad off");
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
        let scene = load(name);
        let events = record_run(Model::Analytic, &scene).outcome.work.events;
        let result = check(Model::Analytic, &scene, &|| true);
        assert_eq!(events > 1000, limit < 1e-5, "{name}: {events} events");
        assert!((result.max_path_error - limit).abs() < 1e-12, "{name}: {}", result.max_path_error);
        let is_accurate = result.verdict == Verdict::Accurate;
        assert_eq!(is_accurate, result.errors.path <= limit, "{name}: {result:?}");
    }
}
