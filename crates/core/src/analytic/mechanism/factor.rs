//! Cholesky factorisation of the mass matrix of a group.

/// Lower triangle of the Cholesky factor of the mass matrix of one group.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factor<const K: usize> {
    lower: [[f64; K]; K],
    size: usize,
}

impl<const K: usize> Factor<K> {
    /// Factors the leading part of a positive definite matrix. Not a number for another one.
    pub fn new(mass: &[[f64; K]; K], size: usize) -> Self {
        let mut lower = [[0.0; K]; K];
        for i in 0..size {
            for j in 0..=i {
                let sum = (0..j).fold(mass[i][j], |sum, k| sum - lower[i][k] * lower[j][k]);
                lower[i][j] = if i == j { sum.sqrt() } else { sum / lower[j][j] };
            }
        }
        Self { lower, size }
    }

    /// Solves for one right-hand side, in place.
    pub fn solve(&self, x: &mut [f64]) {
        for i in 0..self.size {
            for k in 0..i {
                x[i] -= self.lower[i][k] * x[k];
            }
            x[i] /= self.lower[i][i];
        }
        for i in (0..self.size).rev() {
            for k in i + 1..self.size {
                x[i] -= self.lower[k][i] * x[k];
            }
            x[i] /= self.lower[i][i];
        }
    }
}
