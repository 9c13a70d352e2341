//! Progress line on stderr with the remaining time. It is shown only on a terminal, only for commands that take longer
//! than a second, and not with `--quiet`.

use std::fmt::Write;
use std::io::{self, IsTerminal};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use super::output::is_quiet;
use crate::format::format_duration;

/// Time before the line is shown.
const DISPLAY_DELAY: Duration = Duration::from_secs(1);
/// Shortest time between two updates; the clock is updated even without progress.
const UPDATE_INTERVAL: Duration = Duration::from_millis(200);

/// Length of the progress bar for a whole run.
const BAR_LENGTH: f64 = 1e4;

/// Progress line that is shown after [`DISPLAY_DELAY`], if at all, and cleared at the end.
struct ProgressLine {
    bar: ProgressBar,
    /// Dropped with the line, which ends the thread that shows the bar.
    closed: Option<Sender<()>>,
}

impl ProgressLine {
    fn new(length: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::hidden()).with_style(style());
        if is_quiet() || !io::stderr().is_terminal() {
            return ProgressLine { bar, closed: None };
        }
        let (closed, receiver) = channel();
        let shown_bar = bar.clone();
        thread::spawn(move || {
            if receiver.recv_timeout(DISPLAY_DELAY) == Err(RecvTimeoutError::Timeout) {
                shown_bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(5));
                shown_bar.enable_steady_tick(UPDATE_INTERVAL);
            }
        });
        ProgressLine { bar, closed: Some(closed) }
    }

    fn clear(&mut self) {
        self.closed = None;
        self.bar.finish_and_clear();
    }
}

fn style() -> ProgressStyle {
    let style = ProgressStyle::with_template("[{bar:20}] {percent:>3} %  {msg}  {clock}");
    let clock = |state: &ProgressState, out: &mut dyn Write| {
        let left = Some(state.eta()).filter(|left| state.pos() > 0 && !left.is_zero());
        // A failed write must not stop the simulation.
        let _ = out.write_str(&format_clock(state.elapsed(), left));
    };
    style.expect("a valid template").progress_chars("# ").with_key("clock", clock)
}

/// Formats the elapsed time and, once it can be estimated, the remaining time.
fn format_clock(elapsed: Duration, left: Option<Duration>) -> String {
    match left {
        Some(left) => format!("{}, {} left", format_wall_time(elapsed), format_wall_time(left)),
        None => format_wall_time(elapsed),
    }
}

/// Formats a wall time in s, min or h.
fn format_wall_time(time: Duration) -> String {
    match time.as_secs_f64() {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// Shows the simulated time.
pub struct Progress {
    duration_s: f64,
    line: ProgressLine,
}

impl Progress {
    pub fn new(duration_s: f64) -> Self {
        Progress { duration_s, line: ProgressLine::new(BAR_LENGTH as u64) }
    }

    /// Shows the simulated time.
    pub fn update(&mut self, time_s: f64) {
        let ProgressLine { bar, closed: Some(_) } = &self.line else { return };
        let position = (BAR_LENGTH * (time_s / self.duration_s).clamp(0.0, 1.0)) as u64;
        // Samples are far more frequent than changes of the line.
        if position != bar.position() || position == 0 {
            bar.set_position(position);
            bar.set_message(format_progress(time_s, self.duration_s));
        }
    }

    /// Clears the line.
    pub fn clear(&mut self) {
        self.line.clear();
    }
}

/// Formats the simulated time and the duration of the run; an infinite duration is unknown.
fn format_progress(time_s: f64, duration_s: f64) -> String {
    match duration_s.is_finite() {
        true => format!("{} of {}", format_duration(time_s), format_duration(duration_s)),
        false => format_duration(time_s),
    }
}

/// Shows how many of several runs are completed and which one is next.
pub(crate) struct RunCounter {
    line: ProgressLine,
    has_started: bool,
}

impl RunCounter {
    pub fn new() -> Self {
        RunCounter { line: ProgressLine::new(1), has_started: false }
    }

    pub fn update(&mut self, done: usize, total: usize, next: &str) {
        let bar = &self.line.bar;
        bar.set_length(total as u64);
        bar.set_message(match next.is_empty() {
            true => format!("{done} of {total}"),
            false => format!("{done} of {total}, {next}"),
        });
        bar.set_position(done as u64);
        // Runs of earlier commands do not count for the remaining time.
        if !std::mem::replace(&mut self.has_started, true) {
            bar.reset_eta();
        }
    }

    /// Clears the line.
    pub fn clear(&mut self) {
        self.line.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_shows_progress_and_remaining_time() {
        style();
        assert_eq!(format_progress(5e-3, 20e-3), "5 ms of 20 ms");
        assert_eq!(format_progress(5e-3, f64::INFINITY), "5 ms");
        assert_eq!(format_clock(Duration::from_secs(3), None), "3 s");
        assert_eq!(format_clock(Duration::from_secs(90), Some(Duration::from_secs(600))), "90 s, 10 min left");
        assert_eq!(format_clock(Duration::from_secs(1), Some(Duration::from_secs(9000))), "1 s, 2.5 h left");
    }
}
