//! One step of a method.

use super::{Dense, Linearised, State, System, Tolerances};

/// What one attempt at a step gave.
pub struct Attempt<const N: usize, const Z: usize> {
    /// Scaled error; 1 is just acceptable. Not finite if the step failed outright.
    pub error: f64,
    /// Right-hand sides it took.
    pub rhs: u64,
    pub dense: Dense<N, Z>,
}

/// A one-step method.
pub trait Method<const N: usize, const Z: usize> {
    /// Order of the error estimate's leading term in h.
    const ERROR_ORDER: f64;

    fn new() -> Self;

    /// Forgets what earlier steps taught (after an event).
    fn restart(&mut self);

    /// Tells the method that the last attempt was kept.
    fn kept(&mut self);

    #[allow(clippy::too_many_arguments)]
    fn attempt<Y: System<N, Z>>(
        &mut self,
        system: &Y,
        mode: &Y::Mode,
        linearised: &Linearised<N, Z>,
        t: f64,
        from: &State<N, Z>,
        h: f64,
        tolerances: &Tolerances,
    ) -> Attempt<N, Z>;
}
