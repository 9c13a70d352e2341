//! BDF of the crate `diffsol`.

use std::cell::RefCell;

use diffsol::{NalgebraLU, NalgebraMat, OdeBuilder, OdeSolverMethod, OdeSolverStopReason};

use crate::equations::{Equations, GeneralSolver, InitialValueProblem, StepObserver, Steps};
use crate::vector_field::{FIRST_STEP_S, MAX_STEPS};

/// Minimum step, far below the duration of an impact.
const SMALLEST_STEP_S: f64 = 1e-18;

/// Backward differentiation of variable order 1–5, with dense nalgebra matrices.
pub struct Bdf {
    pub rtol: f64,
}

/// The last Jacobian and where it was computed. The crate requests one product J v per column.
struct JacobianCache {
    at: Option<(f64, Vec<f64>)>,
    columns: Vec<f64>,
}

impl JacobianCache {
    fn multiply(&mut self, equations: &impl Equations, (t, y): (f64, &[f64]), v: &[f64], out: &mut [f64]) {
        if self.at.as_ref().is_none_or(|(cached_t, cached_y)| (*cached_t, cached_y.as_slice()) != (t, y)) {
            equations.jacobian(t, y, &mut self.columns);
            self.at = Some((t, y.to_vec()));
        }
        out.fill(0.0);
        for (column, factor) in self.columns.chunks_exact(y.len()).zip(v) {
            if *factor != 0.0 {
                out.iter_mut().zip(column).for_each(|(out, entry)| *out += entry * factor);
            }
        }
    }
}

impl GeneralSolver for Bdf {
    const METHOD: &str = "diffsol BDF";

    fn rtol(&self) -> f64 {
        self.rtol
    }

    fn solve<E: Equations>(
        &self,
        problem: &InitialValueProblem<E>,
        mut observer: Option<StepObserver>,
    ) -> Result<Steps, String> {
        let InitialValueProblem { equations, start, stops } = problem;
        let size = start.len();
        let (mut t, mut y, mut steps) = (0.0, start.clone(), Steps::default());
        for stop in stops {
            equations.set_latest_time(stop.next_down());
            let cache = RefCell::new(JacobianCache { at: None, columns: vec![0.0; size * size] });
            let initial = y.clone();
            let mut settings = OdeBuilder::<NalgebraMat<f64>>::new()
                .t0(t)
                .rtol(self.rtol)
                .h0(FIRST_STEP_S)
                .atol(problem.atol(self.rtol))
                .rhs_implicit(
                    |y, _, t, out| equations.rates(t, y, out),
                    |y, _, t, v, out| cache.borrow_mut().multiply(*equations, (t, y), v, out),
                )
                .init(move |_, _, y| y.copy_from_slice(&initial), size)
                .build()
                .map_err(|error| error.to_string())?;
            // By default the solver stops at steps of 1e-13 s, and after forty or fifty failures in a run.
            settings.ode_options.min_timestep = SMALLEST_STEP_S;
            settings.ode_options.max_nonlinear_solver_failures = usize::MAX;
            settings.ode_options.max_error_test_failures = usize::MAX;
            let mut solver = settings.bdf::<NalgebraLU<f64>>().map_err(|error| error.to_string())?;
            solver.set_stop_time(*stop).map_err(|error| error.to_string())?;
            for taken in steps.accepted.. {
                let t0 = solver.state().t;
                let reason = solver.step().map_err(|error| format!("at {t0:.6} s: {error}"))?;
                if let Some(observe) = &mut observer {
                    let state = solver.state();
                    let mut interpolate = |t: f64| solver.interpolate(t).ok().map(|y| y.batch_as_slice(0).to_vec());
                    observe(t0, state.t, state.y.batch_as_slice(0), &mut interpolate);
                }
                if matches!(reason, OdeSolverStopReason::TstopReached) {
                    break;
                }
                if taken > MAX_STEPS {
                    return Err(format!("at {t0:.6} s: more than {MAX_STEPS} steps"));
                }
            }
            let counts = solver.get_statistics();
            steps.accepted += counts.number_of_steps;
            steps.rejected += counts.number_of_error_test_failures + counts.number_of_nonlinear_solver_fails;
            (t, y) = (*stop, solver.state().y.batch_as_slice(0).to_vec());
        }
        Ok(steps)
    }
}
