//! Synchronizes simulated time with the wall clock.

use std::thread;
use std::time::{Duration, Instant};

/// Longest sleep; limits the delay of an interrupt and the interval of time announcements.
const MAX_SLEEP: Duration = Duration::from_millis(25);

/// Delays a simulation so that it advances at a given multiple of real time.
#[derive(Clone, Copy, Debug)]
pub struct RealTimePacer {
    /// Simulated time per wall-clock time.
    speed: f64,
    /// Wall clock at simulated time 0.
    start: Option<Instant>,
}

impl RealTimePacer {
    /// Creates a pacer; its clock starts at the first [`wait`](Self::wait) for a simulated time above 0.
    pub fn new(speed: f64) -> Self {
        RealTimePacer { speed, start: None }
    }

    /// Waits until the simulated time is due. Meanwhile passes the current simulated time, ns, to `announce`; returns
    /// early if `stop` returns true.
    pub fn wait(&mut self, time_ns: u64, mut announce: impl FnMut(u64), stop: impl Fn() -> bool) {
        if time_ns == 0 {
            return;
        }
        let start = *self.start.get_or_insert_with(Instant::now);
        let due_s = time_ns as f64 * 1e-9 / self.speed;
        loop {
            let elapsed_s = start.elapsed().as_secs_f64();
            if elapsed_s >= due_s || stop() {
                return;
            }
            announce((elapsed_s * self.speed * 1e9) as u64);
            thread::sleep(MAX_SLEEP.min(Duration::from_secs_f64(due_s - elapsed_s)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paces_simulated_time_at_the_requested_speed() {
        let mut pacer = RealTimePacer::new(0.1);
        let mut reported_times = Vec::new();
        let start = Instant::now();
        pacer.wait(0, |_| panic!("nothing to wait for"), || false);
        pacer.wait(10_000_000, |now_ns| reported_times.push(now_ns), || false);
        assert!(start.elapsed() >= Duration::from_millis(100));
        assert!(
            !reported_times.is_empty()
                && reported_times.is_sorted()
                && reported_times.iter().all(|now_ns| *now_ns < 10_000_000),
            "{reported_times:?}"
        );
        // A time in the past causes no wait.
        pacer.wait(1, |_| panic!("nothing to wait for"), || false);
    }

    #[test]
    fn waiting_stops_on_request() {
        let mut pacer = RealTimePacer::new(1e-6);
        let start = Instant::now();
        pacer.wait(1_000_000_000, |_| {}, || start.elapsed() > Duration::from_millis(50));
        assert!(start.elapsed() < Duration::from_secs(60));
    }
}
