//! Two runs of the engine are the same to the last bit, and so are their logs.

use std::path::Path;

use crate::support::held;
use crate::support::runs::{anchor, engine};
use phalanx::log::{self, RunInfo};
use phalanx::scene::Scene;
use phalanx::trace::Model;

fn log_of(scene: &Scene, path: &Path) -> Vec<u8> {
    let info = RunInfo { scene, scene_file: "experiment-95.toml", model: "engine" };
    let mut writer = log::create(path, &info).expect("a log");
    held::run(Model::Engine, scene, &mut writer).expect("a run");
    writer.keep().expect("a finished log");
    std::fs::read(path).expect("the log")
}

#[test]
fn two_runs_write_the_same_bytes() {
    let directory = std::env::temp_dir().join(format!("phalanx-engine-repeats-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    let scene = anchor();
    let [first, second] = ["first.mcap", "second.mcap"].map(|name| log_of(&scene, &directory.join(name)));
    std::fs::remove_dir_all(&directory).unwrap();
    assert!(first.len() > 10_000);
    assert!(first == second, "the logs differ");
}

/// What is logged does not change the run.
#[test]
fn the_log_rate_leaves_the_run_alone() {
    let (slow, _) = engine(&anchor());
    let mut scene = anchor();
    scene.log.numeric_hz = 333e3;
    let (fast, run) = engine(&scene);
    assert_eq!(slow, fast);
    assert!(run.samples.len() > 6000);
    assert!(run.samples.windows(2).all(|pair| pair[0].time_s < pair[1].time_s), "samples in order of time");
}
