//! A line on stderr that says how far a command has come and how long it takes yet: only on a terminal, only if it takes over a
//! second, and not with `--quiet`.

use std::fmt::Write;
use std::io::{self, IsTerminal};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use super::output::is_quiet;
use crate::trace::{Event, Sample, Sink, SinkError};
use crate::wording::duration;

/// Nothing is shown before this.
const PATIENCE: Duration = Duration::from_secs(1);
/// Shortest time between two updates; the clock goes on even where nothing is reached.
const INTERVAL: Duration = Duration::from_millis(200);

/// What a whole run is divided into.
const SHARES: f64 = 1e4;

/// The line itself: shown late, renewed seldom, wiped at the end. `None` where nobody would see it.
struct Line(Option<Shown>);

struct Shown {
    bar: ProgressBar,
    /// Gone with the line: nothing is shown from then on.
    _over: Sender<()>,
}

impl Line {
    fn new() -> Self {
        if is_quiet() || !io::stderr().is_terminal() {
            return Line(None);
        }
        let bar = ProgressBar::with_draw_target(Some(1), ProgressDrawTarget::hidden()).with_style(style());
        let (over, waited) = channel();
        let late = bar.clone();
        thread::spawn(move || {
            if waited.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                late.set_draw_target(ProgressDrawTarget::stderr_with_hz(5));
                late.enable_steady_tick(INTERVAL);
            }
        });
        Line(Some(Shown { bar, _over: over }))
    }

    fn clear(&mut self) {
        if let Some(Shown { bar, .. }) = self.0.take() {
            bar.finish_and_clear();
        }
    }
}

fn style() -> ProgressStyle {
    let style = ProgressStyle::with_template("[{bar:20}] {percent:>3} %  {msg}  {clock}");
    let clock = |state: &ProgressState, out: &mut dyn Write| {
        let left = Some(state.eta()).filter(|left| state.pos() > 0 && !left.is_zero());
        // A line that cannot be written is no reason to stop a simulation.
        let _ = out.write_str(&clock(state.elapsed(), left));
    };
    style.expect("a sound template").progress_chars("# ").with_key("clock", clock)
}

/// The time passed and, once it can be told, the time left.
fn clock(passed: Duration, left: Option<Duration>) -> String {
    match left {
        Some(left) => format!("{}, {} left", span(passed), span(left)),
        None => span(passed),
    }
}

/// A time that people wait.
fn span(time: Duration) -> String {
    match time.as_secs_f64() {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// A [`Sink`] that shows the time reached.
pub struct Progress {
    duration_s: f64,
    line: Line,
}

impl Progress {
    pub fn new(duration_s: f64) -> Self {
        let line = Line::new();
        if let Some(Shown { bar, .. }) = &line.0 {
            bar.set_length(SHARES as u64);
        }
        Progress { duration_s, line }
    }

    /// Shows a time that has been reached.
    pub fn reached(&mut self, time_s: f64) {
        let Some(Shown { bar, .. }) = &self.line.0 else { return };
        let position = (SHARES * (time_s / self.duration_s).clamp(0.0, 1.0)) as u64;
        // Samples come far more often than the line can change.
        if position != bar.position() || position == 0 {
            bar.set_position(position);
            bar.set_message(of(time_s, self.duration_s));
        }
    }

    /// Wipes the line.
    pub fn clear(&mut self) {
        self.line.clear();
    }
}

/// How far a run has come; how far it goes is not always known.
fn of(time_s: f64, duration_s: f64) -> String {
    match duration_s.is_finite() {
        true => format!("{} of {}", duration(time_s), duration(duration_s)),
        false => duration(time_s),
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

/// Shows how many of several runs are done, and which comes next.
pub struct Count {
    line: Line,
    begun: bool,
}

impl Count {
    pub fn new() -> Self {
        Count { line: Line::new(), begun: false }
    }

    pub fn show(&mut self, done: usize, total: usize, next: &str) {
        let Some(Shown { bar, .. }) = &self.line.0 else { return };
        bar.set_length(total as u64);
        bar.set_message(match next.is_empty() {
            true => format!("{done} of {total}"),
            false => format!("{done} of {total}, {next}"),
        });
        bar.set_position(done as u64);
        // What was done before took no time of this command.
        if !std::mem::replace(&mut self.begun, true) {
            bar.reset_eta();
        }
    }

    /// Wipes the line.
    pub fn clear(&mut self) {
        self.line.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_says_how_far_a_command_has_come_and_how_long_it_takes_yet() {
        style();
        assert_eq!(of(5e-3, 20e-3), "5 ms of 20 ms");
        assert_eq!(of(5e-3, f64::INFINITY), "5 ms");
        assert_eq!(clock(Duration::from_secs(3), None), "3 s");
        assert_eq!(clock(Duration::from_secs(90), Some(Duration::from_secs(600))), "90 s, 10 min left");
        assert_eq!(clock(Duration::from_secs(1), Some(Duration::from_secs(9000))), "1 s, 2.5 h left");
    }
}
