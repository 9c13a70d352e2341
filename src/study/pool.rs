//! The threads of a study.

use std::num::NonZeroUsize;
use std::sync::mpsc::{self, Sender};
use std::thread;

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// So many threads, or one for each core where 0 are asked for, but no more than there are jobs.
///
/// # Panics
/// If the system has no more threads to give.
pub fn pool(threads: usize, jobs: usize) -> ThreadPool {
    // Said here: left to itself, rayon asks a variable of the environment first.
    let threads = if threads == 0 { all_cores() } else { threads };
    ThreadPoolBuilder::new().num_threads(threads.min(jobs).max(1)).build().expect("the system starts threads")
}

/// What comes of each job, in the order of the jobs. Whatever `work` sends meanwhile is `heard` on the thread that asks.
pub fn map<J: Sync, R: Send, N: Send>(
    threads: usize,
    jobs: &[J],
    work: impl Fn(&J, &Sender<N>) -> R + Sync,
    heard: impl FnMut(N),
) -> Vec<R> {
    let mut found = Vec::new();
    let (sender, notes) = mpsc::channel();
    pool(threads, jobs.len()).in_place_scope(|scope| {
        scope.spawn(|_| {
            // Dropped in here: the end of the notes is the end of the work.
            let sender = sender;
            // Halved down to single jobs: some take a thousand times as long as others.
            found = jobs.par_iter().with_max_len(1).map(|job| work(job, &sender)).collect();
        });
        notes.into_iter().for_each(heard);
    });
    found
}

/// The cores of this machine.
pub fn all_cores() -> usize {
    thread::available_parallelism().map_or(1, NonZeroUsize::get)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_and_notes_as_they_are_sent() {
        let jobs: Vec<u64> = (0..100).collect();
        for threads in [0, 1, 3, 1000] {
            let mut heard = 0;
            let twice = |&job: &u64, notes: &Sender<u64>| notes.send(job).map(|()| 2 * job);
            let found: Result<Vec<u64>, _> = map(threads, &jobs, twice, |note| heard += note).into_iter().collect();
            assert!(found.is_ok_and(|found| found.into_iter().eq((0..100).map(|job| 2 * job))));
            assert_eq!(heard, 4950);
        }
        assert!(map(2, &[], |&(): &(), _: &Sender<()>| (), |()| ()).is_empty());
    }

    #[test]
    #[should_panic(expected = "job 7")]
    fn a_panic_is_passed_on() {
        map(2, &[1, 7, 8], |&job, _: &Sender<()>| assert_ne!(job, 7, "job 7"), |()| ());
    }
}
