//! Runs of the engine and their logs are reproducible to the last bit.

use std::path::Path;

use crate::support::checked_run;
use crate::support::runs::{experiment_95, run_engine};
use phalanx::log::{self, RunInfo};
use phalanx::scene::Scene;
use phalanx::trace::Model;

fn log_bytes(scene: &Scene, path: &Path) -> Vec<u8> {
    let info = RunInfo { scene, scene_file: "experiment-95.toml", model: "engine" };
    let mut writer = log::create(path, &info).expect("a log");
    checked_run::run(Model::Engine, scene, &mut writer).expect("a run");
    writer.commit().expect("a finished log");
    std::fs::read(path).expect("the log")
}

#[test]
fn two_runs_write_identical_logs() {
    let directory = std::env::temp_dir().join(format!("phalanx-engine-repeats-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    let scene = experiment_95();
    let [first, second] = ["first.mcap", "second.mcap"].map(|name| log_bytes(&scene, &directory.join(name)));
    std::fs::remove_dir_all(&directory).unwrap();
    assert!(first.len() > 10_000);
    assert!(first == second, "the logs differ");
}

#[test]
fn the_log_rate_does_not_change_the_run() {
    let (default_outcome, _) = run_engine(&experiment_95());
    let mut scene = experiment_95();
    scene.log.numeric_hz = 333e3;
    let (fine_outcome, run) = run_engine(&scene);
    assert_eq!(default_outcome, fine_outcome);
    assert!(run.samples.len() > 6000);
    assert!(run.samples.windows(2).all(|pair| pair[0].time_s < pair[1].time_s), "samples out of order");
}
