//! Method of a run: Radau IIA, or Rodas5P with DOP853 in phases that are not stiff.

use super::layout::{Layout, VectorOf};
use super::linear::dot;
use super::method::{Attempt, Method, Refinement, StepStart};
use super::state::DENSE_TERMS;
use super::{Dense, Dop853, Linearised, Radau5, Rodas5p, State, System};
use crate::numeric::elementary::pow;

/// Product of step and largest rate of change, h λ, below which an explicit phase begins: its steps can then be four times as
/// long before they are unstable.
const MAX_ENTRY_STIFFNESS: f64 = 1.0;
/// Growth of a step above which its size does not yet show what the equations require.
const MAX_STEADY_GROWTH: f64 = 2.0;
/// Number of steps without such growth before an explicit phase.
const STEADY_STEPS: u32 = 4;
/// Number of stiff steps in succession that end an explicit phase.
const STIFF_STEPS: u32 = 2;
/// Number of the explicit step that must be longer by this factor than the one before the phase. An explicit step takes as
/// many evaluations as one of Rodas5P with its derivatives.
const USEFUL_GROWTH: (u32, f64) = (4, 1.7);
/// Number of steps after the end of such a phase before the next one; doubled at each.
const FIRST_WAIT: u32 = 20;
/// Number of steps after equations that were found stiff before they are examined again, and if they are ten times as stiff.
const STIFF_WAIT: [u32; 2] = [4, 16];
/// Iterations that estimate the largest rate of change: the first ones only turn the vector.
const ITERATIONS: [u32; 2] = [3, 4];

/// Rodas5P, or Radau IIA until a run stalls and Rodas5P afterwards. One type for both, so that the integration of a
/// model is compiled once.
///
/// A stiff stop whose contact force depends on the last digits of its coordinates turns the Newton corrections into
/// noise, so that steps of Radau IIA are rejected. Rodas5P has no iteration and takes a tenth of the time there at the
/// same tolerances.
///
/// A run that starts with Rodas5P takes steps of DOP853 in phases that are not stiff, if the system has its sizes at run time:
/// such a step needs no derivatives, and is several times as long at fine tolerances. Runs with Radau IIA have no such phases,
/// so that they check these steps, too.
#[derive(Clone)]
pub struct SwitchedMethod<L: Layout> {
    radau: Radau5<L>,
    rodas: Rodas5p<L>,
    /// Exists if explicit phases are possible.
    explicit: Option<Box<Dop853<L>>>,
    current: Current,
    starts_with_radau: bool,
    /// Size of the last step, and number of steps in succession without much growth.
    last_size: f64,
    steady_steps: u32,
    /// Size of the step before the explicit phase, and its steps so far.
    entry_size: f64,
    explicit_steps: u32,
    stiff_steps: u32,
    /// Steps until the equations are examined, and after the next explicit phase that ends.
    wait: u32,
    next_wait: u32,
    /// Memory for the estimate of the largest rate of change.
    vectors: [VectorOf<L>; 3],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Current {
    Radau,
    Rodas,
    Explicit,
}

impl<L: Layout> SwitchedMethod<L> {
    /// Creates the method with Rodas5P from the start.
    pub fn rodas(layout: L) -> Self {
        let explicit = (!L::IS_FIXED).then(|| Box::new(Dop853::new(layout)));
        Self { explicit, current: Current::Rodas, starts_with_radau: false, ..Self::new(layout) }
    }

    /// Ends an explicit phase whose equations have become stiff, or whose steps are not longer than those before.
    fn end_useless_phase(&mut self, h: f64) {
        self.explicit_steps += 1;
        let is_stiff = self.explicit.as_ref().is_some_and(|explicit| explicit.is_stiff());
        self.stiff_steps = if is_stiff { self.stiff_steps + 1 } else { 0 };
        let (step, growth) = USEFUL_GROWTH;
        if self.stiff_steps >= STIFF_STEPS || self.explicit_steps == step && h < growth * self.entry_size {
            (self.current, self.steady_steps) = (Current::Rodas, 0);
            (self.wait, self.next_wait) = (self.next_wait, self.next_wait.saturating_mul(2));
        }
    }

    /// Begins an explicit phase before a step of about this size, if the equations are not stiff.
    fn begin_phase<Y: System<Layout = L>>(&mut self, system: &Y, linearised: &Linearised<L>, h: f64) {
        let is_steady = h < MAX_STEADY_GROWTH * self.last_size;
        self.steady_steps = if is_steady { self.steady_steps + 1 } else { 0 };
        self.last_size = h;
        self.wait = self.wait.saturating_sub(1);
        if self.wait > 0 || self.steady_steps < STEADY_STEPS {
            return;
        }
        let sizes = [system.second_order_count(), system.coordinate_count()];
        let stiffness = h * largest_rate(linearised, sizes, &mut self.vectors);
        if stiffness < MAX_ENTRY_STIFFNESS {
            (self.current, self.entry_size) = (Current::Explicit, h);
            (self.explicit_steps, self.stiff_steps) = (0, 0);
        } else {
            self.wait = STIFF_WAIT[usize::from(stiffness > 10.0 * MAX_ENTRY_STIFFNESS)];
        }
    }
}

/// An estimate of the largest |λ| of q̈ = ∂a/∂q q + ∂a/∂v q̇, from the growth of a vector to which the matrix is applied
/// (power iteration).
fn largest_rate<L: Layout>(linearised: &Linearised<L>, [m, n]: [usize; 2], [q, v, next]: &mut [VectorOf<L>; 3]) -> f64 {
    q.as_mut().fill(0.0);
    v.as_mut().fill(0.0);
    next.as_mut().fill(0.0);
    for i in 0..n {
        // Different parts, so that no eigenvector is missed.
        v[i] = 1.0 + 0.25 * ((3 * i) % 5) as f64;
    }
    let mut growth = 1.0;
    for iteration in 0..ITERATIONS[0] + ITERATIONS[1] {
        for i in 0..n {
            next[i] = dot(&linearised.a_q[i][..m], &q.as_ref()[..m]) + dot(&linearised.a_v[i][..n], &v.as_ref()[..n]);
        }
        let squared = |v: &VectorOf<L>| v.as_ref().iter().map(|v| v * v).sum::<f64>();
        let (before, after) = (squared(v).sqrt(), squared(next).sqrt());
        if after == 0.0 && squared(q) == 0.0 {
            return 0.0;
        }
        let scale = 1.0 / before.max(after).max(f64::MIN_POSITIVE);
        if iteration >= ITERATIONS[0] && before > 0.0 {
            growth *= after / before;
        }
        for i in 0..n {
            q[i] = if i < m { scale * v[i] } else { 0.0 };
            v[i] = scale * next[i];
        }
    }
    pow(growth, 1.0 / f64::from(ITERATIONS[1]))
}

impl<L: Layout> Method<L> for SwitchedMethod<L> {
    /// Creates the method with Radau IIA at the start.
    fn new(layout: L) -> Self {
        Self {
            radau: Radau5::new(layout),
            rodas: Rodas5p::new(layout),
            explicit: None,
            current: Current::Radau,
            starts_with_radau: true,
            last_size: 0.0,
            steady_steps: 0,
            entry_size: 0.0,
            explicit_steps: 0,
            stiff_steps: 0,
            wait: 0,
            next_wait: FIRST_WAIT,
            vectors: std::array::from_fn(|_| layout.vector(0.0)),
        }
    }

    /// For Radau IIA followed by Rodas5P it is the lower of the two.
    fn error_order(&self) -> f64 {
        match (self.current, &self.explicit) {
            (Current::Explicit, Some(explicit)) => explicit.error_order(),
            _ if self.starts_with_radau => self.radau.error_order(),
            _ => self.rodas.error_order(),
        }
    }

    fn takes_long_steps(&self) -> bool {
        self.current == Current::Explicit
    }

    fn restart(&mut self) {
        self.radau.restart();
        self.steady_steps = 0;
    }

    fn follow(&mut self, other: &Self) {
        self.current = other.current;
        if self.current == Current::Radau {
            self.radau.follow(&other.radau);
        }
    }

    fn accept_step(&mut self) {
        if self.current == Current::Radau {
            self.radau.accept_step();
        }
    }

    fn on_stall(&mut self) {
        self.current = Current::Rodas;
    }

    #[inline(always)]
    fn evaluate_start<Y: System<Layout = L>>(
        &mut self,
        system: &Y,
        (t, state, mode): (f64, &State<L>, &Y::Mode),
        h: f64,
        linearised: &mut Linearised<L>,
    ) -> bool {
        let may_be_explicit = !L::IS_FIXED && self.explicit.is_some();
        if may_be_explicit && self.current == Current::Explicit {
            self.end_useless_phase(h);
        }
        if may_be_explicit && self.current == Current::Explicit {
            system.rates(t, &state.q, &state.v, mode, &mut linearised.rates);
            return false;
        }
        system.linearise(t, &state.q, &state.v, mode, linearised);
        if may_be_explicit {
            self.begin_phase(system, linearised, h);
        }
        true
    }

    /// Not inlined: the loop attempts steps in four places, and an attempt is most of the code to compile.
    #[inline(never)]
    fn attempt<Y: System<Layout = L>>(&mut self, origin: &StepStart<Y>, h: f64, attempt: &mut Attempt<L>) {
        match (self.current, &mut self.explicit) {
            (Current::Explicit, Some(explicit)) => explicit.attempt(origin, h, attempt),
            (Current::Radau, _) => self.radau.attempt(origin, h, attempt),
            _ => self.rodas.attempt(origin, h, attempt),
        }
    }

    #[inline(never)]
    fn refine<Y: System<Layout = L>>(
        &self,
        origin: &StepStart<Y>,
        dense: &Dense<L>,
        theta: f64,
        refinement: &mut Refinement<L>,
    ) -> bool {
        match (self.current, &self.explicit) {
            (Current::Explicit, Some(explicit)) => explicit.refine(origin, dense, theta, refinement),
            (Current::Radau, _) => false,
            _ => self.rodas.refine(origin, dense, theta, refinement),
        }
    }

    fn dense(&self, linearised: Option<&Linearised<L>>, dense: &mut Dense<L>) {
        match (self.current, &self.explicit) {
            (Current::Explicit, Some(explicit)) => explicit.dense(linearised, dense),
            (Current::Radau, _) => self.radau.dense(linearised, dense),
            _ => self.rodas.dense(linearised, dense),
        }
    }

    #[inline(always)]
    fn dense_positions(&self, d: &mut [VectorOf<L>; DENSE_TERMS]) -> usize {
        match (self.current, &self.explicit) {
            (Current::Explicit, Some(explicit)) => explicit.dense_positions(d),
            (Current::Radau, _) => self.radau.dense_positions(d),
            _ => self.rodas.dense_positions(d),
        }
    }
}
