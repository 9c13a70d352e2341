//! Thread pool of the studies.

use std::num::NonZeroUsize;
use std::sync::mpsc::{self, Sender};
use std::thread;

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Builds a pool of `threads` threads, or one per core if `threads` is 0, but at most one per job.
///
/// # Panics
/// Panics if the system cannot start the threads.
pub(crate) fn build_pool(threads: usize, jobs: usize) -> ThreadPool {
    // Set explicitly: by default, rayon reads an environment variable first.
    let threads = if threads == 0 { all_cores() } else { threads };
    ThreadPoolBuilder::new().num_threads(threads.min(jobs).max(1)).build().expect("the system starts threads")
}

/// Runs the jobs in parallel and returns their results in the order of the jobs. Messages that `work` sends are passed
/// to `on_message` on the calling thread.
pub fn map<J: Sync, R: Send, N: Send>(
    threads: usize,
    jobs: &[J],
    work: impl Fn(&J, &Sender<N>) -> R + Sync,
    on_message: impl FnMut(N),
) -> Vec<R> {
    let mut results = Vec::new();
    let (sender, messages) = mpsc::channel();
    build_pool(threads, jobs.len()).in_place_scope(|scope| {
        scope.spawn(|_| {
            // Dropped at the end of this closure, which ends the loop over the messages.
            let sender = sender;
            // Split down to single jobs, because their run times differ by up to a factor of a thousand.
            results = jobs.par_iter().with_max_len(1).map(|job| work(job, &sender)).collect();
        });
        messages.into_iter().for_each(on_message);
    });
    results
}

/// Number of cores available to the process.
pub fn all_cores() -> usize {
    thread::available_parallelism().map_or(1, NonZeroUsize::get)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order_and_all_messages_arrive() {
        let jobs: Vec<u64> = (0..100).collect();
        for threads in [0, 1, 3, 1000] {
            let mut sum = 0;
            let doubled = |&job: &u64, messages: &Sender<u64>| messages.send(job).map(|()| 2 * job);
            let results: Result<Vec<u64>, _> =
                map(threads, &jobs, doubled, |message| sum += message).into_iter().collect();
            assert!(results.is_ok_and(|results| results.into_iter().eq((0..100).map(|job| 2 * job))));
            assert_eq!(sum, 4950);
        }
        assert!(map(2, &[], |&(): &(), _: &Sender<()>| (), |()| ()).is_empty());
    }

    #[test]
    #[should_panic(expected = "job 7")]
    fn propagates_a_panic() {
        map(2, &[1, 7, 8], |&job, _: &Sender<()>| assert_ne!(job, 7, "job 7"), |()| ());
    }
}
