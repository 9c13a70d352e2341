//! All runs of a study, on as many threads as are wanted.

use std::collections::HashSet;
use std::ops::RangeInclusive;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::one::one;
use super::{Row, Study};
use crate::study::pool::pool;

/// What running a study came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ran {
    /// Runs made now; those that were done already do not count.
    pub runs: u64,
    pub threads: usize,
    pub wall_s: f64,
    /// Whether all runs that were to be made have been.
    pub complete: bool,
}

/// Makes all runs of a study that are not `done`; each `row` comes as it is found, in any order.
///
/// With 0 threads there is one for each core.
pub fn run(study: &Study, threads: usize, done: &HashSet<u64>, mut each: impl FnMut(Row) + Send) -> Ran {
    let take = |row| {
        each(row);
        true
    };
    run_while(study, threads, study.runs(), done, &|| true, take)
}

/// Makes the first `most` runs of a study except those `done`, until `go_on` or `each` says no. A run that is stopped on its
/// way has no row.
pub fn run_while(
    study: &Study,
    threads: usize,
    most: u64,
    done: &HashSet<u64>,
    go_on: &(dyn Fn() -> bool + Sync),
    each: impl FnMut(Row) -> bool + Send,
) -> Ran {
    run_range(study, threads, 1..=study.runs().min(most), done, go_on, each)
}

/// Makes these runs of a study except those `done`, as [`run_while`] does.
///
/// Threads take the next run when they are free, one after the other, so that rows come nearly in order; and hand over its
/// row themselves: nobody has to be woken for it.
pub fn run_range(
    study: &Study,
    threads: usize,
    runs: RangeInclusive<u64>,
    done: &HashSet<u64>,
    go_on: &(dyn Fn() -> bool + Sync),
    each: impl FnMut(Row) -> bool + Send,
) -> Ran {
    let start = Instant::now();
    let all = if runs.is_empty() { 0 } else { runs.end() - runs.start() + 1 };
    let left = all - done.iter().filter(|run| runs.contains(run)).count() as u64;
    let pool = pool(threads, usize::try_from(left).unwrap_or(usize::MAX));
    let (stopped, ran, each) = (AtomicBool::new(false), AtomicU64::new(0), Mutex::new(each));
    let may = || !stopped.load(Ordering::Relaxed) && go_on();
    // `None` where it is stopped, and then no thread takes another run.
    let work = |at| {
        let row = may().then(|| one(study, at, &may))??;
        // A listener that panicked on another thread has seen the end of this one too.
        if !each.lock().ok()?(row) {
            stopped.store(true, Ordering::Relaxed);
        }
        ran.fetch_add(1, Ordering::Relaxed);
        Some(())
    };
    pool.install(|| runs.filter(|at| !done.contains(at)).par_bridge().try_for_each(work));
    let (runs, threads) = (ran.into_inner(), pool.current_num_threads());
    Ran { runs, threads, wall_s: start.elapsed().as_secs_f64(), complete: runs == left }
}
