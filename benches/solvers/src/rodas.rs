//! RODAS4 of the crate `numeris`.

use numeris::ode::{AdaptiveSettings, RODAS4, Rosenbrock};
use numeris::{Matrix, Vector as Column};

use crate::external_solver::ExternalSolver;
use crate::support::problem::Problem;
use crate::support::trajectory::Cost;
use crate::vector_field::{FIRST_STEP_S, StepRecorder, Vector, VectorField, start};

/// The Rosenbrock method of order 4(3) by Hairer & Wanner.
///
/// It has one absolute tolerance for all components; as in its defaults, it equals the relative tolerance. Smaller absolute
/// tolerances take longer without reducing the error.
pub struct Rodas4 {
    pub rtol: f64,
}

/// Rate where the loop of the finger cannot close. A stage that starts outside the object and ends in its stiff damper can
/// reach such a state. The crate fails on NaN, but reduces the step on a large error.
const UNREACHABLE_RATE: f64 = 1e12;

impl ExternalSolver for Rodas4 {
    const METHOD: &str = "numeris RODAS4";

    fn rtol(&self) -> f64 {
        self.rtol
    }

    fn integrate(&self, problem: &Problem, recorder: Option<&mut StepRecorder>) -> Result<Cost, String> {
        let vector_field = VectorField::new(problem);
        let settings = AdaptiveSettings {
            abs_tol: self.rtol,
            rel_tol: self.rtol,
            // With the default, 1e-6 s, steps longer than an impact would be accepted with any error.
            min_step: 0.0,
            max_steps: 1_000_000,
            initial_step: Some(FIRST_STEP_S),
            dense_output: recorder.is_some(),
            ..AdaptiveSettings::default()
        };
        let array = |y: &Column<f64, 4>| -> Vector { std::array::from_fn(|i| y[i]) };
        let rates = |t: f64, y: &Column<f64, 4>| {
            let rates = vector_field.rates(t, &array(y));
            Column::from_array(rates.map(|x| if x.is_finite() { x } else { UNREACHABLE_RATE }))
        };
        let solution = RODAS4::integrate(
            0.0,
            problem.duration_s(),
            &Column::from_array(start(problem)),
            rates,
            |t, y| Matrix::new(vector_field.jacobian(t, &array(y))),
            &settings,
        )
        .map_err(|error| error.to_string())?;
        if let (Some(recorder), Some(steps)) = (recorder, &solution.dense) {
            let ends = steps.y.iter().skip(1).chain([&solution.y]);
            for (((t0, h), from), to) in steps.t.iter().zip(&steps.h).zip(&steps.y).zip(ends) {
                let (from, to) = (array(from), array(to));
                recorder.step(*t0, t0 + h, &to, |t| Some(hermite((t - t0) / h, *h, &from, &to)));
            }
        }
        Ok(vector_field.cost(solution.accepted, solution.rejected))
    }
}

/// Interpolates within a step, as the crate has no dense output for this method: angles by the cubic through both ends and
/// their rates, rates linearly.
fn hermite(x: f64, h: f64, from: &Vector, to: &Vector) -> Vector {
    let (up, down) = (x * x, (1.0 - x) * (1.0 - x));
    std::array::from_fn(|i| match i {
        0 | 1 => {
            down * ((1.0 + 2.0 * x) * from[i] + x * h * from[i + 2])
                + up * ((3.0 - 2.0 * x) * to[i] - (1.0 - x) * h * to[i + 2])
        }
        _ => (1.0 - x) * from[i] + x * to[i],
    })
}
