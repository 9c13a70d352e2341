//! BDF of CVODE (SUNDIALS 6, Debian's package libsundials-dev), called through its C interface.

use std::ffi::{c_int, c_long, c_void};
use std::{ptr, slice};

use crate::equations::{Equations, GeneralSolver, InitialValueProblem, StepObserver, Steps};
use crate::vector_field::{FIRST_STEP_S, MAX_STEPS};

const CV_BDF: c_int = 2;
const CV_ONE_STEP: c_int = 2;
const CV_TSTOP_RETURN: c_int = 1;
/// Failures of the error test and of Newton's method within one step. The default is 10; impacts need more.
const MAX_FAILURES: c_int = 100;

/// Handles of SUNDIALS: context, vector, matrix, linear solver, integrator.
type Handle = *mut c_void;
type RhsFn = extern "C" fn(f64, Handle, Handle, *mut c_void) -> c_int;
type JacFn = extern "C" fn(f64, Handle, Handle, Handle, *mut c_void, Handle, Handle, Handle) -> c_int;

#[link(name = "sundials_cvode")]
#[link(name = "sundials_nvecserial")]
#[link(name = "sundials_sunmatrixdense")]
#[link(name = "sundials_sunlinsoldense")]
#[link(name = "sundials_generic")]
unsafe extern "C" {
    fn SUNContext_Create(comm: *mut c_void, context: *mut Handle) -> c_int;
    fn SUNContext_Free(context: *mut Handle) -> c_int;
    fn N_VMake_Serial(length: i64, data: *mut f64, context: Handle) -> Handle;
    fn N_VGetArrayPointer(vector: Handle) -> *mut f64;
    fn N_VDestroy(vector: Handle);
    fn SUNDenseMatrix(rows: i64, columns: i64, context: Handle) -> Handle;
    fn SUNDenseMatrix_Data(matrix: Handle) -> *mut f64;
    fn SUNMatDestroy(matrix: Handle);
    fn SUNLinSol_Dense(y: Handle, matrix: Handle, context: Handle) -> Handle;
    fn SUNLinSolFree(solver: Handle) -> c_int;
    fn CVodeCreate(method: c_int, context: Handle) -> Handle;
    fn CVodeInit(memory: Handle, rhs: RhsFn, t0: f64, y0: Handle) -> c_int;
    fn CVodeReInit(memory: Handle, t0: f64, y0: Handle) -> c_int;
    fn CVodeSVtolerances(memory: Handle, rtol: f64, atol: Handle) -> c_int;
    fn CVodeSetUserData(memory: Handle, data: *mut c_void) -> c_int;
    fn CVodeSetLinearSolver(memory: Handle, solver: Handle, matrix: Handle) -> c_int;
    fn CVodeSetJacFn(memory: Handle, jacobian: JacFn) -> c_int;
    fn CVodeSetInitStep(memory: Handle, step: f64) -> c_int;
    fn CVodeSetStopTime(memory: Handle, time: f64) -> c_int;
    fn CVodeSetMaxErrTestFails(memory: Handle, count: c_int) -> c_int;
    fn CVodeSetMaxConvFails(memory: Handle, count: c_int) -> c_int;
    fn CVode(memory: Handle, until: f64, y: Handle, t: *mut f64, task: c_int) -> c_int;
    fn CVodeGetDky(memory: Handle, t: f64, derivative: c_int, out: Handle) -> c_int;
    fn CVodeGetNumSteps(memory: Handle, count: *mut c_long) -> c_int;
    fn CVodeGetNumErrTestFails(memory: Handle, count: *mut c_long) -> c_int;
    fn CVodeGetNumNonlinSolvConvFails(memory: Handle, count: *mut c_long) -> c_int;
    fn CVodeFree(memory: *mut Handle);
}

/// Backward differentiation of variable order 1–5 with a dense direct solver.
pub struct Cvode {
    pub rtol: f64,
}

/// The equations and the size of a problem, as the callbacks get them.
struct Callback<'a, E> {
    equations: &'a E,
    size: usize,
}

/// Status of a callback: 0, or 1 for an evaluation that the solver repeats with a smaller step.
fn status(values: &[f64]) -> c_int {
    c_int::from(!values.iter().all(|x| x.is_finite()))
}

extern "C" fn rhs<E: Equations>(t: f64, y: Handle, out: Handle, callback: *mut c_void) -> c_int {
    // SAFETY: `callback` is the `Callback` given to CVodeSetUserData, and both vectors have its size.
    unsafe {
        let Callback { equations, size } = &*callback.cast::<Callback<E>>();
        let y = slice::from_raw_parts(N_VGetArrayPointer(y), *size);
        let out = slice::from_raw_parts_mut(N_VGetArrayPointer(out), *size);
        equations.rates(t, y, out);
        status(out)
    }
}

extern "C" fn jacobian<E: Equations>(
    t: f64,
    y: Handle,
    _: Handle,
    out: Handle,
    callback: *mut c_void,
    _: Handle,
    _: Handle,
    _: Handle,
) -> c_int {
    // SAFETY: as in `rhs`; the matrix is dense, square and stored by columns.
    unsafe {
        let Callback { equations, size } = &*callback.cast::<Callback<E>>();
        let y = slice::from_raw_parts(N_VGetArrayPointer(y), *size);
        let columns = slice::from_raw_parts_mut(SUNDenseMatrix_Data(out), size * size);
        equations.jacobian(t, y, columns);
        status(columns)
    }
}

/// The objects of one integration, dropped in reverse order of creation.
struct Integrator {
    context: Handle,
    y: Handle,
    atol: Handle,
    interpolated: Handle,
    matrix: Handle,
    linear: Handle,
    memory: Handle,
}

impl Drop for Integrator {
    fn drop(&mut self) {
        // SAFETY: every handle was created by `Cvode::solve` and is freed once.
        unsafe {
            CVodeFree(&mut self.memory);
            SUNLinSolFree(self.linear);
            SUNMatDestroy(self.matrix);
            for vector in [self.interpolated, self.atol, self.y] {
                N_VDestroy(vector);
            }
            SUNContext_Free(&mut self.context);
        }
    }
}

fn check(call: &str, status: c_int) -> Result<c_int, String> {
    if status < 0 { Err(format!("{call} returned {status}")) } else { Ok(status) }
}

impl GeneralSolver for Cvode {
    const METHOD: &str = "CVODE BDF";

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
        let callback = Callback { equations: *equations, size };
        let (mut y, mut atol, mut interpolated) = (start.clone(), problem.atol(self.rtol), vec![0.0; size]);
        // SAFETY: the arrays and `callback` outlive `cvode`, which is dropped before them; all have `size` entries.
        unsafe {
            let mut context = ptr::null_mut();
            check("SUNContext_Create", SUNContext_Create(ptr::null_mut(), &mut context))?;
            let vector = |data: &mut Vec<f64>| N_VMake_Serial(size as i64, data.as_mut_ptr(), context);
            let (y_vector, matrix) = (vector(&mut y), SUNDenseMatrix(size as i64, size as i64, context));
            let cvode = Integrator {
                context,
                y: y_vector,
                atol: vector(&mut atol),
                interpolated: vector(&mut interpolated),
                matrix,
                linear: SUNLinSol_Dense(y_vector, matrix, context),
                memory: CVodeCreate(CV_BDF, context),
            };
            let memory = cvode.memory;
            let state = |vector: Handle| slice::from_raw_parts(N_VGetArrayPointer(vector), size);
            equations.set_latest_time(stops[0].next_down());
            check("CVodeInit", CVodeInit(memory, rhs::<E>, 0.0, cvode.y))?;
            check("CVodeSVtolerances", CVodeSVtolerances(memory, self.rtol, cvode.atol))?;
            check("CVodeSetUserData", CVodeSetUserData(memory, ptr::from_ref(&callback).cast_mut().cast()))?;
            check("CVodeSetLinearSolver", CVodeSetLinearSolver(memory, cvode.linear, cvode.matrix))?;
            check("CVodeSetJacFn", CVodeSetJacFn(memory, jacobian::<E>))?;
            check("CVodeSetMaxErrTestFails", CVodeSetMaxErrTestFails(memory, MAX_FAILURES))?;
            check("CVodeSetMaxConvFails", CVodeSetMaxConvFails(memory, MAX_FAILURES))?;
            let (mut t, mut steps) = (0.0, Steps::default());
            for stop in stops {
                equations.set_latest_time(stop.next_down());
                if t > 0.0 {
                    check("CVodeReInit", CVodeReInit(memory, t, cvode.y))?;
                }
                check("CVodeSetInitStep", CVodeSetInitStep(memory, FIRST_STEP_S))?;
                check("CVodeSetStopTime", CVodeSetStopTime(memory, *stop))?;
                for taken in steps.accepted.. {
                    let t0 = t;
                    let status = check("CVode", CVode(memory, *stop, cvode.y, &mut t, CV_ONE_STEP))
                        .map_err(|error| format!("at {t0:.6} s: {error}"))?;
                    if let Some(observe) = &mut observer {
                        observe(t0, t, state(cvode.y), &mut |t| {
                            let status = CVodeGetDky(memory, t, 0, cvode.interpolated);
                            (status == 0).then(|| state(cvode.interpolated).to_vec())
                        });
                    }
                    if status == CV_TSTOP_RETURN {
                        break;
                    }
                    if taken > MAX_STEPS {
                        return Err(format!("at {t:.6} s: more than {MAX_STEPS} steps"));
                    }
                }
                let (mut accepted, mut errors, mut newton) = (0, 0, 0);
                check("CVodeGetNumSteps", CVodeGetNumSteps(memory, &mut accepted))?;
                check("CVodeGetNumErrTestFails", CVodeGetNumErrTestFails(memory, &mut errors))?;
                check("CVodeGetNumNonlinSolvConvFails", CVodeGetNumNonlinSolvConvFails(memory, &mut newton))?;
                steps.accepted += accepted as usize;
                steps.rejected += (errors + newton) as usize;
            }
            Ok(steps)
        }
    }
}
