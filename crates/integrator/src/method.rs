//! Interface between one-step methods and the integration loop.

use super::layout::{Layout, VectorOf};
use super::state::DENSE_TERMS;
use super::{Dense, Linearised, Rates, State, System, Tolerances};

/// Result of one attempted step.
#[derive(Clone, Debug)]
pub struct Attempt<L: Layout> {
    /// Scaled error; at most 1 is acceptable. NaN if the step failed.
    pub error: f64,
    /// Number of right-hand-side evaluations.
    pub rhs: u64,
    pub end: State<L>,
    /// Estimated errors of the coordinates.
    pub error_q: VectorOf<L>,
    /// Estimated errors of the rates.
    pub error_v: VectorOf<L>,
}

impl<L: Layout> Attempt<L> {
    /// Memory for an attempt.
    pub(crate) fn new(layout: L) -> Self {
        let (error_q, error_v) = (layout.vector(0.0), layout.vector(0.0));
        Self { error: 0.0, rhs: 0, end: State::zero(layout), error_q, error_v }
    }

    /// Whether the error is acceptable; a failed step is not.
    pub(crate) fn is_acceptable(&self) -> bool {
        self.error <= 1.0
    }
}

/// Start of a step: everything that stays the same when the step is repeated with another size.
pub struct StepStart<'a, Y: System> {
    pub system: &'a Y,
    pub mode: &'a Y::Mode,
    pub linearised: &'a Linearised<Y::Layout>,
    pub tolerances: &'a Tolerances,
    pub t: f64,
    /// Latest time at which the right-hand side may be evaluated. It is just before the next discontinuity, which
    /// belongs to the next step.
    pub latest_time: f64,
    pub state: &'a State<Y::Layout>,
}

/// A corrected state of the dense output, with the memory for its corrections.
#[derive(Clone, Debug)]
pub struct Refinement<L: Layout> {
    pub state: State<L>,
    /// State of the dense output and its time derivative.
    pub(crate) start: State<L>,
    pub(crate) slope: State<L>,
    pub(crate) rates: Rates<L>,
    /// A correction, and memory for it.
    pub(crate) q: VectorOf<L>,
    pub(crate) v: VectorOf<L>,
    pub(crate) scratch: VectorOf<L>,
}

impl<L: Layout> Refinement<L> {
    pub fn new(layout: L) -> Self {
        let (state, vector) = (|| State::zero(layout), || layout.vector(0.0));
        Self {
            state: state(),
            start: state(),
            slope: state(),
            rates: Rates::zero(layout),
            q: vector(),
            v: vector(),
            scratch: vector(),
        }
    }
}

pub trait Method<L: Layout>: Clone {
    fn new(layout: L) -> Self;

    /// Order of the error estimate's leading term in h.
    fn error_order(&self) -> f64;

    /// Discards the history of earlier steps (after an event).
    fn restart(&mut self);

    /// Notifies the method that its last attempt was accepted.
    fn accept_step(&mut self);

    /// Takes over the history of another instance of the method.
    fn follow(&mut self, other: &Self);

    /// Notifies the method that the run has stalled.
    fn on_stall(&mut self) {}

    /// Attempts a step of size `h`.
    fn attempt<Y: System<Layout = L>>(&mut self, origin: &StepStart<Y>, h: f64, attempt: &mut Attempt<L>);

    /// Corrects the dense output of the last attempt at the fraction `theta` of its step, so that it gives the forces
    /// of stiff contacts accurately. Writes the corrected state. Returns `false` if a separate step that ends there is
    /// required instead.
    fn refine<Y: System<Layout = L>>(
        &self,
        _origin: &StepStart<Y>,
        _dense: &Dense<L>,
        _theta: f64,
        _refinement: &mut Refinement<L>,
    ) -> bool {
        false
    }

    /// Writes the dense output of the last attempt. `linearised` is the linearisation of this attempt; without it, the
    /// quadratures are not interpolated.
    fn dense(&self, linearised: Option<&Linearised<L>>, dense: &mut Dense<L>);

    /// Writes the coordinates of the terms d of [`Method::dense`]; returns their number.
    fn dense_positions(&self, d: &mut [VectorOf<L>; DENSE_TERMS]) -> usize;

    /// Whether steps are so long that their ends do not describe them.
    fn takes_long_steps(&self) -> bool {
        false
    }

    /// Writes the right-hand side at the start of a step of about the size `h`, and its derivatives if the method needs them;
    /// returns whether they are written.
    #[inline(always)]
    fn evaluate_start<Y: System<Layout = L>>(
        &mut self,
        system: &Y,
        (t, state, mode): (f64, &State<L>, &Y::Mode),
        _h: f64,
        linearised: &mut Linearised<L>,
    ) -> bool {
        system.linearise(t, &state.q, &state.v, mode, linearised);
        true
    }
}
