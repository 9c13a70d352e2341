//! Simulated time against the wall clock.

use std::thread;
use std::time::{Duration, Instant};

/// Longest sleep: how soon an interrupt is noticed, and how often the time is announced.
const SLICE: Duration = Duration::from_millis(25);

/// When what happens at a simulated time is due.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Simulated seconds per second.
    speed: f64,
    /// Wall clock at simulated time 0.
    start: Option<Instant>,
}

impl Pace {
    /// The clock starts when something later than 0 is first waited for.
    pub fn new(speed: f64) -> Self {
        Pace { speed, start: None }
    }

    /// Waits until the simulated time is due; in between, hands what it is now (in ns) to `announce`, and gives up when
    /// `stop` says so.
    pub fn wait(&mut self, time_ns: u64, mut announce: impl FnMut(u64), stop: impl Fn() -> bool) {
        if time_ns == 0 {
            return;
        }
        let start = *self.start.get_or_insert_with(Instant::now);
        let due_s = time_ns as f64 * 1e-9 / self.speed;
        loop {
            let passed_s = start.elapsed().as_secs_f64();
            if passed_s >= due_s || stop() {
                return;
            }
            announce((passed_s * self.speed * 1e9) as u64);
            thread::sleep(SLICE.min(Duration::from_secs_f64(due_s - passed_s)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simulated_time_passes_at_the_speed_asked_for() {
        let mut pace = Pace::new(0.1);
        let mut heard = Vec::new();
        let start = Instant::now();
        pace.wait(0, |_| panic!("nothing to wait for"), || false);
        pace.wait(10_000_000, |now_ns| heard.push(now_ns), || false);
        assert!(start.elapsed() >= Duration::from_millis(100));
        assert!(!heard.is_empty() && heard.is_sorted() && heard.iter().all(|now_ns| *now_ns < 10_000_000), "{heard:?}");
        // What is due already does not wait.
        pace.wait(1, |_| panic!("nothing to wait for"), || false);
    }

    #[test]
    fn waiting_ends_when_it_is_told_to() {
        let mut pace = Pace::new(1e-6);
        let start = Instant::now();
        pace.wait(1_000_000_000, |_| {}, || start.elapsed() > Duration::from_millis(50));
        assert!(start.elapsed() < Duration::from_secs(60));
    }
}
