//! Interface between one-step methods and the integration loop.

use super::{Dense, Linearised, State, System, Tolerances};

/// Result of one attempted step.
#[derive(Clone, Copy, Debug)]
pub struct Attempt<const N: usize, const Z: usize> {
    /// Scaled error; at most 1 is acceptable. NaN if the step failed.
    pub error: f64,
    /// Number of right-hand-side evaluations.
    pub rhs: u64,
    pub end: State<N, Z>,
    /// Estimated errors of coordinates and rates.
    pub error_q: [f64; N],
    pub error_v: [f64; N],
}

impl<const N: usize, const Z: usize> Attempt<N, Z> {
    /// Whether the error is acceptable; a failed step is not.
    pub(crate) fn is_acceptable(&self) -> bool {
        self.error <= 1.0
    }
}

/// Start of a step: everything that stays the same when the step is repeated with another size.
pub struct StepStart<'a, Y: System<N, Z>, const N: usize, const Z: usize> {
    pub system: &'a Y,
    pub mode: &'a Y::Mode,
    pub linearised: &'a Linearised<N, Z>,
    pub tolerances: &'a Tolerances,
    pub t: f64,
    /// Latest time at which the right-hand side may be evaluated: just before a discontinuity, which belongs to the
    /// next step.
    pub latest_time: f64,
    pub state: &'a State<N, Z>,
}

pub trait Method<const N: usize, const Z: usize>: Clone {
    fn new() -> Self;

    /// Order of the error estimate's leading term in h.
    fn error_order(&self) -> f64;

    /// Discards the history of earlier steps (after an event).
    fn restart(&mut self);

    /// Notifies the method that its last attempt was accepted.
    fn accept_step(&mut self);

    /// Notifies the method that the run has stalled.
    fn on_stall(&mut self) {}

    fn attempt<Y: System<N, Z>>(&mut self, origin: &StepStart<Y, N, Z>, h: f64) -> Attempt<N, Z>;

    /// Dense output of the last attempt.
    fn dense(&self) -> Dense<N, Z>;
}
