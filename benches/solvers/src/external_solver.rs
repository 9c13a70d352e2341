//! Benchmark interface of the published solvers.

use crate::equations::{GeneralSolver, InitialValueProblem};
use crate::support::BenchSolver;
use crate::support::problem::Problem;
use crate::support::trajectory::{Cost, Trajectory};
use crate::vector_field::{StepRecorder, VectorField, array, start};

/// A solver of another crate at one relative tolerance.
pub trait ExternalSolver {
    /// Name of the method.
    const METHOD: &str;

    /// Relative tolerance.
    fn rtol(&self) -> f64;

    /// Integrates; `recorder` receives every step.
    fn integrate(&self, problem: &Problem, recorder: Option<&mut StepRecorder>) -> Result<Cost, String>;
}

impl<S: GeneralSolver> ExternalSolver for S {
    const METHOD: &str = <S as GeneralSolver>::METHOD;

    fn rtol(&self) -> f64 {
        GeneralSolver::rtol(self)
    }

    fn integrate(&self, problem: &Problem, recorder: Option<&mut StepRecorder>) -> Result<Cost, String> {
        let equations = VectorField::new(problem);
        let initial = InitialValueProblem {
            equations: &equations,
            start: start(problem).to_vec(),
            stops: vec![problem.duration_s()],
        };
        let steps = match recorder {
            None => self.solve(&initial, None)?,
            Some(recorder) => self.solve(
                &initial,
                Some(&mut |t0, t1, y, interpolate| {
                    recorder.step(t0, t1, &array(y), |t| interpolate(t).map(|y| array(&y)));
                }),
            )?,
        };
        Ok(equations.cost(steps.accepted, steps.rejected))
    }
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
