//! Throughput of the thesis's 384 simulations with the engineering preset on one and two threads. Medians of sweeps as in
//! `phalanx sweep` (reading scenes, statics, criteria, rows), without writing the file.

use std::collections::HashSet;
use std::hint::black_box;
use std::time::Instant;

use phalanx::scene;
use phalanx::study::sweep::{Study, load, run_while, table};

const ROUNDS: usize = 11;

fn main() {
    let study = load("scenes/studies/thesis.toml").expect("the study exists");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let runs = study.runs() as f64;
    let threads: Vec<usize> = if cores > 1 { vec![1, 2] } else { vec![1] };
    // Interleaved, so that disturbances of the machine affect both.
    let mut wall_times_s = vec![Vec::new(); threads.len()];
    for _ in 0..ROUNDS {
        for (wall_times_s, &threads) in wall_times_s.iter_mut().zip(&threads) {
            wall_times_s.push(sweep_time(&study, threads));
        }
    }
    let wall_times_s: Vec<f64> = wall_times_s.into_iter().map(median).collect();
    println!("| threads | 384 simulations (s) | simulations/s | simulations/s per core | speed-up |");
    println!("|---|---|---|---|---|");
    for (&threads, wall_s) in threads.iter().zip(&wall_times_s) {
        let rate = runs / wall_s;
        println!(
            "| {threads} | {wall_s:.4} | {rate:.0} | {:.0} | {:.2} |",
            rate / threads as f64,
            wall_times_s[0] / wall_s
        );
    }
    println!(
        "\nWriting and reading the scene of a run: {:.1} µs.",
        1e6 * median((0..ROUNDS).map(|_| scene_time(&study)).collect()) / runs
    );
}

/// Returns the wall time of all runs and their table.
fn sweep_time(study: &Study, threads: usize) -> f64 {
    let start = Instant::now();
    let mut rows = Vec::with_capacity(study.runs() as usize);
    run_while(study, threads, 1..=study.runs(), &HashSet::new(), &|| true, |row| {
        rows.push(row);
        true
    });
    black_box(table(study, &rows));
    assert_eq!(rows.len() as u64, study.runs());
    start.elapsed().as_secs_f64()
}

/// Returns the time for writing and reading all scenes, including their sizing.
fn scene_time(study: &Study) -> f64 {
    let start = Instant::now();
    for run in 1..=study.runs() {
        black_box(scene::parse(&study.scene_text(run), "run.toml").expect("a scene"));
    }
    start.elapsed().as_secs_f64()
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
