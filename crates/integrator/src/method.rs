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

    /// Takes over the history of another method.
    fn follow(&mut self, other: &Self);

    /// Notifies the method that the run has stalled.
    fn on_stall(&mut self) {}

    fn attempt<Y: System<N, Z>>(&mut self, origin: &StepStart<Y, N, Z>, h: f64) -> Attempt<N, Z>;

    /// Corrects the dense output of the last attempt at the fraction `theta` of its step, so that it gives the forces of stiff
    /// contacts; `None` if a step that ends there is required.
    fn refine<Y: System<N, Z>>(
        &self,
        _origin: &StepStart<Y, N, Z>,
        _dense: &Dense<N, Z>,
        _theta: f64,
    ) -> Option<State<N, Z>> {
        None
    }

    /// Dense output of the last attempt, which had this linearisation; without it the quadratures are not interpolated.
    fn dense(&self, linearised: Option<&Linearised<N, Z>>) -> Dense<N, Z>;

    /// The coordinates of the terms d of [`Method::dense`].
    fn dense_positions(&self) -> [[f64; N]; 3];
}
