//! Parallel execution of the runs of a study.

use std::collections::HashSet;
use std::ops::RangeInclusive;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::single_run::run_one;
use super::{Row, Study};
use crate::study::pool::build_pool;

/// Statistics of one invocation of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunStats {
    /// Number of runs performed now, without those finished earlier.
    pub runs: u64,
    pub threads: usize,
    pub wall_s: f64,
    /// Whether all requested runs are finished.
    pub complete: bool,
}

/// Performs those of the first `max_runs` runs of a study that are not in `done`; see `run_range`.
pub fn run_while(
    study: &Study,
    threads: usize,
    max_runs: u64,
    done: &HashSet<u64>,
    keep_running: &(dyn Fn() -> bool + Sync),
    on_row: impl FnMut(Row) -> bool + Send,
) -> RunStats {
    run_range(study, threads, 1..=study.runs().min(max_runs), done, keep_running, on_row)
}

/// Performs those runs of a range that are not in `done`, and passes each row to `on_row` when it is finished, in any
/// order. Stops when `keep_running` or `on_row` returns false; an interrupted run has no row. `threads` = 0 means one
/// thread per core.
///
/// A free thread takes the next run, so that rows are finished nearly in order. It calls `on_row` itself, so that no
/// other thread has to be woken.
pub(crate) fn run_range(
    study: &Study,
    threads: usize,
    runs: RangeInclusive<u64>,
    done: &HashSet<u64>,
    keep_running: &(dyn Fn() -> bool + Sync),
    on_row: impl FnMut(Row) -> bool + Send,
) -> RunStats {
    let start = Instant::now();
    let total = if runs.is_empty() { 0 } else { runs.end() - runs.start() + 1 };
    let missing = total - done.iter().filter(|run| runs.contains(run)).count() as u64;
    let pool = build_pool(threads, usize::try_from(missing).unwrap_or(usize::MAX));
    let (stopped, finished, on_row) = (AtomicBool::new(false), AtomicU64::new(0), Mutex::new(on_row));
    let may_continue = || !stopped.load(Ordering::Relaxed) && keep_running();
    // `None` stops all threads.
    let work = |run| {
        let row = may_continue().then(|| run_one(study, run, &may_continue))??;
        // A poisoned lock means that `on_row` panicked on another thread.
        if !on_row.lock().ok()?(row) {
            stopped.store(true, Ordering::Relaxed);
        }
        finished.fetch_add(1, Ordering::Relaxed);
        Some(())
    };
    pool.install(|| runs.filter(|run| !done.contains(run)).par_bridge().try_for_each(work));
    let (runs, threads) = (finished.into_inner(), pool.current_num_threads());
    RunStats { runs, threads, wall_s: start.elapsed().as_secs_f64(), complete: runs == missing }
}
