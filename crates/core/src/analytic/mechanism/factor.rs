//! Cholesky factorisation of the mass matrix of a group.

use crate::integrator::DynamicMatrix;

/// Cholesky factor of the mass matrix of one group, by rows.
#[derive(Clone, Debug)]
pub(super) struct Factor {
    /// Lower triangle of the mass matrix, and then of its factor, whose diagonal contains reciprocals.
    lower: Vec<f64>,
    size: usize,
    /// Loads of inertia, gravity and constant forces in this state.
    load: Vec<f64>,
    /// Whether the first coordinate is prescribed: it does not accelerate.
    is_prescribed: bool,
    /// Load on a prescribed first coordinate per acceleration of the others.
    inertia: Vec<f64>,
}

impl Factor {
    /// Creates the memory for a matrix.
    pub fn new(size: usize, is_prescribed: bool) -> Self {
        let inertia = if is_prescribed { vec![0.0; size] } else { Vec::new() };
        Self { lower: vec![0.0; size * size], size, load: vec![0.0; size], is_prescribed, inertia }
    }

    /// The mass matrix, row by row, and the loads. They must be written before [`Factor::factor`].
    pub fn inertia(&mut self) -> (&mut [f64], &mut [f64]) {
        (&mut self.lower, &mut self.load)
    }

    /// Loads of inertia, gravity and constant forces.
    pub fn load(&self) -> &[f64] {
        &self.load
    }

    /// Factors the mass matrix. The factors are NaN if it is not positive definite.
    pub fn factor(&mut self) {
        let (lower, size) = (&mut self.lower, self.size);
        if self.is_prescribed {
            (1..size).for_each(|i| self.inertia[i] = std::mem::take(&mut lower[i * size]));
            lower[0] = 1.0;
        }
        // Most groups have few coordinates: of a constant number, the compiler unrolls the loops.
        match size {
            1 => factor(lower, 1),
            2 => factor(lower, 2),
            3 => factor(lower, 3),
            4 => factor(lower, 4),
            _ => factor(lower, size),
        }
    }

    /// Solves for one right-hand side, in place.
    pub fn solve(&self, x: &mut [f64]) {
        match self.size {
            1 => solve(&self.lower, x, 1),
            2 => solve(&self.lower, x, 2),
            3 => solve(&self.lower, x, 3),
            4 => solve(&self.lower, x, 4),
            size => solve(&self.lower, x, size),
        }
    }

    /// Like [`Factor::solve`], with a prescribed first coordinate. Returns the load that its motion requires, in
    /// addition to the given load.
    pub fn solve_prescribed(&self, x: &mut [f64]) -> f64 {
        let load = std::mem::take(&mut x[0]);
        self.solve(x);
        x.iter().zip(&self.inertia).fold(-load, |sum, (acceleration, inertia)| sum + acceleration * inertia)
    }

    /// Solves in place for the first `count` columns of a matrix; the rows of the group begin with row `first`. With a
    /// prescribed first coordinate, adds to `powers` the loads that its motion requires.
    pub fn solve_columns(&self, (matrix, first): (&mut DynamicMatrix<f64>, usize), count: usize, powers: &mut [f64]) {
        let (lower, size) = (&self.lower, self.size);
        if self.is_prescribed {
            // The row of the prescribed coordinate has no effect on the others: it is memory for the loads.
            matrix[first][..count].iter_mut().for_each(|load| *load = -*load);
        }
        for i in 0..size {
            for k in 0..i {
                subtract(matrix, [first + i, first + k], lower[i * size + k], count);
            }
            matrix[first + i][..count].iter_mut().for_each(|x| *x *= lower[i * size + i]);
        }
        for i in (0..size).rev() {
            for k in i + 1..size {
                subtract(matrix, [first + i, first + k], lower[k * size + i], count);
            }
            matrix[first + i][..count].iter_mut().for_each(|x| *x *= lower[i * size + i]);
        }
        if self.is_prescribed {
            for (i, inertia) in self.inertia.iter().enumerate().skip(1) {
                subtract(matrix, [first, first + i], -inertia, count);
            }
            let loads = matrix[first][..count].iter_mut().map(std::mem::take);
            powers.iter_mut().zip(loads).for_each(|(power, load)| *power += load);
        }
    }
}

/// Factors a mass matrix of this size.
#[inline(always)]
fn factor(lower: &mut [f64], size: usize) {
    let lower = &mut lower[..size * size];
    for i in 0..size {
        for j in 0..=i {
            let (row, other) = (i * size, j * size);
            let sum = (0..j).fold(lower[row + j], |sum, k| sum - lower[row + k] * lower[other + k]);
            lower[row + j] = if i == j { 1.0 / sum.sqrt() } else { sum * lower[other + j] };
        }
    }
}

/// Solves with the factor of a matrix of this size.
#[inline(always)]
fn solve(lower: &[f64], x: &mut [f64], size: usize) {
    let (lower, x) = (&lower[..size * size], &mut x[..size]);
    for i in 0..size {
        x[i] = (0..i).fold(x[i], |sum, k| sum - lower[i * size + k] * x[k]) * lower[i * size + i];
    }
    for i in (0..size).rev() {
        x[i] = (i + 1..size).fold(x[i], |sum, k| sum - lower[k * size + i] * x[k]) * lower[i * size + i];
    }
}

/// Subtracts a multiple of another row from a row.
#[inline(always)]
fn subtract(matrix: &mut DynamicMatrix<f64>, [row, other]: [usize; 2], factor: f64, count: usize) {
    let (row, other) = matrix.rows_mut(row, other);
    row[..count].iter_mut().zip(&other[..count]).for_each(|(x, y)| *x -= factor * y);
}
