//! Corrects the rates of active contacts to the solution of their equations, by impulses along normals and tangents.
//!
//! A stiff damper determines the rate of its contact: within the next step it would remove the fraction h λ/(1 + h λ),
//! λ = W (∂F/∂δ̇ + h ∂F/∂δ), of any rate error. The correction removes that fraction from all rows at once; soft
//! contacts keep their rates, and the scheme its order.

use super::candidates::Row;
use super::contact_space::respond;
use super::dense::{self, refill};
use super::linkage::{Linkage, Twist};

/// A row to correct.
#[derive(Clone, Copy, Debug)]
pub struct CorrectedRow {
    /// Index of the row in the contact space.
    pub index: usize,
    pub row: Row,
    pub target: f64,
    /// Impulse along the row that may be removed.
    pub removable: f64,
    /// h (∂F/∂δ̇ + h ∂F/∂δ) of a normal row, h F ∂μ/∂v of a tangent row.
    pub stiffness: f64,
    /// Coupling of a tangent row to the impulse along the preceding normal row: the friction coefficient μ.
    pub friction_coupling: f64,
}

/// Rows to correct, and the impulses along them.
#[derive(Clone, Debug, Default)]
pub struct RateCorrection {
    pub rows: Vec<CorrectedRow>,
    response: Vec<Twist>,
    w: Vec<f64>,
    /// Rates before the correction.
    rates: Vec<f64>,
    impulses: Vec<f64>,
}

impl RateCorrection {
    /// Returns the correction impulses, each with its row of the contact space.
    pub fn impulses(&self) -> impl Iterator<Item = (usize, f64)> {
        self.rows.iter().map(|row| row.index).zip(self.impulses.iter().copied())
    }

    /// Solves for the impulses and applies them to the velocities.
    pub fn solve(&mut self, linkage: &mut Linkage, velocities: &mut [Twist]) {
        let (count, bodies) = (self.rows.len(), velocities.len());
        self.impulses.clear();
        if count == 0 {
            return;
        }
        respond(self.rows.iter().map(|row| &row.row), linkage, bodies, &mut self.response, &mut self.w);
        // (1 + D W) p = D (target − u), with the stiffness D of each row; tangent rows add −μ times the normal impulse.
        refill(&mut self.rates, self.rows.iter().map(|row| row.row.rate(velocities)));
        self.impulses.extend(self.rates.iter().zip(&self.rows).map(|(rate, row)| row.target - rate));
        for (i, (matrix_row, row)) in self.w.chunks_exact_mut(count).zip(&self.rows).enumerate() {
            self.impulses[i] *= row.stiffness;
            matrix_row.iter_mut().for_each(|w| *w *= row.stiffness);
            matrix_row[i] += 1.0;
            if row.friction_coupling != 0.0 {
                matrix_row[i - 1] += row.friction_coupling;
            }
        }
        if !dense::solve(&mut self.w, &mut self.impulses, count) {
            self.impulses.fill(0.0);
            return;
        }
        for j in 0..count {
            let impulse = self.impulses[j].max(-self.rows[j].removable);
            let clamped = impulse - self.impulses[j];
            self.impulses[j] = impulse;
            // If the normal impulse is clamped, its friction is reduced accordingly.
            if let Some(row) = self.rows.get(j + 1).filter(|row| row.friction_coupling != 0.0) {
                self.impulses[j + 1] -= row.friction_coupling * clamped;
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
        let mean = |(row, before): (&CorrectedRow, &f64)| 0.5 * (before + row.row.rate(velocities));
        let means = self.rows.iter().zip(&self.rates).map(mean);
        let works = means.zip(&self.impulses).map(|(rate, impulse)| rate * impulse);
        self.rows.iter().map(|row| row.index).zip(works)
    }
}
