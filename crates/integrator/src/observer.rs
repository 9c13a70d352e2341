//! Watching an integration.

use super::State;

/// An accepted step from `t0` to `t1`.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a, const N: usize, const Z: usize> {
    pub t0: f64,
    pub t1: f64,
    /// Its size, exact even where t1 − t0 has no digits left.
    pub h: f64,
    pub start: &'a State<N, Z>,
    pub end: &'a State<N, Z>,
}

/// States inside a step.
pub trait StepTools<const N: usize, const Z: usize> {
    /// The dense output at the fraction `theta` of the step: good for angles and rates.
    fn interpolate(&mut self, theta: f64) -> State<N, Z>;

    /// The end of a step of its own from the same start: what a stiff damper's force needs, which is a huge multiple of a
    /// tiny rate.
    fn resolve(&mut self, theta: f64) -> State<N, Z>;
}

/// Watches an integration. `()` watches nothing.
pub trait Observer<const N: usize, const Z: usize, M> {
    /// An accepted step, taken in `mode`. `false` ends the integration.
    fn step(&mut self, step: &Step<N, Z>, mode: &M, tools: &mut dyn StepTools<N, Z>) -> bool;

    /// An event at `site`, where the step just reported ended; several may follow each other there. `mode` is the one after it.
    fn event(&mut self, t: f64, state: &State<N, Z>, site: usize, mode: &M);
}

impl<const N: usize, const Z: usize, M> Observer<N, Z, M> for () {
    #[inline(always)]
    fn step(&mut self, _: &Step<N, Z>, _: &M, _: &mut dyn StepTools<N, Z>) -> bool {
        true
    }

    #[inline(always)]
    fn event(&mut self, _: f64, _: &State<N, Z>, _: usize, _: &M) {}
}
