//! Cholesky factorisation of the mass matrix of a group.

/// Lower triangle of the Cholesky factor of the mass matrix of one group.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factor<const K: usize> {
    /// Its diagonal contains reciprocals.
    lower: [[f64; K]; K],
    size: usize,
    /// Load on a prescribed first coordinate per acceleration of the others.
    inertia: [f64; K],
}

impl<const K: usize> Factor<K> {
    /// Factors the leading part of a positive definite matrix. Not a number for another one. A prescribed first coordinate
    /// does not accelerate.
    pub fn new(mut mass: [[f64; K]; K], size: usize, is_prescribed: bool) -> Self {
        let mut inertia = [0.0; K];
        if is_prescribed {
            (1..size).for_each(|i| inertia[i] = std::mem::take(&mut mass[i][0]));
            mass[0][0] = 1.0;
        }
        let mut lower = [[0.0; K]; K];
        for i in 0..size {
            for j in 0..=i {
                let sum = (0..j).fold(mass[i][j], |sum, k| sum - lower[i][k] * lower[j][k]);
                lower[i][j] = if i == j { 1.0 / sum.sqrt() } else { sum * lower[j][j] };
            }
        }
        Self { lower, size, inertia }
    }

    /// Solves for one right-hand side, in place.
    pub fn solve(&self, x: &mut [f64]) {
        for i in 0..self.size {
            for k in 0..i {
                x[i] -= self.lower[i][k] * x[k];
            }
            x[i] *= self.lower[i][i];
        }
        for i in (0..self.size).rev() {
            for k in i + 1..self.size {
                x[i] -= self.lower[k][i] * x[k];
            }
            x[i] *= self.lower[i][i];
        }
    }

    /// [`Factor::solve`] with a prescribed first coordinate: returns the load that its motion requires beyond the given one.
    pub fn solve_prescribed(&self, x: &mut [f64]) -> f64 {
        let load = std::mem::take(&mut x[0]);
        self.solve(x);
        x.iter().zip(&self.inertia).fold(-load, |sum, (acceleration, inertia)| sum + acceleration * inertia)
    }
}
