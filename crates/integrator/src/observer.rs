//! Observers of an integration.

use super::State;

/// An accepted step from `t0` to `t1`.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a, const N: usize, const Z: usize> {
    pub t0: f64,
    pub t1: f64,
    /// Step size, exact even if t1 − t0 cancels completely.
    pub h: f64,
    pub start: &'a State<N, Z>,
    pub end: &'a State<N, Z>,
}

/// States inside a step.
pub trait StepTools<const N: usize, const Z: usize> {
    /// Returns the dense output at the fraction `theta` of the step: accurate for angles and rates.
    fn interpolate(&mut self, theta: f64) -> State<N, Z>;

    /// Returns the end of a separate step from the same start. The force of a stiff damper requires this accuracy,
    /// since it is a large multiple of a tiny rate.
    fn resolve(&mut self, theta: f64) -> State<N, Z>;
}

/// Observer of an integration. `()` ignores everything.
pub trait Observer<const N: usize, const Z: usize, M> {
    /// Called after each accepted step, taken in `mode`. Returning `false` ends the integration.
    fn step(&mut self, step: &Step<N, Z>, mode: &M, tools: &mut dyn StepTools<N, Z>) -> bool;

    /// Called for each event, at the end of the step just reported. Several events may occur at the same time. `mode`
    /// is the mode after the event.
    fn event(&mut self, t: f64, state: &State<N, Z>, index: usize, mode: &M);
}

impl<const N: usize, const Z: usize, M> Observer<N, Z, M> for () {
    #[inline(always)]
    fn step(&mut self, _: &Step<N, Z>, _: &M, _: &mut dyn StepTools<N, Z>) -> bool {
        true
    }

    #[inline(always)]
    fn event(&mut self, _: f64, _: &State<N, Z>, _: usize, _: &M) {}
}
