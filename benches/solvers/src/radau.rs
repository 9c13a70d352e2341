//! Radau5 of the crate `differential-equations`.

use differential_equations::prelude::*;

use crate::external_solver::ExternalSolver;
use crate::support::absolute_tolerances;
use crate::support::problem::Problem;
use crate::support::trajectory::Cost;
use crate::vector_field::{FIRST_STEP_S, StepRecorder, Vector, VectorField, start};

/// Radau IIA of order 5 after Hairer's code.
pub struct DeRadau5 {
    pub rtol: f64,
}

impl ODE<f64, Vector> for VectorField<'_> {
    fn diff(&self, t: f64, y: &Vector, dydt: &mut Vector) {
        *dydt = self.rates(t, y);
    }

    fn jacobian(&self, t: f64, y: &Vector, j: &mut Matrix<f64>) {
        let rows = VectorField::jacobian(self, t, y);
        for (i, row) in rows.iter().enumerate() {
            for (k, value) in row.iter().enumerate() {
                j[(i, k)] = *value;
            }
        }
    }
}

/// Passes every step to the recorder and stores nothing in the solution.
struct RecorderSolout<'a, 'b>(Option<&'a mut StepRecorder<'b>>);

impl Solout<f64, Vector> for RecorderSolout<'_, '_> {
    fn solout<I>(
        &mut self,
        t: f64,
        t_before: f64,
        y: &Vector,
        _: &Vector,
        interpolation: &mut I,
        _: &mut Solution<f64, Vector>,
    ) -> ControlFlag<f64, Vector>
    where
        I: Interpolation<f64, Vector> + ?Sized,
    {
        if let Some(recorder) = &mut self.0
            && t > t_before
        {
            recorder.step(t_before, t, y, |t| interpolation.interpolate(t).ok());
        }
        ControlFlag::Continue
    }
}

impl ExternalSolver for DeRadau5 {
    const METHOD: &str = "differential-equations Radau5";

    fn rtol(&self) -> f64 {
        self.rtol
    }

    fn integrate(&self, problem: &Problem, recorder: Option<&mut StepRecorder>) -> Result<Cost, String> {
        let vector_field = VectorField::new(problem);
        let (angle, rate) = absolute_tolerances(self.rtol);
        let method = ImplicitRungeKutta::radau5()
            .rtol([self.rtol; 4])
            .atol([angle, angle, rate, rate])
            .h0(FIRST_STEP_S)
            .max_steps(1_000_000);
        let result = IVP::ode(&vector_field, 0.0, problem.duration_s(), start(problem))
            .method(method)
            .solout(RecorderSolout(recorder))
            .solve();
        match result {
            Ok(solution) => Ok(vector_field.cost(solution.steps.accepted, solution.steps.rejected)),
            Err(error) => Err(format!("{error:?}")),
        }
    }
}
