//! The right-hand side the published solvers get: exactly that of the analytic model, with its natural, clamped branches,
//! and its exact Jacobian. Evaluations are counted.

use std::cell::Cell;

use phalanx::analytic::{FingerMode, Model, SiteState};
use phalanx::gripper::Site;
use phalanx::integrator::System;

use crate::support::problem::Problem;
use crate::support::track::{Cost, Ended, GRID_S, Track};

/// The first step all of them get, as ours do: their own guesses know nothing of the joint limit the finger starts at.
pub const FIRST_STEP_S: f64 = 1e-8;

/// q11, q21 and their rates.
pub type Vector = [f64; 4];

/// ẏ = f(t, y) and ∂f/∂y.
pub struct Field<'a> {
    model: &'a Model,
    rhs: Cell<u64>,
    jacobians: Cell<u64>,
}

impl<'a> Field<'a> {
    pub fn new(problem: &'a Problem) -> Self {
        Self { model: &problem.model, rhs: Cell::new(0), jacobians: Cell::new(0) }
    }

    #[inline(always)]
    pub fn rates(&self, t: f64, y: &Vector) -> Vector {
        self.rhs.set(self.rhs.get() + 1);
        let [q11, q21, v11, v21] = *y;
        let a = self.model.rates(t, &[q11, q21], &[v11, v21], &FingerMode::NATURAL).a;
        [v11, v21, a[0], a[1]]
    }

    #[inline(always)]
    pub fn jacobian(&self, t: f64, y: &Vector) -> [Vector; 4] {
        self.jacobians.set(self.jacobians.get() + 1);
        let [q11, q21, v11, v21] = *y;
        let at = self.model.linearise(t, &[q11, q21], &[v11, v21], &FingerMode::NATURAL);
        let row = |i: usize| [at.a_q[i][0], at.a_q[i][1], at.a_v[i][0], at.a_v[i][1]];
        [[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], row(0), row(1)]
    }

    pub fn cost(&self, steps: usize, rejected: usize) -> Cost {
        Cost { rhs: self.rhs.get(), jacobians: self.jacobians.get(), steps: steps as u64, rejected: rejected as u64 }
    }
}

/// Where a problem starts.
pub fn start(problem: &Problem) -> Vector {
    let (q, v) = (problem.start.q, problem.start.v);
    [q[0], q[1], v[0], v[1]]
}

/// Records the trajectory of a solver step by step.
pub struct Watcher<'a> {
    model: &'a Model,
    grid: Vec<[f64; 2]>,
    touch_s: [Option<f64>; 2],
    deepest_m: f64,
}

impl<'a> Watcher<'a> {
    pub fn new(problem: &'a Problem) -> Self {
        let q = problem.start.q;
        Self { model: &problem.model, grid: vec![q], touch_s: [None; 2], deepest_m: 0.0 }
    }

    /// An accepted step that ends in `y` at `t1`; `inside` is the solver's own dense output.
    pub fn step(&mut self, t0: f64, t1: f64, y: &Vector, mut inside: impl FnMut(f64) -> Option<Vector>) {
        loop {
            let t = self.grid.len() as f64 * GRID_S;
            if t > t1 + 1e-15 {
                break;
            }
            let Some(y) = (if t < t1 { inside(t) } else { Some(*y) }) else { break };
            self.grid.push([y[0], y[1]]);
        }
        for (index, site) in [Site::Proximal, Site::Distal].into_iter().enumerate() {
            let depth = |y: &Vector| {
                let reading = self.model.reading([y[0], y[1]], [y[2], y[3]], site, SiteState::Natural);
                reading.map_or(f64::NEG_INFINITY, |r| r.delta)
            };
            let at_end = depth(y);
            self.deepest_m = self.deepest_m.max(at_end);
            if at_end > 0.0 && self.touch_s[index].is_none() {
                let (mut low, mut high) = (t0, t1);
                for _ in 0..50 {
                    let middle = 0.5 * (low + high);
                    match inside(middle) {
                        Some(y) if depth(&y) > 0.0 => high = middle,
                        Some(_) => low = middle,
                        None => break,
                    }
                }
                self.touch_s[index] = Some(high);
            }
        }
    }

    pub fn finish(self, result: Result<Cost, String>) -> Track {
        let (ended, cost) = match result {
            Ok(cost) => (Ended::Complete, cost),
            Err(reason) => (Ended::Failed(reason), Cost::default()),
        };
        let Self { grid, touch_s, deepest_m, .. } = self;
        Track { grid, touch_s, impulse: None, deepest_m: Some(deepest_m), ended, cost }
    }
}
