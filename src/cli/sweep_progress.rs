//! How far a sweep, or a part of one, has come.

use std::time::{Duration, Instant};

use super::progress::Count;
use crate::study::sweep::{self, Row};

/// How far a sweep has come.
pub struct SoFar {
    pub count: Count,
    pub total: u64,
    pub done: u64,
    pub simulations: u64,
    failed: u64,
    refused: u64,
    start: Instant,
    next: Duration,
}

impl SoFar {
    /// With so many done before this sweep.
    pub fn new(total: u64, done: u64) -> Self {
        let (mut count, start) = (Count::new(), Instant::now());
        count.show(done as usize, total as usize, "");
        SoFar { count, total, done, simulations: 0, failed: 0, refused: 0, start, next: Duration::ZERO }
    }

    /// Counts a row that was found.
    pub fn take(&mut self, row: &Row) {
        self.done += 1;
        match row.status {
            sweep::Status::Completed => self.simulations += 1,
            sweep::Status::Failed => (self.simulations, self.failed) = (self.simulations + 1, self.failed + 1),
            sweep::Status::Refused => self.refused += 1,
            sweep::Status::Filtered => {}
        }
        let elapsed = self.start.elapsed();
        // Texts are made only as often as somebody can read them.
        if elapsed >= self.next {
            self.next = elapsed + Duration::from_millis(100);
            let text = format!("{} failed, {} refused", self.failed, self.refused);
            self.count.show(self.done as usize, self.total as usize, &text);
        }
    }
}
