//! Initial value problems of any dimension, and the solvers that take them.

use crate::support::absolute_tolerances;

/// ẏ = f(t, y), with y = coordinates, then rates.
pub trait Equations {
    /// Number of coordinates; the remaining components are rates.
    fn coordinate_count(&self) -> usize;

    fn rates(&self, t: f64, y: &[f64], out: &mut [f64]);

    /// ∂f/∂y by columns.
    fn jacobian(&self, t: f64, y: &[f64], columns: &mut [f64]);

    /// Sets the latest time at which f is evaluated. A step that ends at a discontinuity uses the values before it.
    fn set_latest_time(&self, _t: f64) {}
}

/// Equations with their initial state at t = 0.
pub struct InitialValueProblem<'a, E> {
    pub equations: &'a E,
    pub start: Vec<f64>,
    /// Times at which f is discontinuous, then the end. The solver restarts at each of them.
    pub stops: Vec<f64>,
}

impl<E: Equations> InitialValueProblem<'_, E> {
    /// Absolute tolerances of all components for a relative one.
    pub fn atol(&self, rtol: f64) -> Vec<f64> {
        let (coordinate, rate) = absolute_tolerances(rtol);
        let count = self.equations.coordinate_count();
        (0..self.start.len()).map(|i| if i < count { coordinate } else { rate }).collect()
    }
}

/// Accepted steps and rejected attempts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Steps {
    pub accepted: usize,
    pub rejected: usize,
}

/// Receives every step: start and end time, state at the end, and dense output.
pub type StepObserver<'a> = &'a mut dyn FnMut(f64, f64, &[f64], &mut dyn FnMut(f64) -> Option<Vec<f64>>);

/// A published solver at one relative tolerance.
pub trait GeneralSolver {
    /// Name of the method.
    const METHOD: &str;

    /// Relative tolerance.
    fn rtol(&self) -> f64;

    fn solve<E: Equations>(
        &self,
        problem: &InitialValueProblem<E>,
        observer: Option<StepObserver>,
    ) -> Result<Steps, String>;
}
