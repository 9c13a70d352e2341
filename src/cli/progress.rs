//! A line on stderr that says how far a command has come: only on a terminal, and only if it takes over a second.

use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

use crate::report::duration;
use crate::trace::bodies::{BodiesEvent, BodiesSample, BodiesSink};
use crate::trace::{Event, Sample, Sink, SinkError};

/// Nothing is shown before this.
const PATIENCE: Duration = Duration::from_secs(1);
/// Shortest time between two updates.
const INTERVAL: Duration = Duration::from_millis(200);

/// The line itself: shown late, renewed seldom, wiped at the end.
struct Line {
    start: Instant,
    next: Duration,
    terminal: bool,
    shown: bool,
}

impl Line {
    fn new() -> Self {
        Line { start: Instant::now(), next: PATIENCE, terminal: io::stderr().is_terminal(), shown: false }
    }

    /// Shows what `text` makes of the time passed, if it is time to.
    fn show(&mut self, text: impl FnOnce(Duration) -> String) {
        if !self.terminal {
            return;
        }
        let elapsed = self.start.elapsed();
        if elapsed < self.next {
            return;
        }
        self.next = elapsed + INTERVAL;
        self.shown = true;
        // A terminal that cannot be written to is no reason to stop a simulation.
        let mut stderr = io::stderr().lock();
        let _ = write!(stderr, "\r\x1b[K{}", text(elapsed)).and_then(|()| stderr.flush());
    }

    fn clear(&mut self) {
        if self.shown {
            self.shown = false;
            let _ = write!(io::stderr().lock(), "\r\x1b[K");
        }
    }
}

/// A [`Sink`] that shows the time reached.
pub struct Progress {
    duration_s: f64,
    line: Line,
}

impl Progress {
    pub fn new(duration_s: f64) -> Self {
        Progress { duration_s, line: Line::new() }
    }

    /// Shows a time that has been reached.
    pub fn reached(&mut self, time_s: f64) {
        let duration_s = self.duration_s;
        self.line.show(|elapsed| line(time_s, duration_s, elapsed));
    }

    /// Wipes the line.
    pub fn clear(&mut self) {
        self.line.clear();
    }
}

impl Sink for Progress {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.reached(sample.time_s);
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

impl BodiesSink for Progress {
    fn sample(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        self.reached(sample.time_s);
        Ok(())
    }

    fn event(&mut self, _: &BodiesEvent) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Shows how many of several runs are done, and which comes next.
pub struct Count {
    line: Line,
}

impl Count {
    pub fn new() -> Self {
        Count { line: Line::new() }
    }

    pub fn show(&mut self, done: usize, total: usize, next: &str) {
        self.line.show(|elapsed| count(done, total, next, elapsed));
    }

    /// Wipes the line.
    pub fn clear(&mut self) {
        self.line.clear();
    }
}

fn bar(share: f64) -> String {
    let cells = (20.0 * share) as usize;
    format!("[{}{}] {:3.0} %", "#".repeat(cells), " ".repeat(20 - cells), 100.0 * share)
}

fn line(time_s: f64, duration_s: f64, elapsed: Duration) -> String {
    let share = (time_s / duration_s).clamp(0.0, 1.0);
    let seconds = elapsed.as_secs_f64();
    format!("{}  {} of {}  {seconds:.0} s", bar(share), duration(time_s), duration(duration_s))
}

fn count(done: usize, total: usize, next: &str, elapsed: Duration) -> String {
    let share = (done as f64 / total.max(1) as f64).clamp(0.0, 1.0);
    format!("{}  {done} of {total}  {:.0} s  {next}", bar(share), elapsed.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_says_how_far_the_run_has_come() {
        let text = line(5e-3, 20e-3, Duration::from_secs(3));
        assert_eq!(text, "[#####               ]  25 %  5 ms of 20 ms  3 s");
        let text = count(3, 4, "analytic", Duration::from_secs(8));
        assert_eq!(text, "[###############     ]  75 %  3 of 4  8 s  analytic");
    }
}
