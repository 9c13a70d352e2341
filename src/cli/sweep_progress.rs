//! Progress of a sweep or of a part of one.

use std::time::{Duration, Instant};

use super::progress::RunCounter;
use crate::study::sweep::{self, Row};

/// Progress of a sweep.
pub struct SweepProgress {
    pub counter: RunCounter,
    pub total: u64,
    pub done: u64,
    pub simulations: u64,
    failed: u64,
    refused: u64,
    start: Instant,
    next_update: Duration,
}

impl SweepProgress {
    /// Creates the progress; `done` runs were completed by earlier commands.
    pub fn new(total: u64, done: u64) -> Self {
        let (mut counter, start) = (RunCounter::new(), Instant::now());
        counter.update(done as usize, total as usize, "");
        SweepProgress {
            counter,
            total,
            done,
            simulations: 0,
            failed: 0,
            refused: 0,
            start,
            next_update: Duration::ZERO,
        }
    }

    /// Counts a new row.
    pub fn record(&mut self, row: &Row) {
        self.done += 1;
        match row.status {
            sweep::Status::Completed => self.simulations += 1,
            sweep::Status::Failed => (self.simulations, self.failed) = (self.simulations + 1, self.failed + 1),
            sweep::Status::Refused => self.refused += 1,
            sweep::Status::Filtered => {}
        }
        let elapsed = self.start.elapsed();
        // Updates more frequent than this cannot be read.
        if elapsed >= self.next_update {
            self.next_update = elapsed + Duration::from_millis(100);
            let text = format!("{} failed, {} refused", self.failed, self.refused);
            self.counter.update(self.done as usize, self.total as usize, &text);
        }
    }
}
