//! All runs of a study, on as many threads as are wanted.

use std::collections::HashSet;
use std::num::NonZeroUsize;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

use super::one::one;
use super::{Row, Study};

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
///
/// Threads take the next run when they are free, and hand over its row themselves: nobody has to be woken for it.
pub fn run_while(
    study: &Study,
    threads: usize,
    most: u64,
    done: &HashSet<u64>,
    go_on: &(dyn Fn() -> bool + Sync),
    each: impl FnMut(Row) -> bool + Send,
) -> Ran {
    let start = Instant::now();
    let last = study.runs().min(most);
    let left = last - done.iter().filter(|run| **run <= last).count() as u64;
    let threads = match threads {
        0 => thread::available_parallelism().map_or(1, NonZeroUsize::get),
        given => given,
    };
    let threads = threads.min(usize::try_from(left).unwrap_or(usize::MAX)).max(1);
    let (next, ran) = (AtomicU64::new(1), AtomicU64::new(0));
    let (stopped, each) = (AtomicBool::new(false), Mutex::new(each));
    let may = || !stopped.load(Ordering::Relaxed) && go_on();
    let work = || {
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            if at > last || !may() {
                break;
            }
            if done.contains(&at) {
                continue;
            }
            let Some(row) = one(study, at, &may) else { break };
            // A listener that panicked on another thread has seen the end of this one too.
            let Ok(mut each) = each.lock() else { break };
            if !each(row) {
                stopped.store(true, Ordering::Relaxed);
            }
            ran.fetch_add(1, Ordering::Relaxed);
        }
    };
    thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
    let runs = ran.into_inner();
    Ran { runs, threads, wall_s: start.elapsed().as_secs_f64(), complete: runs == left }
}
