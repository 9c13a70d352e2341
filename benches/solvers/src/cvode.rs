//! BDF of CVODE (SUNDIALS 6, Debian's package libsundials-dev), called through its C interface.

use std::ffi::{c_int, c_long, c_void};
use std::ptr;

use crate::external_solver::ExternalSolver;
use crate::support::absolute_tolerances;
use crate::support::problem::Problem;
use crate::support::trajectory::Cost;
use crate::vector_field::{FIRST_STEP_S, StepRecorder, Vector, VectorField, start};

const CV_BDF: c_int = 2;
const CV_ONE_STEP: c_int = 2;
const CV_TSTOP_RETURN: c_int = 1;
const MAX_STEPS: c_long = 1_000_000;
/// The default is 10; the first impact needs more.
const MAX_ERROR_TEST_FAILURES: c_int = 100;

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
    fn CVodeSVtolerances(memory: Handle, rtol: f64, atol: Handle) -> c_int;
    fn CVodeSetUserData(memory: Handle, data: *mut c_void) -> c_int;
    fn CVodeSetLinearSolver(memory: Handle, solver: Handle, matrix: Handle) -> c_int;
    fn CVodeSetJacFn(memory: Handle, jacobian: JacFn) -> c_int;
    fn CVodeSetInitStep(memory: Handle, step: f64) -> c_int;
    fn CVodeSetStopTime(memory: Handle, time: f64) -> c_int;
    fn CVodeSetMaxErrTestFails(memory: Handle, count: c_int) -> c_int;
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

extern "C" fn rhs(t: f64, y: Handle, out: Handle, vector_field: *mut c_void) -> c_int {
    // SAFETY: both vectors have four entries, and `vector_field` is the `VectorField` given to CVodeSetUserData.
    unsafe {
        let rates = (*vector_field.cast::<VectorField>()).rates(t, &*N_VGetArrayPointer(y).cast::<Vector>());
        *N_VGetArrayPointer(out).cast::<Vector>() = rates;
    }
    0
}

extern "C" fn jacobian(
    t: f64,
    y: Handle,
    _: Handle,
    out: Handle,
    vector_field: *mut c_void,
    _: Handle,
    _: Handle,
    _: Handle,
) -> c_int {
    // SAFETY: as in `rhs`; the matrix is dense, 4 × 4, by columns.
    unsafe {
        let rows = (*vector_field.cast::<VectorField>()).jacobian(t, &*N_VGetArrayPointer(y).cast::<Vector>());
        let columns = &mut *SUNDenseMatrix_Data(out).cast::<[Vector; 4]>();
        for (i, row) in rows.iter().enumerate() {
            for (k, value) in row.iter().enumerate() {
                columns[k][i] = *value;
            }
        }
    }
    0
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
        // SAFETY: every handle was created by `Cvode::integrate` and is freed once.
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

impl ExternalSolver for Cvode {
    const METHOD: &str = "CVODE BDF";

    fn rtol(&self) -> f64 {
        self.rtol
    }

    fn integrate(&self, problem: &Problem, mut recorder: Option<&mut StepRecorder>) -> Result<Cost, String> {
        let vector_field = VectorField::new(problem);
        let (angle, rate) = absolute_tolerances(self.rtol);
        let mut y = start(problem);
        let mut atol: Vector = [angle, angle, rate, rate];
        let mut interpolated: Vector = [0.0; 4];
        // SAFETY: the arrays and `vector_field` outlive `cvode`, which is dropped before them; all vectors have four entries.
        unsafe {
            let mut context = ptr::null_mut();
            check("SUNContext_Create", SUNContext_Create(ptr::null_mut(), &mut context))?;
            let vector = |data: &mut Vector| N_VMake_Serial(4, data.as_mut_ptr(), context);
            let (y_vector, matrix) = (vector(&mut y), SUNDenseMatrix(4, 4, context));
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
            check("CVodeInit", CVodeInit(memory, rhs, 0.0, cvode.y))?;
            check("CVodeSVtolerances", CVodeSVtolerances(memory, self.rtol, cvode.atol))?;
            check("CVodeSetUserData", CVodeSetUserData(memory, ptr::from_ref(&vector_field).cast_mut().cast()))?;
            check("CVodeSetLinearSolver", CVodeSetLinearSolver(memory, cvode.linear, cvode.matrix))?;
            check("CVodeSetJacFn", CVodeSetJacFn(memory, jacobian))?;
            check("CVodeSetInitStep", CVodeSetInitStep(memory, FIRST_STEP_S))?;
            check("CVodeSetMaxErrTestFails", CVodeSetMaxErrTestFails(memory, MAX_ERROR_TEST_FAILURES))?;
            check("CVodeSetStopTime", CVodeSetStopTime(memory, problem.duration_s()))?;
            let (mut t, mut steps) = (0.0, 0);
            loop {
                let t0 = t;
                let status = check("CVode", CVode(memory, problem.duration_s(), cvode.y, &mut t, CV_ONE_STEP))?;
                if let Some(recorder) = &mut recorder {
                    let end = *N_VGetArrayPointer(cvode.y).cast::<Vector>();
                    recorder.step(t0, t, &end, |t| {
                        let status = CVodeGetDky(memory, t, 0, cvode.interpolated);
                        (status == 0).then(|| *N_VGetArrayPointer(cvode.interpolated).cast::<Vector>())
                    });
                }
                if status == CV_TSTOP_RETURN {
                    break;
                }
                steps += 1;
                if steps > MAX_STEPS {
                    return Err(format!("more than {MAX_STEPS} steps"));
                }
            }
            let (mut accepted, mut errors, mut newton) = (0, 0, 0);
            check("CVodeGetNumSteps", CVodeGetNumSteps(memory, &mut accepted))?;
            check("CVodeGetNumErrTestFails", CVodeGetNumErrTestFails(memory, &mut errors))?;
            check("CVodeGetNumNonlinSolvConvFails", CVodeGetNumNonlinSolvConvFails(memory, &mut newton))?;
            Ok(vector_field.cost(accepted as usize, (errors + newton) as usize))
        }
    }
}
