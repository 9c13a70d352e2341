//! Brings the rates of pressing contacts to what their equations say, by impulses along their normals and tangents.
//!
//! A stiff damper does not leave a contact a rate of its own: within the next step it would take away the share
//! h λ/(1 + h λ), λ = W (∂F/∂δ̇ + h ∂F/∂δ), of whatever is there. That share is taken away here, of all rows at once; a soft contact
//! keeps its rate, and the scheme its order.

use super::dense;
use super::linkage::{Linkage, Twist};
use super::space::respond;
use super::touch::Row;

/// Rows to be settled, the rates they shall have, and the impulses that are already under way along them.
#[derive(Clone, Debug, Default)]
pub struct Settled {
    /// Which row of the contact space each is.
    indices: Vec<usize>,
    rows: Vec<Row>,
    wanted: Vec<f64>,
    available: Vec<f64>,
    stiffness: Vec<f64>,
    /// Part of the impulse along the row before that this one takes away: friction of what the normal gains.
    drag: Vec<f64>,
    response: Vec<Twist>,
    w: Vec<f64>,
    /// Rates before anything is settled.
    rates: Vec<f64>,
    size: Vec<f64>,
}

impl Settled {
    pub fn begin(&mut self) {
        self.indices.clear();
        self.rows.clear();
        self.wanted.clear();
        self.available.clear();
        self.stiffness.clear();
        self.drag.clear();
        self.size.clear();
    }

    /// The normal row of a contact, the rate it shall have, the impulse along it that may be taken back, and
    /// h (∂F/∂δ̇ + h ∂F/∂δ).
    pub fn take(&mut self, index: usize, row: Row, wanted: f64, available: f64, stiffness: f64) {
        self.push(index, row, wanted, available, stiffness, 0.0);
    }

    /// The tangent row of the contact taken last: its coefficient of friction μ, and h F ∂μ/∂v where it creeps.
    pub fn take_slip(&mut self, index: usize, row: Row, wanted: f64, mu: f64, creep: f64) {
        self.push(index, row, wanted, f64::INFINITY, creep, mu);
    }

    fn push(&mut self, index: usize, row: Row, wanted: f64, available: f64, stiffness: f64, drag: f64) {
        self.indices.push(index);
        self.rows.push(row);
        self.wanted.push(wanted);
        self.available.push(available);
        self.stiffness.push(stiffness);
        self.drag.push(drag);
    }

    /// The impulses found, each with the row of the contact space it is along.
    pub fn found(&self) -> impl Iterator<Item = (usize, f64)> {
        self.indices.iter().copied().zip(self.size.iter().copied())
    }

    /// Changes velocities so that every row has its rate.
    pub fn solve(&mut self, linkage: &mut Linkage, velocities: &mut [Twist]) {
        let (count, bodies) = (self.rows.len(), velocities.len());
        if count == 0 {
            return;
        }
        respond(&self.rows, linkage, bodies, &mut self.response, &mut self.w);
        // (1 + D W) p = D (wanted − u), D the stiffness of each row; along a tangent −μ times its normal's impulse besides.
        self.rates.clear();
        self.rates.extend(self.rows.iter().map(|row| row.rate(velocities)));
        self.size.extend(self.rates.iter().zip(&self.wanted).map(|(rate, wanted)| wanted - rate));
        for (i, (line, stiffness)) in self.w.chunks_exact_mut(count).zip(&self.stiffness).enumerate() {
            self.size[i] *= stiffness;
            line.iter_mut().for_each(|w| *w *= stiffness);
            line[i] += 1.0;
            if self.drag[i] != 0.0 {
                line[i - 1] += self.drag[i];
            }
        }
        if !dense::solve(&mut self.w, &mut self.size, count) {
            self.size.fill(0.0);
            return;
        }
        for j in 0..count {
            let most = self.size[j].max(-self.available[j]);
            let kept = most - self.size[j];
            self.size[j] = most;
            // What a normal cannot take back, its friction does not either.
            if let Some(drag) = self.drag.get(j + 1).filter(|drag| **drag != 0.0) {
                self.size[j + 1] -= drag * kept;
            }
            let response = &self.response[j * bodies..(j + 1) * bodies];
            for (v, change) in velocities.iter_mut().zip(response) {
                for axis in 0..3 {
                    v[axis] += most * change[axis];
                }
            }
        }
    }

    /// Work of the impulses on the bodies, each with the row of the contact space it is along: an impulse does that of the mean of
    /// the rates before and after it.
    pub fn works(&self, velocities: &[Twist]) -> impl Iterator<Item = (usize, f64)> {
        let mean = |(row, before): (&Row, &f64)| 0.5 * (before + row.rate(velocities));
        let means = self.rows.iter().zip(&self.rates).map(mean);
        let works = means.zip(&self.size).map(|(rate, size)| rate * size);
        self.indices.iter().copied().zip(works)
    }
}
