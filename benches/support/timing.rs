//! Interleaved timing: each solver runs once per round, so that disturbances of the machine affect all solvers.

use std::hint::black_box;
use std::time::Instant;

use serde::Serialize;

use super::BenchSolver;
use super::precision::{median, sorted};
use super::problem::Problem;

/// Times of one closing without observer.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Times {
    pub median_s: f64,
    pub min_s: f64,
    pub repetitions: usize,
}

/// Warm-up rounds that are not counted.
const WARM_UP: usize = 3;

/// Measures the times of all solvers over `rounds` rounds. Round r integrates member r modulo the size of the ensemble.
pub fn measure_interleaved(solvers: &[Box<dyn BenchSolver>], ensemble: &[&Problem], rounds: usize) -> Vec<Times> {
    let mut seconds = vec![Vec::with_capacity(rounds); solvers.len()];
    for round in 0..WARM_UP + rounds {
        let problem = ensemble[round % ensemble.len()];
        for (solver, seconds) in solvers.iter().zip(&mut seconds) {
            let start = Instant::now();
            black_box(solver.run(black_box(problem))).ok();
            let elapsed = start.elapsed().as_secs_f64();
            if round >= WARM_UP {
                seconds.push(elapsed);
            }
        }
    }
    seconds
        .into_iter()
        .map(|seconds| {
            let seconds = sorted(seconds.into_iter());
            Times {
                median_s: median(&seconds),
                min_s: seconds.first().copied().unwrap_or(f64::NAN),
                repetitions: seconds.len(),
            }
        })
        .collect()
}
