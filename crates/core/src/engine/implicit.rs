//! One implicit stage of contact: find the rates at which the laws' forces agree with the motion they cause.
//!
//! u = ũ + h (b + W F(g̃ + h u_n, u)), F the contact laws with clamp and friction. Newton's method with the exact
//! Jacobian; a step that does not bring the residual down is halved. Every solution carries its certificate: the residual,
//! relative to the terms of the equation, is below [`CERTIFIED`]. Where none is found the caller shortens h; for h → 0
//! the equation becomes u = ũ, so that it is found in the end.

use super::dense;
use super::space::Space;
use crate::law::normal_force;

/// Relative residual a solution must have…
const CERTIFIED: f64 = 1e-9;
/// …and the one that is tried for.
const WANTED: f64 = 1e-10;
/// Part of its terms below which a residual is rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Friction that holds has no digits below those of this force, N: where what presses comes to nothing, slips are of 1e-26 m/s.
const FINEST_N: f64 = 1.0;
/// Part of a rate that moves a gap by its last digits, below which a residual does not matter: a row of touching discs hands on
/// rates of 1e-30 m/s and less.
const FINEST: f64 = 1e-9;
const MAX_ITERATIONS: u32 = 30;
const MAX_HALVINGS: u32 = 12;

/// What an implicit stage starts from.
pub struct Stage<'a> {
    /// Rates ũ and gaps g̃ (one per site) at h = 0.
    pub rate: &'a [f64],
    pub gap: &'a [f64],
    /// Memories of bristles, one per site.
    pub memory: &'a [f64],
    pub h: f64,
}

/// Arrays a stage works in, sized once per contact space.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    residual: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
    jacobian: Vec<f64>,
    /// ∂F/∂u: of each row's force by its own rate, and of tangent rows by the normal rate.
    own: Vec<f64>,
    cross: Vec<f64>,
    /// Sizes to whose last digits the forces are known.
    known: Vec<f64>,
    pub force: Vec<f64>,
    /// Memories of bristles there, one per site, and whether they are at the end of their cones.
    pub memory: Vec<f64>,
    pub slips: Vec<bool>,
}

/// The laws have no solution within the iterations allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotConverged {
    pub residual: f64,
}

impl Workspace {
    pub fn resize(&mut self, rows: usize, sites: usize) {
        self.memory.clear();
        self.memory.resize(sites, 0.0);
        self.slips.clear();
        self.slips.resize(sites, false);
        for list in [
            &mut self.residual,
            &mut self.step,
            &mut self.trial,
            &mut self.own,
            &mut self.cross,
            &mut self.known,
            &mut self.force,
        ] {
            list.clear();
            list.resize(rows, 0.0);
        }
        self.jacobian.clear();
        self.jacobian.resize(rows * rows, 0.0);
    }

    /// Solves a stage; `rate` holds a guess on entry and the solution on return, `self.force` the forces there. Returns the
    /// number of iterations.
    pub fn solve(&mut self, space: &Space, stage: &Stage, rate: &mut [f64]) -> Result<u32, NotConverged> {
        // Sizes the compiler knows; contact spaces are small.
        match space.len() {
            1 => self.iterate(space, stage, rate, 1),
            2 => self.iterate(space, stage, rate, 2),
            3 => self.iterate(space, stage, rate, 3),
            4 => self.iterate(space, stage, rate, 4),
            5 => self.iterate(space, stage, rate, 5),
            rows => self.iterate(space, stage, rate, rows),
        }
    }

    #[inline(always)]
    fn iterate(&mut self, space: &Space, stage: &Stage, rate: &mut [f64], rows: usize) -> Result<u32, NotConverged> {
        let mut size = self.evaluate(space, stage, rate, rows);
        for iteration in 0..MAX_ITERATIONS {
            if size <= WANTED {
                return Ok(iteration);
            }
            self.assemble_jacobian(space, stage.h, rows);
            self.step.copy_from_slice(&self.residual);
            if !dense::eliminate(&mut self.jacobian[..rows * rows], &mut self.step[..rows], rows) {
                break;
            }
            let before = size;
            let mut fraction = 1.0;
            for _ in 0..MAX_HALVINGS {
                for ((trial, rate), step) in self.trial.iter_mut().zip(&*rate).zip(&self.step) {
                    *trial = rate - fraction * step;
                }
                let trial = std::mem::take(&mut self.trial);
                size = self.evaluate(space, stage, &trial, rows);
                self.trial = trial;
                if size < before || before <= CERTIFIED {
                    break;
                }
                fraction *= 0.5;
            }
            if size < before {
                rate.copy_from_slice(&self.trial);
                continue;
            }
            // No progress left: rounding, or a kink Newton cannot pass.
            size = self.evaluate(space, stage, rate, rows);
            if size <= CERTIFIED {
                return Ok(iteration);
            }
            break;
        }
        if size <= CERTIFIED { Ok(MAX_ITERATIONS) } else { Err(NotConverged { residual: size }) }
    }

    /// e ← (1 − h W ∂F/∂u)⁻¹ e at the last solution.
    pub fn filter(&mut self, space: &Space, h: f64, error: &mut [f64]) {
        self.assemble_jacobian(space, h, space.len());
        dense::solve(&mut self.jacobian, error, space.len());
    }

    /// Forces and their derivatives at given rates, the residual, and its size relative to the terms it is made of.
    #[inline(always)]
    fn evaluate(&mut self, space: &Space, stage: &Stage, rate: &[f64], rows: usize) -> f64 {
        let h = stage.h;
        for (index, site) in space.sites.iter().enumerate() {
            let n = site.normal;
            let gap = stage.gap[index] + h * rate[n];
            let law = normal_force(&site.touch.law, -gap, -rate[n]);
            // The law counts in penetration, the row in gap.
            let slope = -(h * law.d_delta + law.d_rate);
            (self.force[n], self.own[n]) = (law.force, slope);
            self.known[n] = law.force.abs();
            if let Some(t) = site.tangent {
                let memory = stage.memory[index];
                let found = site.touch.friction_after([rate[t], memory, law.force], h);
                self.force[t] = -found.pull;
                self.known[t] = match site.touch.bristle() {
                    Some(bristle) => {
                        self.slips[index] = found.by_normal != 0.0;
                        found.pull.abs().max(bristle.damping_n_s_per_m * memory.abs()).max(FINEST_N)
                    }
                    None => {
                        let slowed = site.touch.drive.map_or(0.0, |drive| 1.0 + drive.slowing * rate[t].abs());
                        law.force.abs() * found.by_normal.abs().max(1.0).max(slowed)
                    }
                };
                self.own[t] = -found.by_slip;
                self.cross[t] = -found.by_normal * slope;
                self.memory[index] = found.memory;
            }
        }
        let mut largest: f64 = 0.0;
        for (i, w) in space.w.chunks_exact(rows).enumerate() {
            let (mut pushed, mut terms) = (0.0, 0.0);
            for ((w, force), known) in w.iter().zip(&self.force).zip(&self.known) {
                pushed += w * force;
                terms += w.abs() * known;
            }
            let (now, from, free) = (rate[i], stage.rate[i], space.free[i]);
            let scale = (now.abs() + from.abs() + h * (free.abs() + pushed.abs()))
                .max(FINEST * space.finest.get(i).copied().unwrap_or(0.0));
            self.residual[i] = now - from - h * (free + pushed);
            // Pushes of opposite sides may cancel, and a coefficient of friction is known to some ε, not to a part of itself: what is left
            // of them then, or of a slip of 1e-17 m/s, has no digits.
            if self.residual[i].abs() > ROUNDING * (now.abs() + from.abs() + h * (free.abs() + terms)) {
                largest = largest.max(self.residual[i].abs() / scale);
            }
        }
        // A force that is no number must not pass as a small residual.
        if self.residual.iter().all(|r| r.is_finite()) { largest } else { f64::INFINITY }
    }

    /// 1 − h W ∂F/∂u.
    #[inline(always)]
    fn assemble_jacobian(&mut self, space: &Space, h: f64, rows: usize) {
        for i in 0..rows {
            let w = &space.w[i * rows..(i + 1) * rows];
            let line = &mut self.jacobian[i * rows..(i + 1) * rows];
            for site in &space.sites {
                let n = site.normal;
                line[n] = -h * w[n] * self.own[n];
                if let Some(t) = site.tangent {
                    line[n] -= h * w[t] * self.cross[t];
                    line[t] = -h * w[t] * self.own[t];
                }
            }
            line[i] += 1.0;
        }
    }
}
