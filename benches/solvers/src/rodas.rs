//! RODAS4 of the crate `numeris`.

use numeris::ode::{AdaptiveSettings, RODAS4, Rosenbrock};
use numeris::{Matrix, Vector as Column};

use crate::field::{FIRST_STEP_S, Field, Vector, Watcher, start};
use crate::published::Published;
use crate::support::problem::Problem;
use crate::support::track::Cost;

/// The Rosenbrock method of order 4(3) by Hairer & Wanner.
///
/// It knows one absolute tolerance for all components; as in its defaults, that is the relative one. Smaller
/// ones were tried: they take longer and are no nearer.
pub struct Rodas4 {
    pub rtol: f64,
}

/// What it gets for a rate where the loop of the finger is out of reach. A stage that starts apart from the object and lands
/// in its stiff damper is thrown that far, and the crate gives up at what is not a number, where a huge error makes it
/// shorten the step.
const UNREACHABLE_RATE: f64 = 1e12;

impl Published for Rodas4 {
    const METHOD: &str = "numeris RODAS4";

    fn rtol(&self) -> f64 {
        self.rtol
    }

    fn integrate(&self, problem: &Problem, watcher: Option<&mut Watcher>) -> Result<Cost, String> {
        let field = Field::new(problem);
        let settings = AdaptiveSettings {
            abs_tol: self.rtol,
            rel_tol: self.rtol,
            // The default, 1e-6 s, would accept whatever comes of a step of that size: an impact lasts less.
            min_step: 0.0,
            max_steps: 1_000_000,
            initial_step: Some(FIRST_STEP_S),
            dense_output: watcher.is_some(),
            ..AdaptiveSettings::default()
        };
        let array = |y: &Column<f64, 4>| -> Vector { std::array::from_fn(|i| y[i]) };
        let rates = |t: f64, y: &Column<f64, 4>| {
            let rates = field.rates(t, &array(y));
            Column::from_array(rates.map(|x| if x.is_finite() { x } else { UNREACHABLE_RATE }))
        };
        let solution = RODAS4::integrate(
            0.0,
            problem.duration_s(),
            &Column::from_array(start(problem)),
            rates,
            |t, y| Matrix::new(field.jacobian(t, &array(y))),
            &settings,
        )
        .map_err(|error| error.to_string())?;
        if let (Some(watcher), Some(steps)) = (watcher, &solution.dense) {
            let ends = steps.y.iter().skip(1).chain([&solution.y]);
            for (((t0, h), from), to) in steps.t.iter().zip(&steps.h).zip(&steps.y).zip(ends) {
                let (from, to) = (array(from), array(to));
                watcher.step(*t0, t0 + h, &to, |t| Some(hermite((t - t0) / h, *h, &from, &to)));
            }
        }
        Ok(field.cost(solution.accepted, solution.rejected))
    }
}

/// The crate has no dense output for this method: angles by the cubic through both ends and their rates, rates linear.
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
