//! What a one-step method offers to the integration loop.

use super::{Dense, Linearised, State, System, Tolerances};

/// What one attempt at a step gave.
#[derive(Clone, Copy, Debug)]
pub struct Attempt<const N: usize, const Z: usize> {
    /// Scaled error; 1 is just acceptable. Not a number if the step failed outright.
    pub error: f64,
    /// Right-hand sides it took.
    pub rhs: u64,
    pub end: State<N, Z>,
    /// Estimated errors of coordinates and rates.
    pub error_q: [f64; N],
    pub error_v: [f64; N],
}

impl<const N: usize, const Z: usize> Attempt<N, Z> {
    /// Whether the error is acceptable; a failed step is not.
    pub fn is_acceptable(&self) -> bool {
        self.error <= 1.0
    }
}

/// Where a step starts: everything that stays the same when it is tried again with another size.
pub struct Origin<'a, Y: System<N, Z>, const N: usize, const Z: usize> {
    pub system: &'a Y,
    pub mode: &'a Y::Mode,
    pub linearised: &'a Linearised<N, Z>,
    pub tolerances: &'a Tolerances,
    pub t: f64,
    /// Latest time to evaluate the right-hand side at: before a jump, which belongs to the step after it.
    pub latest: f64,
    pub state: &'a State<N, Z>,
}

/// A one-step method.
pub trait Method<const N: usize, const Z: usize> {
    fn new() -> Self;

    /// Order of the error estimate's leading term in h.
    fn error_order(&self) -> f64;

    /// Forgets what earlier steps taught (after an event).
    fn restart(&mut self);

    /// Tells the method that the last attempt was kept.
    fn keep(&mut self);

    /// Tells the method that the run would take forever at its pace.
    fn is_lost(&mut self) {}

    /// Tries a step of size `h`.
    fn attempt<Y: System<N, Z>>(&mut self, origin: &Origin<Y, N, Z>, h: f64) -> Attempt<N, Z>;

    /// Dense output of the last attempt.
    fn dense(&self) -> Dense<N, Z>;
}
