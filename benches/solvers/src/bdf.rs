//! BDF of the crate `diffsol`.

use std::cell::Cell;

use diffsol::{NalgebraLU, NalgebraMat, OdeBuilder, OdeSolverMethod, OdeSolverStopReason};

use crate::external_solver::ExternalSolver;
use crate::support::absolute_tolerances;
use crate::support::problem::Problem;
use crate::support::trajectory::Cost;
use crate::vector_field::{FIRST_STEP_S, StepRecorder, Vector, VectorField, start};

/// Minimum step, far below the duration of an impact.
const SMALLEST_STEP_S: f64 = 1e-18;

/// Backward differentiation of variable order 1–5, with dense nalgebra matrices.
pub struct Bdf {
    pub rtol: f64,
}

fn array(y: &[f64]) -> Vector {
    std::array::from_fn(|i| y[i])
}

impl ExternalSolver for Bdf {
    const METHOD: &str = "diffsol BDF";

    fn rtol(&self) -> f64 {
        self.rtol
    }

    fn integrate(&self, problem: &Problem, mut recorder: Option<&mut StepRecorder>) -> Result<Cost, String> {
        let vector_field = VectorField::new(problem);
        let (angle, rate) = absolute_tolerances(self.rtol);
        // The crate requests one product J v per column; the Jacobian is computed once and cached.
        let cache = Cell::new(([f64::NAN; 4], [[0.0; 4]; 4]));
        let product = |y: &[f64], t: f64, v: &[f64], out: &mut [f64]| {
            let y = array(y);
            let (cached_y, mut jacobian) = cache.get();
            if cached_y != y {
                jacobian = vector_field.jacobian(t, &y);
                cache.set((y, jacobian));
            }
            for (out, row) in out.iter_mut().zip(&jacobian) {
                *out = row.iter().zip(v).map(|(a, b)| a * b).sum();
            }
        };
        let initial = start(problem);
        let mut equations = OdeBuilder::<NalgebraMat<f64>>::new()
            .rtol(self.rtol)
            .h0(FIRST_STEP_S)
            .atol([angle, angle, rate, rate])
            .rhs_implicit(
                |y, _, t, out| out.copy_from_slice(&vector_field.rates(t, &array(y))),
                |y, _, t, v, out| product(y, t, v, out),
            )
            .init(move |_, _, y| y.copy_from_slice(&initial), 4)
            .build()
            .map_err(|error| error.to_string())?;
        // By default the solver stops at steps of 1e-13 s, or after fifty failures of Newton's method in a run.
        equations.ode_options.min_timestep = SMALLEST_STEP_S;
        equations.ode_options.max_nonlinear_solver_failures = usize::MAX;
        let mut solver = equations.bdf::<NalgebraLU<f64>>().map_err(|error| error.to_string())?;
        solver.set_stop_time(problem.duration_s()).map_err(|error| error.to_string())?;
        loop {
            let t0 = solver.state().t;
            let reason = solver.step().map_err(|error| error.to_string())?;
            if let Some(recorder) = &mut recorder {
                let state = solver.state();
                let interpolate = |t: f64| solver.interpolate(t).ok().map(|y| array(y.batch_as_slice(0)));
                recorder.step(t0, state.t, &array(state.y.batch_as_slice(0)), interpolate);
            }
            if matches!(reason, OdeSolverStopReason::TstopReached) {
                break;
            }
        }
        let counts = solver.get_statistics();
        let rejected = counts.number_of_error_test_failures + counts.number_of_nonlinear_solver_fails;
        Ok(vector_field.cost(counts.number_of_steps, rejected))
    }
}
