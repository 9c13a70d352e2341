//! Every shipped scene: the engine at the scene's settings is within the scene's bounds of the analytic model.

use std::fs;

use phalanx::invariants::Finding;
use phalanx::scene;
use phalanx::trace::Model;
use phalanx::validate::{compare, invariants, record, reference, sampled, verdicts};

#[test]
fn all_shipped_scenes_are_within_their_bounds() {
    let mut count = 0;
    for entry in fs::read_dir("scenes").unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let scene = scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        let expected = record(Model::Analytic, &reference(&scene));
        let expected = expected.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let found = record(Model::Engine, &sampled(Model::Engine, &scene));
        let found = found.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let verdict = verdicts(&compare(&found, &expected, scene.bounds.until_s), &scene.bounds);
        for (model, scene, run) in
            [(Model::Analytic, reference(&scene), &expected), (Model::Engine, scene.clone(), &found)]
        {
            let broken: Vec<_> = invariants(&scene, model, run).into_iter().filter(Finding::is_broken).collect();
            assert!(broken.is_empty(), "{}: {broken:?}", path.display());
        }
        let broken: Vec<_> = verdict.checks.iter().filter(|check| !check.passed()).collect();
        assert!(broken.is_empty(), "{}: {broken:?}", path.display());
        count += 1;
    }
    assert!(count >= 8, "only {count} scenes found");
}
