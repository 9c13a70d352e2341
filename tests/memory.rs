//! Logs are streamed: the memory of a 10 s run, 500 times the usual duration, stays bounded.

#![cfg(target_os = "linux")]

mod support;

use std::path::Path;

use phalanx::trace::Model;
use phalanx::{log, scene};

/// Peak resident set of this process in bytes (proc(5), VmHWM).
fn peak_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux has /proc/self/status");
    let line = status.lines().find(|l| l.starts_with("VmHWM:")).expect("VmHWM is always listed");
    line.split_whitespace().nth(1).and_then(|kib| kib.parse::<u64>().ok()).expect("a number of KiB") * 1024
}

#[test]
fn ten_second_run_stays_below_50_mb() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/experiment-95.toml");
    let mut scene = scene::load(&path).expect("the shipped scene loads");
    scene.duration_s = 10.0;
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("hold.mcap");
    let info = log::RunInfo { scene: &scene, scene_file: "experiment-95.toml", model: "analytic" };
    let mut writer = log::create(&file, &info).expect("the log opens");
    let outcome = support::checked_run::run(Model::Analytic, &scene, &mut writer).expect("the hold completes");
    writer.commit().expect("the log closes");
    assert_eq!(outcome.last.time_s, 10.0);
    assert!(std::fs::metadata(&file).expect("the log exists").len() > 5_000_000, "100,000 samples were logged");
    assert!(peak_memory() < 50_000_000, "{} bytes", peak_memory());
}
