//! Event functions inside a step.

use std::cell::{Cell, OnceCell, RefCell};

use super::layout::VectorOf;
use super::{Dense, EventFunction, Hybrid, Method};

/// Event functions inside a step, whose dense output is evaluated when it is first used.
pub(crate) struct Interior<'a, Y: Hybrid, K> {
    pub system: &'a Y,
    pub mode: &'a Y::Mode,
    method: &'a K,
    dense: OnceCell<&'a Dense<Y::Layout>>,
    memory: Cell<Option<&'a mut Dense<Y::Layout>>>,
    /// Memory for coordinates and rates.
    state: &'a RefCell<[VectorOf<Y::Layout>; 2]>,
}

impl<'a, Y: Hybrid, K: Method<Y::Layout>> Interior<'a, Y, K> {
    pub fn new(
        (system, mode, method): (&'a Y, &'a Y::Mode, &'a K),
        memory: &'a mut Dense<Y::Layout>,
        state: &'a RefCell<[VectorOf<Y::Layout>; 2]>,
    ) -> Self {
        Self { system, mode, method, dense: OnceCell::new(), memory: Cell::new(Some(memory)), state }
    }

    /// Dense output of the step.
    pub fn dense(&self) -> &'a Dense<Y::Layout> {
        self.dense.get_or_init(|| {
            let dense = self.memory.take().expect("the dense output is evaluated once");
            self.method.dense(None, dense);
            dense
        })
    }

    /// Evaluates an event function at a fraction of the step.
    pub fn function(&self, index: usize, theta: f64) -> EventFunction {
        let [q, v] = &mut *self.state.borrow_mut();
        self.dense().motion(theta, q, v);
        self.system.eval_event(q, v, self.mode, index)
    }

    /// Evaluates the selected event functions at a fraction of the step. Most steps need no other evaluation.
    pub fn values(&self, theta: f64, selected: &[bool], values: &mut [f64]) {
        let [q, v] = &mut *self.state.borrow_mut();
        self.dense().motion(theta, q, v);
        self.system.event_values(q, v, self.mode, selected, values);
    }

    /// Reads the coordinates at a fraction of the step and their derivative. The derivative differs from the dense
    /// output of the rates by the interpolation error.
    pub fn at_derivative<R>(
        &self,
        theta: f64,
        read: impl FnOnce(&VectorOf<Y::Layout>, &VectorOf<Y::Layout>) -> R,
    ) -> R {
        let [q, v] = &mut *self.state.borrow_mut();
        self.dense().coordinates_with_derivative(theta, q, v);
        read(q, v)
    }
}
