//! One implicit stage of contact: finds the rates at which the forces of the contact laws agree with the resulting
//! motion.
//!
//! u = ũ + h (b + W F(g̃ + h u_n, u)), with the contact laws F including clamp and friction. Newton's method uses the
//! exact Jacobian; a step that does not reduce the residual is halved. The residual of every solution, relative to the
//! terms of the equation, is below [`MAX_RESIDUAL`]. If no solution is found, the caller shortens h; for h → 0 the
//! equation becomes u = ũ, so a solution exists for small h.

use super::contact_space::ContactSpace;
use super::dense::{self, reset};
use crate::law::normal_force;

/// Largest relative residual of a solution.
const MAX_RESIDUAL: f64 = 1e-9;
/// Relative residual at which the iteration stops.
const TARGET_RESIDUAL: f64 = 1e-10;
/// Fraction of its terms below which a residual is rounding error.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Smallest force scale of bristle friction, N. Without it, the residual of a contact with a vanishing normal force
/// would be dominated by rounding errors, such as slip rates of 1e-26 m/s.
const MIN_FORCE_SCALE_N: f64 = 1.0;
/// Fraction of the rate resolution below which a residual is ignored: a row of touching discs transmits rates of 1e-30
/// m/s and less.
const MIN_RATE_SCALE: f64 = 1e-9;
/// Largest number of Newton iterations.
const MAX_ITERATIONS: u32 = 30;
/// Largest number of halvings of a Newton step in the line search.
const MAX_HALVINGS: u32 = 12;

/// Initial values of an implicit stage.
pub struct Stage<'a> {
    /// Rates ũ at h = 0.
    pub rate: &'a [f64],
    /// Gaps g̃ at h = 0, one per contact.
    pub gap: &'a [f64],
    /// Bristle states, one per contact.
    pub bristle_state: &'a [f64],
    pub h: f64,
}

/// Working arrays of a stage, sized once per contact space.
#[derive(Clone, Debug, Default)]
pub(crate) struct Workspace {
    residual: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
    jacobian: Vec<f64>,
    /// ∂F/∂u: derivative of each row's force by its own rate.
    diagonal_derivative: Vec<f64>,
    /// Derivative of the force of each tangent row by the normal rate.
    cross_derivative: Vec<f64>,
    /// Force magnitudes that determine the rounding error of the forces.
    force_scale: Vec<f64>,
    pub force: Vec<f64>,
    /// Bristle states at the solution, one per contact.
    pub bristle_state: Vec<f64>,
    /// Whether each bristle state is at the edge of its friction cone.
    pub is_slipping: Vec<bool>,
}

/// No solution was found within the allowed iterations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NotConverged {
    pub residual: f64,
}

impl Workspace {
    /// Resizes all arrays for a contact space.
    pub fn resize(&mut self, rows: usize, contacts: usize) {
        reset(&mut self.bristle_state, contacts, 0.0);
        reset(&mut self.is_slipping, contacts, false);
        reset(&mut self.jacobian, rows * rows, 0.0);
        let Self { residual, step, trial, diagonal_derivative, cross_derivative, force_scale, force, .. } = self;
        for list in [residual, step, trial, diagonal_derivative, cross_derivative, force_scale, force] {
            reset(list, rows, 0.0);
        }
    }

    /// Solves a stage and returns the number of iterations. `rate` is the initial guess on entry and the solution on
    /// return; `self.force` contains the forces there.
    ///
    /// # Errors
    /// Returns an error if the iteration does not converge within the allowed number of iterations.
    pub fn solve(&mut self, space: &ContactSpace, stage: &Stage, rate: &mut [f64]) -> Result<u32, NotConverged> {
        // Compile-time sizes are faster; contact spaces are small.
        match space.len() {
            1 => self.iterate(space, stage, rate, 1),
            2 => self.iterate(space, stage, rate, 2),
            3 => self.iterate(space, stage, rate, 3),
            4 => self.iterate(space, stage, rate, 4),
            5 => self.iterate(space, stage, rate, 5),
            rows => self.iterate(space, stage, rate, rows),
        }
    }

    /// Newton's method with step halving.
    #[inline(always)]
    fn iterate(
        &mut self,
        space: &ContactSpace,
        stage: &Stage,
        rate: &mut [f64],
        rows: usize,
    ) -> Result<u32, NotConverged> {
        let mut residual = self.evaluate(space, stage, rate, rows);
        for iteration in 0..MAX_ITERATIONS {
            if residual <= TARGET_RESIDUAL {
                return Ok(iteration);
            }
            self.assemble_jacobian(space, stage.h, rows);
            self.step.copy_from_slice(&self.residual);
            if !dense::eliminate(&mut self.jacobian[..rows * rows], &mut self.step[..rows], rows) {
                break;
            }
            let before = residual;
            let mut fraction = 1.0;
            for _ in 0..MAX_HALVINGS {
                for ((trial, rate), step) in self.trial.iter_mut().zip(&*rate).zip(&self.step) {
                    *trial = rate - fraction * step;
                }
                let trial = std::mem::take(&mut self.trial);
                residual = self.evaluate(space, stage, &trial, rows);
                self.trial = trial;
                if residual < before || before <= MAX_RESIDUAL {
                    break;
                }
                fraction *= 0.5;
            }
            if residual < before {
                rate.copy_from_slice(&self.trial);
                continue;
            }
            // No further progress: rounding, or a kink that Newton's method cannot pass.
            residual = self.evaluate(space, stage, rate, rows);
            if residual <= MAX_RESIDUAL {
                return Ok(iteration);
            }
            break;
        }
        if residual <= MAX_RESIDUAL { Ok(MAX_ITERATIONS) } else { Err(NotConverged { residual }) }
    }

    /// Filters an error: e ← (1 − h W ∂F/∂u)⁻¹ e at the last solution.
    pub fn filter(&mut self, space: &ContactSpace, h: f64, error: &mut [f64]) {
        self.assemble_jacobian(space, h, space.len());
        dense::solve(&mut self.jacobian, error, space.len());
    }

    /// Evaluates forces, their derivatives and the residual at given rates; returns the residual relative to the terms
    /// of the equation.
    #[inline(always)]
    fn evaluate(&mut self, space: &ContactSpace, stage: &Stage, rate: &[f64], rows: usize) -> f64 {
        let h = stage.h;
        for (index, contact) in space.active_contacts.iter().enumerate() {
            let n = contact.normal;
            let gap = stage.gap[index] + h * rate[n];
            let law = normal_force(&contact.candidate.law, -gap, -rate[n]);
            // The law uses penetration, the row uses the gap.
            let slope = -(h * law.d_delta + law.d_rate);
            (self.force[n], self.diagonal_derivative[n]) = (law.force, slope);
            self.force_scale[n] = law.force.abs();
            if let Some(t) = contact.tangent {
                let bristle_state = stage.bristle_state[index];
                let friction = contact.candidate.friction_at_step_end([rate[t], bristle_state, law.force], h);
                self.force[t] = -friction.force;
                self.force_scale[t] = match contact.candidate.bristle() {
                    Some(bristle) => {
                        self.is_slipping[index] = friction.d_normal != 0.0;
                        friction.force.abs().max(bristle.damping_n_s_per_m * bristle_state.abs()).max(MIN_FORCE_SCALE_N)
                    }
                    None => {
                        let slip_scale = contact.candidate.motor.map_or(0.0, |motor| 1.0 + motor.slope * rate[t].abs());
                        law.force.abs() * friction.d_normal.abs().max(1.0).max(slip_scale)
                    }
                };
                self.diagonal_derivative[t] = -friction.d_slip;
                self.cross_derivative[t] = -friction.d_normal * slope;
                self.bristle_state[index] = friction.state;
            }
        }
        let mut largest: f64 = 0.0;
        for (i, w) in space.w.chunks_exact(rows).enumerate() {
            let (mut contact_acceleration, mut terms) = (0.0, 0.0);
            for ((w, force), force_scale) in w.iter().zip(&self.force).zip(&self.force_scale) {
                contact_acceleration += w * force;
                terms += w.abs() * force_scale;
            }
            let (final_rate, initial_rate, free) = (rate[i], stage.rate[i], space.free[i]);
            let scale = (final_rate.abs() + initial_rate.abs() + h * (free.abs() + contact_acceleration.abs()))
                .max(MIN_RATE_SCALE * space.rate_resolution.get(i).copied().unwrap_or(0.0));
            self.residual[i] = final_rate - initial_rate - h * (free + contact_acceleration);
            // Opposite forces can cancel, and the friction coefficient has an absolute rounding error: the remainder,
            // or a slip rate of 1e-17 m/s, has no significant digits.
            if self.residual[i].abs() > ROUNDING * (final_rate.abs() + initial_rate.abs() + h * (free.abs() + terms)) {
                largest = largest.max(self.residual[i].abs() / scale);
            }
        }
        // A NaN force must not pass as a small residual.
        if self.residual.iter().all(|r| r.is_finite()) { largest } else { f64::INFINITY }
    }

    /// Assembles the Jacobian 1 − h W ∂F/∂u.
    #[inline(always)]
    fn assemble_jacobian(&mut self, space: &ContactSpace, h: f64, rows: usize) {
        for i in 0..rows {
            let w = &space.w[i * rows..(i + 1) * rows];
            let jacobian_row = &mut self.jacobian[i * rows..(i + 1) * rows];
            for contact in &space.active_contacts {
                let n = contact.normal;
                jacobian_row[n] = -h * w[n] * self.diagonal_derivative[n];
                if let Some(t) = contact.tangent {
                    jacobian_row[n] -= h * w[t] * self.cross_derivative[t];
                    jacobian_row[t] = -h * w[t] * self.diagonal_derivative[t];
                }
            }
            jacobian_row[i] += 1.0;
        }
    }
}
