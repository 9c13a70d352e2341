//! Cancellation of long computations within a step.

use std::cell::Cell;

/// Work between two checks for cancellation, in multiplications: about a millisecond.
pub(crate) const WORK_BETWEEN_CHECKS: usize = 1 << 20;

/// Cancellation of a computation whose parts can take seconds: with a thousand contacts, one elimination has 10¹⁰
/// multiplications.
pub(crate) struct Cancellation<'a> {
    keep_running: &'a dyn Fn() -> bool,
    /// Work since the last check.
    work: Cell<usize>,
}

impl<'a> Cancellation<'a> {
    pub fn new(keep_running: &'a dyn Fn() -> bool) -> Self {
        Self { keep_running, work: Cell::new(0) }
    }

    /// Adds work, in multiplications. Returns false once the computation is cancelled.
    #[inline]
    pub fn add_work(&self, work: usize) -> bool {
        let total = self.work.get() + work;
        let is_running = total < WORK_BETWEEN_CHECKS || (self.keep_running)();
        self.work.set(if is_running { total % WORK_BETWEEN_CHECKS } else { WORK_BETWEEN_CHECKS });
        is_running
    }
}

#[cfg(test)]
mod tests {
    use super::{Cancellation, WORK_BETWEEN_CHECKS};
    use crate::numeric::dense::solve;
    use std::cell::Cell;

    #[test]
    fn a_long_elimination_is_cancelled() {
        let size: usize = 300;
        let matrix: Vec<f64> =
            (0..size * size).map(|at: usize| 1.0 / (1.0 + (at / size).abs_diff(at % size) as f64)).collect();
        let work: usize = (0..size).map(|k| (size - k) * (size - k)).sum();
        for last in [u32::MAX, 3, 1] {
            let checks = Cell::new(0);
            let keep_running = || {
                checks.set(checks.get() + 1);
                checks.get() < last
            };
            let cancellation = Cancellation::new(&keep_running);
            let solved = solve(&mut matrix.clone(), &mut vec![1.0; size], size, |work| cancellation.add_work(work));
            assert_eq!(solved, last == u32::MAX);
            match solved {
                true => assert_eq!(checks.get() as usize, work / WORK_BETWEEN_CHECKS),
                false => {
                    assert_eq!(checks.get(), last);
                    // A cancelled computation stays cancelled.
                    assert!(!cancellation.add_work(1));
                }
            }
        }
    }
}
