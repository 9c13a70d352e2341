//! The grasps of the shipped scenes of real hands: their answers are the first lines of their files.

use phalanx::criteria::ObjectTracker;
use phalanx::report::object::ObjectReport;
use phalanx::scene::{Scene, load_any};
use phalanx::trace::{Model, run};
use std::path::{Path, PathBuf};

/// All shipped scenes of real hands.
fn files_of_hands() -> Vec<PathBuf> {
    let entries = std::fs::read_dir("scenes/real").expect("the directory");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    paths.sort();
    paths
}

fn scene(path: &Path) -> Scene {
    load_any(path).unwrap_or_else(|error| panic!("{error}"))
}

/// Report of a run; `None` for a scene without a grasp.
fn report(scene: &Scene, model: Model) -> Option<ObjectReport> {
    let mut tracker = ObjectTracker::for_scene(scene)?;
    run(model, scene, &mut tracker).unwrap_or_else(|error| panic!("{}: {error}", scene.name));
    Some(ObjectReport::new(&tracker.criteria().expect("criteria"), Some(scene)))
}

#[test]
fn real_hands_have_their_answers() {
    let paths = files_of_hands();
    assert_eq!(paths.len(), 10);
    let (mut wrong, mut without) = (Vec::new(), Vec::new());
    for path in paths {
        let text = std::fs::read_to_string(&path).expect("a scene");
        let written = text.lines().next().and_then(|line| line.strip_prefix("# ")).unwrap_or_default();
        let scene = scene(&path);
        let Some(analytic) = report(&scene, Model::Analytic) else {
            without.push(scene.name);
            continue;
        };
        if analytic.answer() != written {
            wrong.push(format!("{}:\n# {}", path.display(), analytic.answer()));
        }
        let engine = report(&scene, Model::Engine).expect("a grasp");
        assert_eq!(engine.criteria.fate.name(), analytic.criteria.fate.name(), "{}", path.display());
    }
    // Single fingers that close on fixed surfaces.
    assert_eq!(without, ["dp-flex-finger", "robotiq-3f-finger"]);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
