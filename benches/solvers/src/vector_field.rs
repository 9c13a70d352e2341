//! Right-hand side for the published solvers: the analytic model with clamped force laws and its exact Jacobian. Counts
//! evaluations.

use std::cell::Cell;

use phalanx::analytic::{ContactState, FingerMode, Model};
use phalanx::gripper::FingerContact;
use phalanx::integrator::{Fixed, Linearised, Rates, System};

use crate::equations::Equations;
use crate::support::problem::Problem;
use crate::support::trajectory::{Cost, EndState, GRID_S, Trajectory};

/// First step of all solvers, including those of phalanx. The step guesses of the solvers do not account for the joint limit
/// at which the finger starts.
pub const FIRST_STEP_S: f64 = 1e-8;

/// Limit of accepted steps.
pub const MAX_STEPS: usize = 1_000_000;

/// q11, q21 and their rates.
pub type Vector = [f64; 4];

/// ẏ = f(t, y) and ∂f/∂y.
pub struct VectorField<'a> {
    model: &'a Model,
    rhs: Cell<u64>,
    jacobians: Cell<u64>,
}

impl<'a> VectorField<'a> {
    pub fn new(problem: &'a Problem) -> Self {
        Self { model: &problem.model, rhs: Cell::new(0), jacobians: Cell::new(0) }
    }

    #[inline(always)]
    pub fn rates(&self, t: f64, y: &Vector) -> Vector {
        self.rhs.set(self.rhs.get() + 1);
        let [q11, q21, v11, v21] = *y;
        let mut rates = Rates::zero(Fixed);
        self.model.rates(t, &[q11, q21], &[v11, v21], &FingerMode::CLAMPED, &mut rates);
        [v11, v21, rates.a[0], rates.a[1]]
    }

    #[inline(always)]
    pub fn jacobian(&self, t: f64, y: &Vector) -> [Vector; 4] {
        self.jacobians.set(self.jacobians.get() + 1);
        let [q11, q21, v11, v21] = *y;
        let mut derivatives = Linearised::zero(Fixed);
        self.model.linearise(t, &[q11, q21], &[v11, v21], &FingerMode::CLAMPED, &mut derivatives);
        let row =
            |i: usize| [derivatives.a_q[i][0], derivatives.a_q[i][1], derivatives.a_v[i][0], derivatives.a_v[i][1]];
        [[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], row(0), row(1)]
    }

    pub fn cost(&self, steps: usize, rejected: usize) -> Cost {
        Cost { rhs: self.rhs.get(), jacobians: self.jacobians.get(), steps: steps as u64, rejected: rejected as u64 }
    }
}

impl Equations for VectorField<'_> {
    fn coordinate_count(&self) -> usize {
        2
    }

    fn rates(&self, t: f64, y: &[f64], out: &mut [f64]) {
        out.copy_from_slice(&VectorField::rates(self, t, &array(y)));
    }

    fn jacobian(&self, t: f64, y: &[f64], columns: &mut [f64]) {
        for (i, row) in VectorField::jacobian(self, t, &array(y)).iter().enumerate() {
            row.iter().enumerate().for_each(|(k, value)| columns[4 * k + i] = *value);
        }
    }
}

/// Returns a state as an array.
pub fn array(y: &[f64]) -> Vector {
    std::array::from_fn(|i| y[i])
}

/// Returns the initial state of a problem.
pub fn start(problem: &Problem) -> Vector {
    let (q, v) = (problem.start.q, problem.start.v);
    [q[0], q[1], v[0], v[1]]
}

/// Records the trajectory of a solver step by step.
pub struct StepRecorder<'a> {
    model: &'a Model,
    grid: Vec<[f64; 2]>,
    first_contact_s: [Option<f64>; 2],
    max_penetration_m: f64,
}

impl<'a> StepRecorder<'a> {
    pub fn new(problem: &'a Problem) -> Self {
        let q = problem.start.q;
        Self { model: &problem.model, grid: vec![q], first_contact_s: [None; 2], max_penetration_m: 0.0 }
    }

    /// Records an accepted step that ends in `y` at `t1`; `interpolate` is the dense output of the solver.
    pub fn step(&mut self, t0: f64, t1: f64, y: &Vector, mut interpolate: impl FnMut(f64) -> Option<Vector>) {
        loop {
            let t = self.grid.len() as f64 * GRID_S;
            if t > t1 + 1e-15 {
                break;
            }
            let Some(y) = (if t < t1 { interpolate(t) } else { Some(*y) }) else { break };
            self.grid.push([y[0], y[1]]);
        }
        for (index, contact) in [FingerContact::Proximal, FingerContact::Distal].into_iter().enumerate() {
            let depth = |y: &Vector| {
                let reading = self.model.contact_reading([y[0], y[1]], [y[2], y[3]], contact, ContactState::Clamped);
                reading.map_or(f64::NEG_INFINITY, |r| r.delta)
            };
            let final_depth = depth(y);
            self.max_penetration_m = self.max_penetration_m.max(final_depth);
            if final_depth > 0.0 && self.first_contact_s[index].is_none() {
                let (mut low, mut high) = (t0, t1);
                for _ in 0..50 {
                    let middle = 0.5 * (low + high);
                    match interpolate(middle) {
                        Some(y) if depth(&y) > 0.0 => high = middle,
                        Some(_) => low = middle,
                        None => break,
                    }
                }
                self.first_contact_s[index] = Some(high);
            }
        }
    }

    /// Returns the trajectory.
    pub fn finish(self, result: Result<Cost, String>) -> Trajectory {
        let (end_state, cost) = match result {
            Ok(cost) => (EndState::Complete, cost),
            Err(reason) => (EndState::Failed(reason), Cost::default()),
        };
        let Self { grid, first_contact_s, max_penetration_m, .. } = self;
        Trajectory { grid, first_contact_s, impulse: None, max_penetration_m: Some(max_penetration_m), end_state, cost }
    }
}
