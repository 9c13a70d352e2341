//! Progress, interruption and parallel execution of a computation.
//!
//! Internal to phalanx: its interface may change with any version. Programs use the crate `phalanx`.

use std::env;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use phalanx_core::scene::Scene;
use phalanx_core::trace::{Cancellable, Model, Outcome, RunError, Sink, run};

/// Error of a computation.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ComputeError {
    /// The scene or the request does not suit the study; the message contains a remedy.
    #[error("{0}")]
    Unsuitable(String),
    /// A part of the computation failed.
    #[error("{0}")]
    Failed(String),
    #[error("interrupted after {done} of {total} parts")]
    Stopped { done: usize, total: usize },
}

/// Returns [`ComputeError::Unsuitable`] with a message if a condition is not met.
pub fn require(condition: bool, message: impl FnOnce() -> String) -> Result<(), ComputeError> {
    if condition { Ok(()) } else { Err(ComputeError::Unsuitable(message())) }
}

/// A function that returns whether the computation may continue.
pub type KeepRunning<'a> = &'a (dyn Fn() -> bool + Sync);

/// Progress and interruption of a computation, shared by its threads.
pub struct Monitor<'a> {
    progress: Mutex<Progress<'a>>,
    keep_running: KeepRunning<'a>,
}

/// Number of completed parts, total number of parts, and the receiver of both and of the name of the current part.
type Progress<'a> = (usize, usize, Box<dyn FnMut(usize, usize, &str) + Send + 'a>);

impl<'a> Monitor<'a> {
    /// Creates a monitor. `report` receives the number of completed parts, the total number of parts and the name of the
    /// current part. The computation stops when `keep_running` returns false.
    pub fn new(report: impl FnMut(usize, usize, &str) + Send + 'a, keep_running: KeepRunning<'a>) -> Self {
        Monitor { progress: Mutex::new((0, 0, Box::new(report))), keep_running }
    }

    /// Creates a monitor without progress reports.
    pub fn silent(keep_running: KeepRunning<'a>) -> Self {
        Monitor::new(|_, _, _| (), keep_running)
    }

    /// Starts a computation of `total` parts; `name` is the current part.
    pub fn start(&self, total: usize, name: &str) {
        self.lock().1 = total;
        self.advance(0, name);
    }

    /// Adds `parts` to the number of completed parts, and reports the name of the current part.
    pub fn advance(&self, parts: usize, name: &str) {
        let (done, total, report) = &mut *self.lock();
        *done += parts;
        report(*done, *total, name);
    }

    /// Returns the function that tells whether the computation may continue.
    pub fn keep_running(&self) -> KeepRunning<'a> {
        self.keep_running
    }

    /// Checks whether the computation may continue.
    ///
    /// # Errors
    /// Returns an error if the computation is to stop.
    pub fn check(&self) -> Result<(), ComputeError> {
        if (self.keep_running)() { Ok(()) } else { Err(self.stopped()) }
    }

    /// Returns the error of an interrupted computation.
    pub fn stopped(&self) -> ComputeError {
        let (done, total, _) = *self.lock();
        ComputeError::Stopped { done, total }
    }

    /// Runs a scene until it ends or fails.
    ///
    /// # Errors
    /// Returns an error if the monitor stops the run.
    pub fn run<S: Sink>(
        &self,
        model: Model,
        scene: &Scene,
        sink: &mut S,
    ) -> Result<Result<Outcome, RunError>, ComputeError> {
        match run(model, scene, &mut Cancellable { sink, keep_running: self.keep_running }) {
            Err(error) if error.is_stop() => Err(self.stopped()),
            result => Ok(result),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Progress<'a>> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Builds a pool of `threads` threads, or of [`default_threads`] if `threads` is 0, but at most one per job.
///
/// # Panics
/// Panics if the system cannot start the threads.
pub fn thread_pool(threads: usize, jobs: usize) -> ThreadPool {
    let threads = if threads == 0 { default_threads() } else { threads }.min(jobs).max(1);
    ThreadPoolBuilder::new().num_threads(threads).build().expect("the system starts threads")
}

/// Runs a computation whose parallel iterators use all cores.
///
/// The threads belong to this process. A forked child process has the memory of its parent but not its threads, so that
/// a computation on rayon's own pool would wait forever; the child therefore gets new threads.
///
/// # Panics
/// Panics if the system cannot start the threads.
pub fn on_all_cores<R: Send>(compute: impl FnOnce() -> R + Send) -> R {
    static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);
    let start = || Arc::new(thread_pool(0, usize::MAX));
    let pool = match POOL.try_lock() {
        Ok(mut current) => match &*current {
            Some((process, pool)) if *process == std::process::id() => Arc::clone(pool),
            _ => {
                let pool = start();
                // The destructor of the parent's pool would wait for its threads.
                std::mem::forget(current.replace((std::process::id(), Arc::clone(&pool))));
                pool
            }
        },
        // Another thread takes the pool, or took it when this process was forked.
        Err(_) => start(),
    };
    pool.install(compute)
}

/// Applies `work` to the jobs on the threads of a [`thread_pool`], and returns the results in the order of the jobs.
///
/// # Errors
/// Returns the error of a job. After an error, no further jobs are started.
pub fn map<J: Sync, R: Send, E: Send>(
    threads: usize,
    jobs: &[J],
    work: impl Fn(&J) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    // Split down to single jobs, because their run times differ by up to a factor of a thousand.
    thread_pool(threads, jobs.len()).install(|| jobs.par_iter().with_max_len(1).map(&work).collect())
}

/// Largest number of threads.
pub const MAX_THREADS: usize = 1024;

/// The number of threads that [`set_threads`] has set.
static THREADS: AtomicUsize = AtomicUsize::new(0);

/// Sets the number of threads for computations that do not specify it; 0 restores the default.
pub fn set_threads(threads: usize) {
    THREADS.store(threads, Ordering::Relaxed);
}

/// Returns the number of threads for computations that do not specify it. This is the number given to [`set_threads`],
/// else that of the environment variable `RAYON_NUM_THREADS`, else the number of cores available to the process.
pub fn default_threads() -> usize {
    let from_environment = || env::var("RAYON_NUM_THREADS").ok()?.trim().parse().ok();
    let chosen = Some(THREADS.load(Ordering::Relaxed)).filter(|threads| *threads > 0);
    let chosen = chosen.or_else(|| from_environment().filter(|threads| (1..=MAX_THREADS).contains(threads)));
    chosen.unwrap_or_else(|| thread::available_parallelism().map_or(1, NonZeroUsize::get))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order_for_any_number_of_threads() {
        let jobs: Vec<u64> = (0..100).collect();
        for threads in [0, 1, 3, 1000] {
            let doubled = map(threads, &jobs, |job| Ok::<u64, ()>(2 * job));
            assert!(doubled.is_ok_and(|doubled| doubled.into_iter().eq((0..100).map(|job| 2 * job))));
            assert_eq!(map(threads, &jobs, |job| if *job == 7 { Err("job 7") } else { Ok(()) }), Err("job 7"));
        }
        assert_eq!(map(2, &[], |()| Ok::<(), ()>(())), Ok(Vec::new()));
    }

    #[test]
    #[should_panic(expected = "job 7")]
    fn propagates_a_panic() {
        let _ = map(2, &[1, 7, 8], |job| if *job == 7 { panic!("job 7") } else { Ok::<(), ()>(()) });
    }
}
