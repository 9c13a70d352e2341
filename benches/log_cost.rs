//! What logging adds to a run of design 95: medians of runs with and without a log, taken in turn.
//!
//! In memory the log is made on the thread of the run: that is what it takes of processors. In a file it is made beside the
//! run, as `phalanx run --log` does, and put in its place.

use std::fs;
use std::hint::black_box;
use std::time::Instant;

use phalanx::log::{self, RunInfo, Writer};
use phalanx::scene::{self, Preset, Scene};
use phalanx::trace::{Model, Thinned, run};

const RUNS: usize = 201;

fn main() {
    let own = scene::load("scenes/experiment-95.toml").expect("the scene ships with phalanx");
    let mut reference = own.clone();
    reference.integrate_by(Preset::Reference);
    println!("| run | without log (ms) | with log on one thread (ms) | adds | with log file (ms) | adds | size (kB) |");
    println!("|---|---|---|---|---|---|---|");
    for (name, model, scene) in [
        ("analytic, engineering preset", Model::Analytic, &own),
        ("analytic, reference preset", Model::Analytic, &reference),
        ("engine, defaults", Model::Engine, &own),
    ] {
        row(name, model, scene);
    }
}

fn row(name: &str, model: Model, scene: &Scene) {
    let path = std::env::temp_dir().join(format!("phalanx-log-cost-{}.mcap", std::process::id()));
    let info = RunInfo { scene, scene_file: "experiment-95.toml", model: model.name() };
    let mut times = [const { Vec::new() }; 3];
    let mut size = 0;
    for _ in 0..RUNS {
        times[0].push(timed(|| {
            black_box(run(model, scene, &mut ()).expect("the run completes"));
        }));
        times[1].push(timed(|| {
            let writer = Writer::new(Vec::new(), "memory", &info).expect("memory takes a log");
            let mut thinned = Thinned::new(scene.log.numeric_hz, writer);
            run(model, scene, &mut thinned).expect("the run completes");
            thinned.end().expect("memory takes a log");
            size = thinned.sink.finish().expect("memory takes a log").len();
        }));
        times[2].push(timed(|| {
            let writer = log::create(&path, &info).expect("a log can be made");
            let mut thinned = Thinned::new(scene.log.numeric_hz, writer);
            run(model, scene, &mut thinned).expect("the run completes");
            thinned.end().expect("the log is written");
            thinned.sink.keep().expect("the log is written");
        }));
        fs::remove_file(&path).expect("the log is there");
    }
    let [without, memory, file] = times.map(median);
    let adds = |with: f64| (with / without - 1.0) * 100.0;
    println!(
        "| {name} | {without:.3} | {memory:.3} | {:.0} % | {file:.3} | {:.0} % | {:.1} |",
        adds(memory),
        adds(file),
        size as f64 * 1e-3
    );
}

fn timed(run: impl FnOnce()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64() * 1e3
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
