//! A line on stderr that says how far a run has come: only on a terminal, and only if the run takes over a second.

use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

use crate::report::duration;
use crate::trace::{Event, Sample, Sink, SinkError};

/// Nothing is shown before this.
const PATIENCE: Duration = Duration::from_secs(1);
/// Shortest time between two updates.
const INTERVAL: Duration = Duration::from_millis(200);

/// A [`Sink`] that shows the time reached.
pub struct Progress {
    duration_s: f64,
    start: Instant,
    next: Duration,
    terminal: bool,
    shown: bool,
}

impl Progress {
    pub fn new(duration_s: f64) -> Self {
        Progress {
            duration_s,
            start: Instant::now(),
            next: PATIENCE,
            terminal: io::stderr().is_terminal(),
            shown: false,
        }
    }

    /// Wipes the line.
    pub fn clear(&mut self) {
        if self.shown {
            self.shown = false;
            let _ = write!(io::stderr().lock(), "\r\x1b[K");
        }
    }
}

impl Sink for Progress {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if !self.terminal {
            return Ok(());
        }
        let elapsed = self.start.elapsed();
        if elapsed < self.next {
            return Ok(());
        }
        self.next = elapsed + INTERVAL;
        self.shown = true;
        // A terminal that cannot be written to is no reason to stop a simulation.
        let mut stderr = io::stderr().lock();
        let _ =
            write!(stderr, "\r\x1b[K{}", line(sample.time_s, self.duration_s, elapsed)).and_then(|()| stderr.flush());
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

fn line(time_s: f64, duration_s: f64, elapsed: Duration) -> String {
    let share = (time_s / duration_s).clamp(0.0, 1.0);
    let cells = (20.0 * share) as usize;
    format!(
        "[{}{}] {:3.0} %  {} of {}  {:.0} s",
        "#".repeat(cells),
        " ".repeat(20 - cells),
        100.0 * share,
        duration(time_s),
        duration(duration_s),
        elapsed.as_secs_f64()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_says_how_far_the_run_has_come() {
        let text = line(5e-3, 20e-3, Duration::from_secs(3));
        assert_eq!(text, "[#####               ]  25 %  5 ms of 20 ms  3 s");
    }
}
