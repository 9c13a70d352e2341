//! Cost of logging a run of design 95: medians of interleaved runs with and without a log.
//!
//! A log in memory is written on the thread of the run, so its time is the processor time of logging. A log file is written on
//! another thread, as in `phalanx run --log`.

use std::fs;
use std::hint::black_box;
use std::time::Instant;

use phalanx::log::{self, RunInfo, Writer};
use phalanx::scene::{self, Preset, Scene};
use phalanx::trace::{Decimated, Model, run};

const RUNS: usize = 201;

fn main() {
    let default = scene::load("scenes/experiment-95.toml").expect("the scene exists");
    let mut reference = default.clone();
    reference.apply_preset(Preset::Reference);
    println!(
        "| run | without log (ms) | with log on one thread (ms) | overhead | with log file (ms) | overhead | size (kB) |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (name, model, scene) in [
        ("analytic, engineering preset", Model::Analytic, &default),
        ("analytic, reference preset", Model::Analytic, &reference),
        ("engine, defaults", Model::Engine, &default),
    ] {
        print_row(name, model, scene);
    }
}

fn print_row(name: &str, model: Model, scene: &Scene) {
    let path = std::env::temp_dir().join(format!("phalanx-log-cost-{}.mcap", std::process::id()));
    let info = RunInfo { scene, scene_file: "experiment-95.toml", model: model.name() };
    let mut times = [const { Vec::new() }; 3];
    let mut size = 0;
    for _ in 0..RUNS {
        times[0].push(elapsed_ms(|| {
            black_box(run(model, scene, &mut ()).expect("the run completes"));
        }));
        times[1].push(elapsed_ms(|| {
            let writer = Writer::new(Vec::new(), "memory", &info).expect("the log is written");
            let mut decimated = Decimated::new(scene.log.numeric_hz, writer);
            run(model, scene, &mut decimated).expect("the run completes");
            decimated.end().expect("the log is written");
            size = decimated.sink.finish().expect("the log is written").len();
        }));
        times[2].push(elapsed_ms(|| {
            let writer = log::create(&path, &info).expect("the log is created");
            let mut decimated = Decimated::new(scene.log.numeric_hz, writer);
            run(model, scene, &mut decimated).expect("the run completes");
            decimated.end().expect("the log is written");
            decimated.sink.commit().expect("the log is written");
        }));
        fs::remove_file(&path).expect("the log exists");
    }
    let [without, memory, file] = times.map(median);
    let overhead_percent = |with: f64| (with / without - 1.0) * 100.0;
    println!(
        "| {name} | {without:.3} | {memory:.3} | {:.0} % | {file:.3} | {:.0} % | {:.1} |",
        overhead_percent(memory),
        overhead_percent(file),
        size as f64 * 1e-3
    );
}

fn elapsed_ms(run: impl FnOnce()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64() * 1e3
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
