//! Signals that interrupt a command. The first signal ends the command in an orderly way, the second one immediately.

use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGXFSZ};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::Failure;
use super::progress::RunCounter;
use crate::integrator::Reason;

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

/// Computes a study with a progress line of its `parts`, until a signal arrives. The study reports how many parts are
/// done and their total. `failure` converts an error, with the name of the signal if one has arrived.
pub fn run_study<T, E>(
    parts: &str,
    study: impl FnOnce(&mut (dyn FnMut(u64, u64) + Send), &(dyn Fn() -> bool + Sync)) -> Result<T, E>,
    failure: impl FnOnce(E, Option<&'static str>) -> Failure,
) -> Result<T, Failure> {
    let interrupt = Interrupt::listen()?;
    let mut counter = RunCounter::new();
    let mut progress = |done: u64, total: u64| counter.update(done as usize, total as usize, parts);
    let result = study(&mut progress, &|| interrupt.signal().is_none());
    counter.clear();
    result.map_err(|error| failure(error, interrupt.signal()))
}

/// Returns the failure of a command that a signal ended. With `--out`, it states that no file was written.
pub fn interrupted(message: &str, has_out: bool) -> Failure {
    let unwritten = if has_out { "; no file was written, and existing files are unchanged" } else { "" };
    Failure::incomplete(format!("{message}{unwritten}"))
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
    pub fn signal(&self) -> Option<&'static str> {
        let index = self.signal.load(Ordering::Relaxed).checked_sub(1)?;
        SIGNALS.get(index).map(|(_, name)| *name)
    }

    /// Returns an error once a signal has arrived; called between the files of a command.
    pub fn check(&self) -> Result<(), Failure> {
        match self.signal() {
            None => Ok(()),
            Some(signal) => Err(Failure::incomplete(format!(
                "interrupted by {signal} while the files were written; each file is complete, but some are missing or older"
            ))),
        }
    }

    /// Returns an owned function that reports whether a signal has arrived.
    #[cfg_attr(not(feature = "live"), expect(dead_code))]
    pub(crate) fn stop_flag(&self) -> impl Fn() -> bool + Send + use<> {
        let signal = Arc::clone(&self.signal);
        move || signal.load(Ordering::Relaxed) != 0
    }

    /// Describes why a run ended; a stop is described by the signal that caused it.
    pub fn describe_reason(&self, reason: &Reason) -> String {
        match (reason, self.signal()) {
            (Reason::Stopped, Some(signal)) => format!("interrupted by {signal}"),
            _ => reason.to_string(),
        }
    }
}
