//! Benchmark interface of the published solvers.

use crate::support::BenchSolver;
use crate::support::problem::Problem;
use crate::support::trajectory::{Cost, Trajectory};
use crate::vector_field::StepRecorder;

/// A solver of another crate at one relative tolerance.
pub trait ExternalSolver {
    /// Name of the method.
    const METHOD: &str;

    /// Relative tolerance.
    fn rtol(&self) -> f64;

    /// Integrates; `recorder` receives every step.
    fn integrate(&self, problem: &Problem, recorder: Option<&mut StepRecorder>) -> Result<Cost, String>;
}

impl<P: ExternalSolver> BenchSolver for P {
    fn method(&self) -> &str {
        P::METHOD
    }

    fn rtol(&self) -> f64 {
        ExternalSolver::rtol(self)
    }

    fn run(&self, problem: &Problem) -> Result<Cost, String> {
        self.integrate(problem, None)
    }

    fn record(&self, problem: &Problem) -> Trajectory {
        let mut recorder = StepRecorder::new(problem);
        let result = self.integrate(problem, Some(&mut recorder));
        recorder.finish(result)
    }
}
