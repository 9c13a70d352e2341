//! The thesis's 384 simulations at the engineering preset: how many a second, and what a second core is worth. Medians of
//! sweeps as `phalanx sweep` makes them (scenes read, statics, criteria, rows), without the file.

use std::collections::HashSet;
use std::hint::black_box;
use std::time::Instant;

use phalanx::scene;
use phalanx::study::sweep::{Study, load, run, table};

const ROUNDS: usize = 11;

fn main() {
    let study = load("scenes/studies/thesis.toml").expect("the study ships with phalanx");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let runs = study.runs() as f64;
    let threads: Vec<usize> = if cores > 1 { vec![1, 2] } else { vec![1] };
    // In turn, so that whatever else the machine does falls on both.
    let mut walls = vec![Vec::new(); threads.len()];
    for _ in 0..ROUNDS {
        for (walls, &threads) in walls.iter_mut().zip(&threads) {
            walls.push(sweep(&study, threads));
        }
    }
    let walls: Vec<f64> = walls.into_iter().map(median).collect();
    println!("| threads | 384 simulations (s) | simulations/s | simulations/s per core | times one thread |");
    println!("|---|---|---|---|---|");
    for (&threads, wall_s) in threads.iter().zip(&walls) {
        let rate = runs / wall_s;
        println!("| {threads} | {wall_s:.4} | {rate:.0} | {:.0} | {:.2} |", rate / threads as f64, walls[0] / wall_s);
    }
    println!(
        "\nOf a run, its scene's text and reading: {:.1} µs.",
        1e6 * median((0..ROUNDS).map(|_| scenes(&study)).collect()) / runs
    );
}

/// Wall time of all runs and their table.
fn sweep(study: &Study, threads: usize) -> f64 {
    let start = Instant::now();
    let mut rows = Vec::with_capacity(study.runs() as usize);
    run(study, threads, &HashSet::new(), |row| rows.push(row));
    black_box(table(study, &rows));
    assert_eq!(rows.len() as u64, study.runs());
    start.elapsed().as_secs_f64()
}

/// Time of what is no simulation: making and reading the scenes, their sizing among it.
fn scenes(study: &Study) -> f64 {
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
