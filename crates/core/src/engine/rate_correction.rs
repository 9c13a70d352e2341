//! Corrects the rates of active contacts to the solution of their equations, by impulses along normals and tangents.
//!
//! A stiff damper determines the rate of its contact: within the next step it would remove the fraction h λ/(1 + h λ),
//! λ = W (∂F/∂δ̇ + h ∂F/∂δ), of any rate error. The correction removes that fraction from all rows at once; soft
//! contacts keep their rates, and the scheme its order.

use super::candidates::Row;
use super::contact_space::respond;
use super::dense;
use super::linkage::{Linkage, Twist};

/// Rows to correct, their target rates, and the impulses already scheduled along them.
#[derive(Clone, Debug, Default)]
pub struct RateCorrection {
    /// Row of the contact space for each corrected row.
    indices: Vec<usize>,
    rows: Vec<Row>,
    target: Vec<f64>,
    removable: Vec<f64>,
    stiffness: Vec<f64>,
    /// Coupling to the impulse along the preceding normal row: friction due to the normal impulse.
    friction_coupling: Vec<f64>,
    response: Vec<Twist>,
    w: Vec<f64>,
    /// Rates before the correction.
    rates: Vec<f64>,
    impulses: Vec<f64>,
}

impl RateCorrection {
    /// Removes all rows.
    pub fn clear(&mut self) {
        self.indices.clear();
        self.rows.clear();
        self.target.clear();
        self.removable.clear();
        self.stiffness.clear();
        self.friction_coupling.clear();
        self.impulses.clear();
    }

    /// Adds the normal row of a contact: target rate, impulse along it that may be removed, and h (∂F/∂δ̇ + h ∂F/∂δ).
    pub fn add_normal_row(&mut self, index: usize, row: Row, target: f64, removable: f64, stiffness: f64) {
        self.push(index, row, target, removable, stiffness, 0.0);
    }

    /// Adds the tangent row of the contact added last: friction coefficient μ, and h F ∂μ/∂v where it creeps.
    pub fn add_tangent_row(&mut self, index: usize, row: Row, target: f64, mu: f64, creep: f64) {
        self.push(index, row, target, f64::INFINITY, creep, mu);
    }

    fn push(&mut self, index: usize, row: Row, target: f64, removable: f64, stiffness: f64, friction_coupling: f64) {
        self.indices.push(index);
        self.rows.push(row);
        self.target.push(target);
        self.removable.push(removable);
        self.stiffness.push(stiffness);
        self.friction_coupling.push(friction_coupling);
    }

    /// Returns the correction impulses, each with its row of the contact space.
    pub fn impulses(&self) -> impl Iterator<Item = (usize, f64)> {
        self.indices.iter().copied().zip(self.impulses.iter().copied())
    }

    /// Solves for the impulses and applies them to the velocities.
    pub fn solve(&mut self, linkage: &mut Linkage, velocities: &mut [Twist]) {
        let (count, bodies) = (self.rows.len(), velocities.len());
        if count == 0 {
            return;
        }
        respond(&self.rows, linkage, bodies, &mut self.response, &mut self.w);
        // (1 + D W) p = D (target − u), with the stiffness D of each row; tangent rows add −μ times the normal impulse.
        self.rates.clear();
        self.rates.extend(self.rows.iter().map(|row| row.rate(velocities)));
        self.impulses.extend(self.rates.iter().zip(&self.target).map(|(rate, target)| target - rate));
        for (i, (matrix_row, stiffness)) in self.w.chunks_exact_mut(count).zip(&self.stiffness).enumerate() {
            self.impulses[i] *= stiffness;
            matrix_row.iter_mut().for_each(|w| *w *= stiffness);
            matrix_row[i] += 1.0;
            if self.friction_coupling[i] != 0.0 {
                matrix_row[i - 1] += self.friction_coupling[i];
            }
        }
        if !dense::solve(&mut self.w, &mut self.impulses, count) {
            self.impulses.fill(0.0);
            return;
        }
        for j in 0..count {
            let impulse = self.impulses[j].max(-self.removable[j]);
            let clamped = impulse - self.impulses[j];
            self.impulses[j] = impulse;
            // If the normal impulse is clamped, its friction is reduced accordingly.
            if let Some(coupling) = self.friction_coupling.get(j + 1).filter(|coupling| **coupling != 0.0) {
                self.impulses[j + 1] -= coupling * clamped;
            }
            let response = &self.response[j * bodies..(j + 1) * bodies];
            for (v, change) in velocities.iter_mut().zip(response) {
                for axis in 0..3 {
                    v[axis] += impulse * change[axis];
                }
            }
        }
    }

    /// Returns the index of each corrected row of the contact space and the work of its impulse on the bodies: the
    /// impulse times the mean of the rates before and after the impulse.
    pub fn impulse_work(&self, velocities: &[Twist]) -> impl Iterator<Item = (usize, f64)> {
        let mean = |(row, before): (&Row, &f64)| 0.5 * (before + row.rate(velocities));
        let means = self.rows.iter().zip(&self.rates).map(mean);
        let works = means.zip(&self.impulses).map(|(rate, impulse)| rate * impulse);
        self.indices.iter().copied().zip(works)
    }
}
