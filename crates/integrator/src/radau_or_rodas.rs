//! Method of a run: Rodas5P, or Radau IIA with a switch to Rodas5P.

use super::layout::{Layout, VectorOf};
use super::method::{Attempt, Method, Refinement, StepStart};
use super::{Dense, Linearised, Radau5, Rodas5p, System};

/// Rodas5P alone, or Radau IIA until a run stalls and Rodas5P afterwards. Both are one type, so that the integration of
/// a model is compiled once.
///
/// If the contact force of a stiff stop depends on the last digits of its coordinates, the Newton corrections become
/// noise and steps of Radau IIA are rejected. Rodas5P has no iteration; at the same tolerances it takes a tenth of the
/// time there.
#[derive(Clone)]
pub struct RadauOrRodas<L: Layout> {
    radau: Radau5<L>,
    rodas: Rodas5p<L>,
    /// Error order of the initial method; for Radau IIA followed by Rodas5P it is the lower of the two.
    error_order: f64,
    uses_radau: bool,
}

impl<L: Layout> RadauOrRodas<L> {
    /// Creates the method that uses Rodas5P from the start.
    pub fn rodas(layout: L) -> Self {
        let (radau, rodas) = (Radau5::new(layout), Rodas5p::new(layout));
        Self { error_order: rodas.error_order(), radau, rodas, uses_radau: false }
    }
}

impl<L: Layout> Method<L> for RadauOrRodas<L> {
    /// Creates the method with Radau IIA at the start.
    fn new(layout: L) -> Self {
        let (radau, rodas) = (Radau5::new(layout), Rodas5p::new(layout));
        Self { error_order: radau.error_order(), radau, rodas, uses_radau: true }
    }

    fn error_order(&self) -> f64 {
        self.error_order
    }

    fn restart(&mut self) {
        self.radau.restart();
    }

    fn follow(&mut self, other: &Self) {
        self.uses_radau = other.uses_radau;
        if self.uses_radau {
            self.radau.follow(&other.radau);
        }
    }

    fn accept_step(&mut self) {
        if self.uses_radau {
            self.radau.accept_step();
        }
    }

    fn on_stall(&mut self) {
        self.uses_radau = false;
    }

    /// Not inlined: the loop attempts steps in four places, and an attempt is most of the code to compile.
    #[inline(never)]
    fn attempt<Y: System<Layout = L>>(&mut self, origin: &StepStart<Y>, h: f64, attempt: &mut Attempt<L>) {
        match self.uses_radau {
            true => self.radau.attempt(origin, h, attempt),
            false => self.rodas.attempt(origin, h, attempt),
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
        !self.uses_radau && self.rodas.refine(origin, dense, theta, refinement)
    }

    fn dense(&self, linearised: Option<&Linearised<L>>, dense: &mut Dense<L>) {
        match self.uses_radau {
            true => self.radau.dense(linearised, dense),
            false => self.rodas.dense(linearised, dense),
        }
    }

    #[inline(always)]
    fn dense_positions(&self, d: &mut [VectorOf<L>; 3]) {
        if self.uses_radau { self.radau.dense_positions(d) } else { self.rodas.dense_positions(d) }
    }
}
