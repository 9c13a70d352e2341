//! States inside the last step, for observers.

use super::method::{Attempt, Method, Refinement, StepStart};
use super::state::{Observer, Step, StepTools};
use super::{Dense, Hybrid, Layout, State};

/// Scaled error of a partial step above which the interpolant is more accurate.
const MAX_RESOLVED_ERROR: f64 = 10.0;
/// Error of a cubic through the ends of a step, relative to the absolute tolerance of coordinates, above which observers see
/// parts of it.
const MAX_CUBIC_ERROR: f64 = 10.0;
/// Largest number of parts of a step.
const MAX_PARTS: f64 = 16.0;
/// Number of states inside a step that are kept for further readings.
const MAX_KEPT_STATES: usize = 16;

/// Memory for states inside the last step.
#[derive(Clone)]
pub struct InsideMemory<L: Layout> {
    dense: Dense<L>,
    interpolated: State<L>,
    /// Step that ends inside the last one.
    resolved: Attempt<L>,
    refinement: Refinement<L>,
    /// Ends of a part of the step.
    part: Option<[State<L>; 2]>,
    /// Refined states: the searches of several contacts begin alike.
    refined: KeptStates<L>,
    /// Ends of separate steps: a peak is read twice.
    resolved_ends: KeptStates<L>,
}

/// States inside the last step that are kept for further readings.
#[derive(Clone)]
struct KeptStates<L: Layout> {
    /// Fraction of the step, whether the quadratures are evaluated, and the state.
    states: Vec<(f64, bool, State<L>)>,
    count: usize,
}

impl<L: Layout> KeptStates<L> {
    fn new(layout: L) -> Self {
        Self { states: (0..MAX_KEPT_STATES).map(|_| (0.0, false, State::zero(layout))).collect(), count: 0 }
    }

    fn find(&self, theta: f64, with_quadratures: bool) -> Option<&State<L>> {
        let is_found =
            |(at, has_quadratures, _): &&(f64, bool, State<L>)| *at == theta && (*has_quadratures || !with_quadratures);
        self.states[..self.count].iter().find(is_found).map(|(.., state)| state)
    }

    /// Keeps a state while there is room.
    fn keep(&mut self, theta: f64, has_quadratures: bool, state: &State<L>) {
        if let Some(kept) = self.states.get_mut(self.count) {
            (kept.0, kept.1) = (theta, has_quadratures);
            kept.2.copy_from(state);
            self.count += 1;
        }
    }
}

impl<L: Layout> InsideMemory<L> {
    pub fn new(layout: L) -> Self {
        Self {
            dense: Dense::new(layout),
            interpolated: State::zero(layout),
            resolved: Attempt::new(layout),
            refinement: Refinement::new(layout),
            part: None,
            refined: KeptStates::new(layout),
            resolved_ends: KeptStates::new(layout),
        }
    }
}

/// Evaluates states inside the step just taken, for an observer.
pub struct StepEvaluator<'a, Y: Hybrid, K> {
    method: &'a K,
    resolver: &'a mut K,
    origin: StepStart<'a, Y>,
    size: f64,
    /// Part of the step whose fractions the observer uses.
    part: [f64; 2],
    /// Whether the dense output is evaluated, and whether its quadratures are.
    has_dense: bool,
    has_quadratures: bool,
    memory: &'a mut InsideMemory<Y::Layout>,
}

impl<'a, Y: Hybrid, K: Method<Y::Layout>> StepEvaluator<'a, Y, K> {
    pub fn new(
        (method, resolver): (&'a K, &'a mut K),
        origin: StepStart<'a, Y>,
        size: f64,
        memory: &'a mut InsideMemory<Y::Layout>,
    ) -> Self {
        (memory.refined.count, memory.resolved_ends.count) = (0, 0);
        Self { method, resolver, origin, size, part: [0.0, 1.0], has_dense: false, has_quadratures: false, memory }
    }

    /// Fraction of the step, from one of the part.
    fn of_step(&self, theta: f64) -> f64 {
        let [from, to] = self.part;
        if theta == 1.0 { to } else { from + theta * (to - from) }
    }

    /// Evaluates the dense output, with or without its quadratures.
    fn evaluate_dense(&mut self, with_quadratures: bool) {
        if self.has_dense && (self.has_quadratures || !with_quadratures) {
            return;
        }
        (self.has_dense, self.has_quadratures) = (true, with_quadratures);
        self.method.dense(with_quadratures.then_some(self.origin.linearised), &mut self.memory.dense);
    }

    /// Evaluates a refined state, with or without its quadratures.
    fn refined(&mut self, theta: f64, with_quadratures: bool) -> &State<Y::Layout> {
        if self.memory.refined.find(theta, with_quadratures).is_none() {
            self.evaluate_dense(with_quadratures);
            let InsideMemory { dense, refinement, .. } = &mut *self.memory;
            if !self.method.refine(&self.origin, dense, theta, refinement) {
                self.resolve_inside(theta);
                self.memory.refinement.state.copy_from(&self.memory.interpolated);
            }
            let InsideMemory { refinement, refined, .. } = &mut *self.memory;
            refined.keep(theta, with_quadratures, &refinement.state);
        }
        let InsideMemory { refinement, refined, .. } = &*self.memory;
        refined.find(theta, with_quadratures).unwrap_or(&refinement.state)
    }

    /// Evaluates the end of a separate step, or of the dense output if that step fails, in the interpolated state.
    fn resolve_inside(&mut self, theta: f64) {
        let InsideMemory { interpolated, resolved_ends, .. } = &mut *self.memory;
        if let Some(end) = resolved_ends.find(theta, true) {
            interpolated.copy_from(end);
            return;
        }
        self.resolver.attempt(&self.origin, theta * self.size, &mut self.memory.resolved);
        // A partial step may fail although the whole step succeeded: with friction that decreases with slip, some step
        // size equals the reciprocal of a growth rate.
        if self.memory.resolved.error <= MAX_RESOLVED_ERROR {
            self.memory.interpolated.copy_from(&self.memory.resolved.end);
        } else {
            self.interpolate_step(theta);
        }
        let InsideMemory { interpolated, resolved_ends, .. } = &mut *self.memory;
        resolved_ends.keep(theta, true, interpolated);
    }

    /// The dense output at a fraction of the step.
    pub fn interpolate_step(&mut self, theta: f64) -> &State<Y::Layout> {
        self.evaluate_dense(true);
        let InsideMemory { dense, interpolated, .. } = &mut *self.memory;
        dense.write(theta, interpolated);
        interpolated
    }

    /// Number of parts of a step on which cubics have the errors that are allowed.
    fn count_parts(&mut self, step: &Step<Y::Layout>) -> usize {
        let atol_q = self.origin.tolerances.atol_q;
        let (start, end, middle) = (step.start, step.end, self.interpolate_step(0.5));
        let mut error = 0.0_f64;
        for i in 0..middle.q.as_ref().len() {
            let cubic = 0.5 * (start.q[i] + end.q[i]) + 0.125 * step.h * (start.v[i] - end.v[i]);
            error = error.max((middle.q[i] - cubic).abs());
        }
        // The error falls with the fourth power of the length.
        let parts = (error / (MAX_CUBIC_ERROR * atol_q)).sqrt().sqrt().ceil();
        parts.clamp(1.0, MAX_PARTS) as usize
    }
}

impl<Y: Hybrid, K: Method<Y::Layout>> StepTools<Y::Layout> for StepEvaluator<'_, Y, K> {
    fn interpolate(&mut self, theta: f64) -> &State<Y::Layout> {
        self.interpolate_step(self.of_step(theta))
    }

    fn refine(&mut self, theta: f64) -> &State<Y::Layout> {
        self.refined(self.of_step(theta), true)
    }

    fn refine_motion(&mut self, theta: f64) -> &State<Y::Layout> {
        self.refined(self.of_step(theta), false)
    }

    fn resolve(&mut self, theta: f64) -> &State<Y::Layout> {
        self.resolve_inside(self.of_step(theta));
        &self.memory.interpolated
    }
}

/// Passes a step on to an observer, in equal parts if it is too long for a cubic: between the states that observers see,
/// motions are read as cubics, and a force has one extremum at most. Returns whether the integration continues.
pub fn observe<Y: Hybrid, K: Method<Y::Layout>, O: Observer<Y::Layout, Y::Mode>>(
    step: &Step<Y::Layout>,
    mode: &Y::Mode,
    tools: &mut StepEvaluator<'_, Y, K>,
    observer: &mut O,
) -> bool {
    let count = if tools.method.takes_long_steps() { tools.count_parts(step) } else { 1 };
    if count == 1 {
        return observer.step(step, mode, tools);
    }
    let at = |part: usize| part as f64 / count as f64;
    let mut ends = tools.memory.part.take().unwrap_or_else(|| [step.start.clone(), step.end.clone()]);
    ends[1].copy_from(step.start);
    let mut time_s = step.t0;
    for part in 0..count {
        let [start, end] = &mut ends;
        std::mem::swap(start, end);
        let is_last = part + 1 == count;
        end.copy_from(if is_last { step.end } else { tools.interpolate_step(at(part + 1)) });
        tools.part = [at(part), at(part + 1)];
        let t1 = if is_last { step.t1 } else { step.t0 + at(part + 1) * step.h };
        let observed = Step { t0: time_s, t1, h: step.h / count as f64, start, end };
        if !observer.step(&observed, mode, tools) {
            return false;
        }
        time_s = t1;
    }
    tools.memory.part = Some(ends);
    true
}
