//! Work without the interpreter's lock. Other threads of Python go on meanwhile, and Ctrl-C ends the work in good order.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

/// How often Python is asked for signals: nobody feels so much, and it costs nothing that can be measured.
const PATIENCE: Duration = Duration::from_millis(50);

/// Does some work on a thread of its own; `go_on` turns false when Ctrl-C has been pressed, and that is then raised.
///
/// A panic of the work is one here, which becomes an exception.
pub fn free<T: Send>(py: Python<'_>, work: impl FnOnce(&(dyn Fn() -> bool + Sync)) -> T + Send) -> PyResult<T> {
    let stopped = AtomicBool::new(false);
    py.detach(|| {
        thread::scope(|scope| {
            let (over, waited) = mpsc::channel::<()>();
            let worker = scope.spawn(|| {
                // Dropped with the work, whatever ends that.
                let _over = over;
                work(&|| !stopped.load(Ordering::Relaxed))
            });
            let mut signal = None;
            while waited.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                // Only the first one is raised; until the work is over there is nothing more to say.
                if let (None, Err(error)) = (&signal, Python::attach(|py| py.check_signals())) {
                    stopped.store(true, Ordering::Relaxed);
                    signal = Some(error);
                }
            }
            match (worker.join(), signal) {
                (Err(panic), _) => resume_unwind(panic),
                (Ok(_), Some(signal)) => Err(signal),
                (Ok(found), None) => Ok(found),
            }
        })
    })
}
