//! Radau5 of the crate `differential-equations`.

use differential_equations::prelude::*;

use crate::field::{FIRST_STEP_S, Field, Vector, Watcher, start};
use crate::published::Published;
use crate::support::absolute;
use crate::support::problem::Problem;
use crate::support::track::Cost;

/// Radau IIA of order 5 after Hairer's code.
pub struct DeRadau5 {
    pub rtol: f64,
}

impl ODE<f64, Vector> for Field<'_> {
    fn diff(&self, t: f64, y: &Vector, dydt: &mut Vector) {
        *dydt = self.rates(t, y);
    }

    fn jacobian(&self, t: f64, y: &Vector, j: &mut Matrix<f64>) {
        let rows = Field::jacobian(self, t, y);
        for (i, row) in rows.iter().enumerate() {
            for (k, value) in row.iter().enumerate() {
                j[(i, k)] = *value;
            }
        }
    }
}

/// Looks at every step, and keeps nothing in the solution.
struct Look<'a, 'b>(Option<&'a mut Watcher<'b>>);

impl Solout<f64, Vector> for Look<'_, '_> {
    fn solout<I>(
        &mut self,
        t: f64,
        t_before: f64,
        y: &Vector,
        _: &Vector,
        inside: &mut I,
        _: &mut Solution<f64, Vector>,
    ) -> ControlFlag<f64, Vector>
    where
        I: Interpolation<f64, Vector> + ?Sized,
    {
        if let Some(watcher) = &mut self.0
            && t > t_before
        {
            watcher.step(t_before, t, y, |t| inside.interpolate(t).ok());
        }
        ControlFlag::Continue
    }
}

impl Published for DeRadau5 {
    const METHOD: &str = "differential-equations Radau5";

    fn rtol(&self) -> f64 {
        self.rtol
    }

    fn integrate(&self, problem: &Problem, watcher: Option<&mut Watcher>) -> Result<Cost, String> {
        let field = Field::new(problem);
        let (angle, rate) = absolute(self.rtol);
        let method = ImplicitRungeKutta::radau5()
            .rtol([self.rtol; 4])
            .atol([angle, angle, rate, rate])
            .h0(FIRST_STEP_S)
            .max_steps(1_000_000);
        let result =
            IVP::ode(&field, 0.0, problem.duration_s(), start(problem)).method(method).solout(Look(watcher)).solve();
        match result {
            Ok(solution) => Ok(field.cost(solution.steps.accepted, solution.steps.rejected)),
            Err(error) => Err(format!("{error:?}")),
        }
    }
}
