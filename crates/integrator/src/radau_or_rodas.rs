//! Method of a run: Rodas5P, or Radau IIA with a switch to Rodas5P.

use super::method::{Attempt, Method, StepStart};
use super::{Dense, Linearised, Radau5, Rodas5p, State, System};

/// Rodas5P, or Radau IIA until a run stalls and Rodas5P afterwards. One type for both, so that the integration of a
/// model is compiled once.
///
/// A stiff stop whose contact force depends on the last digits of its coordinates turns the Newton corrections into
/// noise, so that steps of Radau IIA are rejected. Rodas5P has no iteration and takes a tenth of the time there at the
/// same tolerances.
#[derive(Clone)]
pub struct RadauOrRodas<const N: usize, const Z: usize> {
    radau: Radau5<N, Z>,
    rodas: Rodas5p<N, Z>,
    /// Error order of the initial method; for Radau IIA followed by Rodas5P it is the lower of the two.
    error_order: f64,
    uses_radau: bool,
}

impl<const N: usize, const Z: usize> RadauOrRodas<N, Z> {
    /// Creates the method with Rodas5P from the start.
    pub fn rodas() -> Self {
        let (radau, rodas) = (Radau5::new(), Rodas5p::new());
        Self { error_order: rodas.error_order(), radau, rodas, uses_radau: false }
    }
}

impl<const N: usize, const Z: usize> Method<N, Z> for RadauOrRodas<N, Z> {
    /// Creates the method with Radau IIA at the start.
    fn new() -> Self {
        let (radau, rodas) = (Radau5::new(), Rodas5p::new());
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
    fn attempt<Y: System<N, Z>>(&mut self, origin: &StepStart<Y, N, Z>, h: f64) -> Attempt<N, Z> {
        match self.uses_radau {
            true => self.radau.attempt(origin, h),
            false => self.rodas.attempt(origin, h),
        }
    }

    #[inline(never)]
    fn refine<Y: System<N, Z>>(
        &self,
        origin: &StepStart<Y, N, Z>,
        dense: &Dense<N, Z>,
        theta: f64,
    ) -> Option<State<N, Z>> {
        if self.uses_radau { None } else { self.rodas.refine(origin, dense, theta) }
    }

    fn dense(&self, linearised: Option<&Linearised<N, Z>>) -> Dense<N, Z> {
        match self.uses_radau {
            true => self.radau.dense(linearised),
            false => self.rodas.dense(linearised),
        }
    }

    #[inline(always)]
    fn dense_positions(&self) -> [[f64; N]; 3] {
        if self.uses_radau { self.radau.dense_positions() } else { self.rodas.dense_positions() }
    }
}
