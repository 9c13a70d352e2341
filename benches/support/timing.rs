//! Interleaved times: every contestant runs once in each round, so that what disturbs the machine disturbs all of them.

use std::hint::black_box;
use std::time::Instant;

use serde::Serialize;

use super::Contestant;
use super::precision::{median, sorted};
use super::problem::Problem;

/// Times of one closing, without observer.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Times {
    pub median_s: f64,
    pub min_s: f64,
    pub repetitions: usize,
}

/// Rounds that are run but not counted.
const WARM_UP: usize = 3;

/// Times all contestants over `rounds` rounds; round r integrates member r of the ensemble, over and over.
pub fn interleaved(contestants: &[Box<dyn Contestant>], ensemble: &[&Problem], rounds: usize) -> Vec<Times> {
    let mut seconds = vec![Vec::with_capacity(rounds); contestants.len()];
    for round in 0..WARM_UP + rounds {
        let problem = ensemble[round % ensemble.len()];
        for (contestant, seconds) in contestants.iter().zip(&mut seconds) {
            let start = Instant::now();
            black_box(contestant.run(black_box(problem))).ok();
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
