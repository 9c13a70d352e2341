//! Progress line on stderr with the remaining time, and signals that interrupt a command. The line is shown only on a
//! terminal, only for commands that take longer than a second, and not with `--quiet`. The first signal ends a command
//! in an orderly way, the second one immediately.

use std::fmt::Write;
use std::fs;
use std::io::{self, IsTerminal};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::Failure;
use super::output::is_quiet;
use crate::format::format_duration;
use phalanx_parallel::Monitor;

/// Time before the line is shown.
const DISPLAY_DELAY: Duration = Duration::from_secs(1);
/// Shortest time between two updates; the clock is updated even without progress.
const UPDATE_INTERVAL: Duration = Duration::from_millis(200);

/// Length of the progress bar for a whole run.
const BAR_LENGTH: f64 = 1e4;

/// Progress line that is shown after [`DISPLAY_DELAY`], if at all, and cleared at the end.
pub(crate) struct Progress {
    bar: ProgressBar,
    has_started: bool,
    /// Dropped at the end, which ends the thread that shows the bar; `None` if the bar is never shown.
    closed: Option<Sender<()>>,
}

impl Progress {
    pub(crate) fn new() -> Self {
        let bar = ProgressBar::with_draw_target(Some(1), ProgressDrawTarget::hidden()).with_style(style());
        if is_quiet() || !io::stderr().is_terminal() {
            return Progress { bar, has_started: false, closed: None };
        }
        let (closed, receiver) = channel();
        let shown_bar = bar.clone();
        thread::spawn(move || {
            if receiver.recv_timeout(DISPLAY_DELAY) == Err(RecvTimeoutError::Timeout) {
                shown_bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(5));
                shown_bar.enable_steady_tick(UPDATE_INTERVAL);
            }
        });
        Progress { bar, has_started: false, closed: Some(closed) }
    }

    /// Shows the simulated time of a run; an infinite duration is unknown.
    pub(crate) fn show_time(&mut self, time_s: f64, duration_s: f64) {
        let position = (BAR_LENGTH * (time_s / duration_s).clamp(0.0, 1.0)) as u64;
        // Samples are far more frequent than changes of the line.
        if self.closed.is_some() && (position != self.bar.position() || position == 0) {
            self.bar.set_length(BAR_LENGTH as u64);
            self.bar.set_position(position);
            self.bar.set_message(format_progress(time_s, duration_s));
        }
    }

    /// Shows how many of several parts are completed, and the name of the next one.
    pub(crate) fn show_count(&mut self, done: usize, total: usize, next: &str) {
        let separator = if next.is_empty() { "" } else { ", " };
        self.bar.set_length(total as u64);
        self.bar.set_message(format!("{done} of {total}{separator}{next}"));
        self.bar.set_position(done as u64);
        // Runs of earlier commands do not count for the remaining time.
        if !std::mem::replace(&mut self.has_started, true) {
            self.bar.reset_eta();
        }
    }

    /// Clears the line.
    pub(crate) fn clear(&mut self) {
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
    let format_time = |time: Duration| match time.as_secs_f64() {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    };
    let left = left.map_or_else(String::new, |left| format!(", {} left", format_time(left)));
    format_time(elapsed) + &left
}

fn format_progress(time_s: f64, duration_s: f64) -> String {
    match duration_s.is_finite() {
        true => format!("{} of {}", format_duration(time_s), format_duration(duration_s)),
        false => format_duration(time_s),
    }
}

/// Signals that are handled, with their names in messages.
const SIGNALS: &[(i32, &str)] = &[
    (SIGINT, "SIGINT (Ctrl-C)"),
    (SIGTERM, "SIGTERM"),
    #[cfg(unix)]
    (SIGHUP, HANGUP),
];
/// A closing terminal sends this signal, often twice.
const HANGUP: &str = "SIGHUP";

/// Makes writes beyond the file size limit (`ulimit -f`) fail with an error, as on a full disk, instead of killing the
/// process.
pub(crate) fn fail_writes_beyond_file_limit() {
    #[cfg(unix)]
    let _ = flag::register(SIGXFSZ, Arc::default());
}

/// Returns whether the process ignores SIGHUP (`nohup`), or whether this is unknown.
fn ignores_hangup() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    mask.is_none_or(|mask| mask & 1 == 1)
}

/// Records whether a signal has interrupted the command.
#[derive(Debug)]
pub(crate) struct Interrupt {
    /// Index of the signal in [`SIGNALS`] plus 1; 0 if none has arrived.
    signal: Arc<AtomicUsize>,
}

impl Interrupt {
    /// Installs the signal handlers.
    pub(crate) fn listen() -> Result<Self, Failure> {
        let signal = Arc::new(AtomicUsize::new(0));
        let already_received = Arc::new(AtomicBool::new(false));
        for (index, &(number, name)) in SIGNALS.iter().enumerate() {
            let is_hangup = name == HANGUP;
            if is_hangup && ignores_hangup() {
                continue;
            }
            // The order matters: the first signal finds `already_received` unset and sets it, the second one kills.
            let register_kill =
                |received| (!is_hangup).then(|| flag::register_conditional_default(number, received)).transpose();
            register_kill(Arc::clone(&already_received))
                .and_then(|_| flag::register(number, Arc::clone(&already_received)))
                .and_then(|_| flag::register_usize(number, Arc::clone(&signal), index + 1))
                .map_err(|error| Failure::incomplete(format!("cannot install signal handlers: {error}")))?;
        }
        Ok(Interrupt { signal })
    }

    /// Returns the name of the signal that has arrived.
    pub(crate) fn signal(&self) -> Option<&'static str> {
        let index = self.signal.load(Ordering::Relaxed).checked_sub(1)?;
        SIGNALS.get(index).map(|(_, name)| *name)
    }

    /// Returns whether no signal has arrived.
    pub(crate) fn keep_running(&self) -> bool {
        self.signal().is_none()
    }

    /// Returns an error once a signal has arrived; called between the files of a command.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        self.signal().map_or(Ok(()), |signal| {
            Err(Failure::incomplete(format!(
                "interrupted by {signal} while the files were written; each file is complete, but some are missing or older"
            )))
        })
    }

    /// Performs a computation with a progress line until a signal arrives. `task` and the names of its `parts` begin the
    /// message of an interruption; `consequence` is its end.
    pub(crate) fn compute<T, E: Into<Failure>>(
        &self,
        [task, parts, consequence]: [&str; 3],
        work: impl FnOnce(&Monitor<'_>) -> Result<T, E>,
    ) -> Result<T, Failure> {
        let mut progress = Progress::new();
        let mut counts = (0, 0);
        let report = |done: usize, total: usize, next: &str| {
            counts = (done, total.max(done));
            progress.show_count(counts.0, counts.1, next);
        };
        let result = work(&Monitor::new(report, &|| self.keep_running()));
        progress.clear();
        result.map_err(|error| match self.signal() {
            None => error.into(),
            Some(signal) => Failure::incomplete(format!(
                "{task} was interrupted by {signal} after {} of {} {parts}; {consequence}",
                counts.0, counts.1
            )),
        })
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
