//! Signals that ask a command to end: the first one ends it in good order, the second one at once.

use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::Failure;
use crate::integrator::Reason;

/// Signals that are listened to, as people know them.
const SIGNALS: &[(i32, &str)] = &[
    (SIGINT, "SIGINT (Ctrl-C)"),
    (SIGTERM, "SIGTERM"),
    #[cfg(unix)]
    (SIGHUP, HANGUP),
];
/// A terminal that closes sends it, often twice.
const HANGUP: &str = "SIGHUP";

/// Lets a write beyond the largest size of a file (`ulimit -f`) fail with an error, as on a full disk, instead of killing the process.
pub fn survive_file_limits() {
    #[cfg(unix)]
    let _ = flag::register(SIGXFSZ, Arc::default());
}

/// Whether the process was started to outlive its terminal (`nohup`), or may have been.
fn ignores_hangup() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    mask.is_none_or(|mask| mask & 1 == 1)
}

/// What a command says that a signal has ended after some of its parts.
pub fn broken_off(what: &str, signal: &str, (done, total): (usize, usize), out: bool) -> Failure {
    let files = if out { "; no file was written, and older ones are as they were" } else { "" };
    Failure::incomplete(format!(
        "{what} was interrupted by {signal} after {done} of {total} parts: there is no result{files}"
    ))
}

/// Whether the command has been asked to end.
#[derive(Debug)]
pub struct Interrupt {
    /// One more than the index of the signal; 0 before any.
    signal: Arc<AtomicUsize>,
}

impl Interrupt {
    /// Listens from now on.
    pub fn listen() -> Result<Self, Failure> {
        let signal = Arc::new(AtomicUsize::new(0));
        let again = Arc::new(AtomicBool::new(false));
        for (index, &(number, name)) in SIGNALS.iter().enumerate() {
            let hangup = name == HANGUP;
            if hangup && ignores_hangup() {
                continue;
            }
            // In this order: the first signal finds `again` unset and sets it, the second one kills.
            let kills = |again| (!hangup).then(|| flag::register_conditional_default(number, again)).transpose();
            kills(Arc::clone(&again))
                .and_then(|_| flag::register(number, Arc::clone(&again)))
                .and_then(|_| flag::register_usize(number, Arc::clone(&signal), index + 1))
                .map_err(|error| Failure::incomplete(format!("cannot listen to signals: {error}")))?;
        }
        Ok(Interrupt { signal })
    }

    /// The signal that has come.
    pub fn signal(&self) -> Option<&'static str> {
        let index = self.signal.load(Ordering::Relaxed).checked_sub(1)?;
        SIGNALS.get(index).map(|(_, name)| *name)
    }

    /// An error once a signal has come, for who writes several files.
    pub fn check(&self) -> Result<(), Failure> {
        match self.signal() {
            None => Ok(()),
            Some(signal) => Err(Failure::incomplete(format!(
                "interrupted by {signal} while the files were written: older ones are as they were"
            ))),
        }
    }

    /// Whether a signal has come, for who cannot keep a reference.
    #[cfg_attr(not(feature = "live"), expect(dead_code))]
    pub fn watch(&self) -> impl Fn() -> bool + Send + use<> {
        let signal = Arc::clone(&self.signal);
        move || signal.load(Ordering::Relaxed) != 0
    }

    /// Why a run ended: in place of a stop, the signal that made it.
    pub fn reason(&self, reason: &Reason) -> String {
        match (reason, self.signal()) {
            (Reason::Stopped, Some(signal)) => format!("interrupted by {signal}"),
            _ => reason.to_string(),
        }
    }
}
