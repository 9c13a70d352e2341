//! Runs computations without the interpreter lock, so that other Python threads continue and Ctrl-C interrupts the
//! computation.

use std::cell::{Cell, RefCell};
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// Interval between checks for signals: imperceptible to the user, with negligible cost.
const SIGNAL_CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// Runs a computation on the calling thread without the interpreter lock; `keep_running` checks for signals. It is for
/// short runs, in which the start of a thread would be noticeable. The computation must call `keep_running` often, and
/// on the calling thread. After Ctrl-C, `keep_running` returns false, and the signal is raised when the computation has
/// ended.
pub fn run_on_caller<T: Send>(py: Python<'_>, compute: impl FnOnce(&dyn Fn() -> bool) -> T + Send) -> PyResult<T> {
    py.detach(|| {
        let (checked, signal) = (Cell::new(Instant::now()), RefCell::new(None));
        let result = compute(&|| {
            if signal.borrow().is_none() && checked.get().elapsed() >= SIGNAL_CHECK_INTERVAL {
                checked.set(Instant::now());
                signal.replace(Python::attach(|py| py.check_signals()).err());
            }
            signal.borrow().is_none()
        });
        signal.into_inner().map_or(Ok(result), Err)
    })
}

/// Runs a computation that uses several threads, itself on a new thread, without the interpreter lock. After Ctrl-C,
/// `keep_running` returns false, and the signal is raised when the computation has ended.
///
/// A panic of the computation propagates to the caller and becomes a Python exception.
pub fn run<T: Send>(py: Python<'_>, compute: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> T + Send) -> PyResult<T> {
    let interrupted = AtomicBool::new(false);
    py.detach(|| {
        thread::scope(|scope| {
            let (end_sender, end_receiver) = mpsc::channel::<()>();
            let worker = scope.spawn(|| {
                // The sender is dropped when the computation ends or panics, which disconnects the receiver.
                let _end_sender = end_sender;
                compute(&|| !interrupted.load(Ordering::Relaxed))
            });
            let mut signal = None;
            while end_receiver.recv_timeout(SIGNAL_CHECK_INTERVAL) == Err(RecvTimeoutError::Timeout) {
                // Only the first signal is raised; later ones are ignored until the computation ends.
                if let (None, Err(error)) = (&signal, Python::attach(|py| py.check_signals())) {
                    interrupted.store(true, Ordering::Relaxed);
                    signal = Some(error);
                }
            }
            match (worker.join(), signal) {
                (Err(panic), _) => resume_unwind(panic),
                (Ok(_), Some(signal)) => Err(signal),
                (Ok(result), None) => Ok(result),
            }
        })
    })
}
