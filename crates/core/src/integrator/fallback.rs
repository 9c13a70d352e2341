//! Radau IIA, and Rodas5P where it gets nowhere.

use super::method::{Attempt, Method, Origin};
use super::{Dense, Radau5, Rodas5p, System};

/// A method of a run that may turn out to hammer: Radau IIA until the run is lost, Rodas5P from there on.
///
/// A stiff stop that trembles and hammers with a force of some last digits of its coordinates makes noise of Newton's corrections, so
/// that Radau's steps are refused; Rodas5P has no iteration to disturb, and takes a tenth of the time there at the same tolerances.
pub struct RadauOrRodas<const N: usize, const Z: usize> {
    radau: Radau5<N, Z>,
    rodas: Rodas5p<N, Z>,
    lost: bool,
}

impl<const N: usize, const Z: usize> Method<N, Z> for RadauOrRodas<N, Z> {
    /// The lower one of both.
    const ERROR_ORDER: f64 = <Radau5<N, Z> as Method<N, Z>>::ERROR_ORDER;

    fn new() -> Self {
        Self { radau: Radau5::new(), rodas: Rodas5p::new(), lost: false }
    }

    fn restart(&mut self) {
        self.radau.restart();
    }

    fn keep(&mut self) {
        if !self.lost {
            self.radau.keep();
        }
    }

    fn is_lost(&mut self) {
        self.lost = true;
    }

    fn attempt<Y: System<N, Z>>(&mut self, origin: &Origin<Y, N, Z>, h: f64) -> Attempt<N, Z> {
        match self.lost {
            false => self.radau.attempt(origin, h),
            true => self.rodas.attempt(origin, h),
        }
    }

    fn dense(&self) -> Dense<N, Z> {
        match self.lost {
            false => self.radau.dense(),
            true => self.rodas.dense(),
        }
    }
}
