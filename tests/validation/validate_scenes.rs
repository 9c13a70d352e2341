//! Every shipped scene: the engine, with the settings of the scene, agrees with the analytic model within the scene's
//! bounds.

use std::fs;

use phalanx::invariants::Finding;
use phalanx::scene;
use phalanx::trace::Model;
use phalanx::validate::{check_bounds, check_invariants, compare, record, reference_scene, sampled_scene};

#[test]
fn all_shipped_scenes_are_within_their_bounds() {
    let mut count = 0;
    for entry in fs::read_dir("scenes").unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let scene = scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        let expected = record(Model::Analytic, &reference_scene(&scene));
        let expected = expected.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let engine_run = record(Model::Engine, &sampled_scene(Model::Engine, &scene));
        let engine_run = engine_run.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let verdict = check_bounds(&compare(&engine_run, &expected, scene.bounds.until_s), &scene.bounds);
        for (model, scene, run) in
            [(Model::Analytic, reference_scene(&scene), &expected), (Model::Engine, scene.clone(), &engine_run)]
        {
            let violations: Vec<_> =
                check_invariants(&scene, model, run).into_iter().filter(Finding::is_violated).collect();
            assert!(violations.is_empty(), "{}: {violations:?}", path.display());
        }
        let failed_checks: Vec<_> = verdict.checks.iter().filter(|check| !check.passed).collect();
        assert!(failed_checks.is_empty(), "{}: {failed_checks:?}", path.display());
        count += 1;
    }
    assert!(count >= 8, "only {count} scenes found");
}
