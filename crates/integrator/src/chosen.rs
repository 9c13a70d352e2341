//! The methods of runs, of which the run says which.

use super::method::{Attempt, Method, Origin};
use super::{Dense, Radau5, Rodas5p, System};

/// Rodas5P, or Radau IIA until a run turns out to hammer and Rodas5P from there on. One type for both, so that the integration of a
/// model is compiled once.
///
/// A stiff stop that trembles and hammers with a force of some last digits of its coordinates makes noise of Newton's corrections, so
/// that Radau's steps are refused; Rodas5P has no iteration to disturb, and takes a tenth of the time there at the same tolerances.
pub struct RadauOrRodas<const N: usize, const Z: usize> {
    radau: Radau5<N, Z>,
    rodas: Rodas5p<N, Z>,
    /// That of the method the run began with: of Radau and then Rodas5P the lower one.
    error_order: f64,
    by_radau: bool,
}

impl<const N: usize, const Z: usize> RadauOrRodas<N, Z> {
    /// Rodas5P from the start.
    pub fn rodas() -> Self {
        let (radau, rodas) = (Radau5::new(), Rodas5p::new());
        Self { error_order: rodas.error_order(), radau, rodas, by_radau: false }
    }
}

impl<const N: usize, const Z: usize> Method<N, Z> for RadauOrRodas<N, Z> {
    /// Radau IIA to begin with.
    fn new() -> Self {
        let (radau, rodas) = (Radau5::new(), Rodas5p::new());
        Self { error_order: radau.error_order(), radau, rodas, by_radau: true }
    }

    fn error_order(&self) -> f64 {
        self.error_order
    }

    fn restart(&mut self) {
        self.radau.restart();
    }

    fn keep(&mut self) {
        if self.by_radau {
            self.radau.keep();
        }
    }

    fn is_lost(&mut self) {
        self.by_radau = false;
    }

    /// Out of line: the loop tries steps in four places, and a try is most of what there is to compile.
    #[inline(never)]
    fn attempt<Y: System<N, Z>>(&mut self, origin: &Origin<Y, N, Z>, h: f64) -> Attempt<N, Z> {
        match self.by_radau {
            true => self.radau.attempt(origin, h),
            false => self.rodas.attempt(origin, h),
        }
    }

    fn dense(&self) -> Dense<N, Z> {
        match self.by_radau {
            true => self.radau.dense(),
            false => self.rodas.dense(),
        }
    }
}
