//! LU factorisation of fixed size with partial pivoting, over real or complex numbers.

use std::ops::{Add, Div, Mul, Sub};

use num_complex::Complex64;

/// Entries of a matrix.
pub trait Field:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + From<f64>
{
    fn magnitude(self) -> f64;
}

impl Field for f64 {
    #[inline(always)]
    fn magnitude(self) -> f64 {
        self.abs()
    }
}

impl Field for Complex64 {
    #[inline(always)]
    fn magnitude(self) -> f64 {
        self.re.abs() + self.im.abs()
    }
}

/// Largest number of coordinates without tests for zeros: with them, a closing motion of one finger takes 0.7 % more
/// instructions. For more coordinates most matrices are sparse, as the internal state of a bristle depends only on its
/// own contact.
pub(crate) const MAX_DENSE_SIZE: usize = 3;

/// LU factorisation with row pivoting, P A = L U. The diagonal of U is stored as reciprocals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lu<F, const N: usize> {
    lu: [[F; N]; N],
    order: [usize; N],
    /// Size in use; entries beyond it are ignored.
    n: usize,
}

impl<F: Field, const N: usize> Lu<F, N> {
    /// Factors the first `n` rows and columns of `a`. A singular matrix yields non-finite numbers, and the step control
    /// rejects the step.
    #[inline(always)]
    pub fn new(mut a: [[F; N]; N], n: usize) -> Self {
        let n = n.min(N);
        let mut order = [0; N];
        for (i, row) in order.iter_mut().enumerate() {
            *row = i;
        }
        for k in 0..n {
            let mut pivot = k;
            for i in k + 1..n {
                if a[i][k].magnitude() > a[pivot][k].magnitude() {
                    pivot = i;
                }
            }
            a.swap(k, pivot);
            order.swap(k, pivot);
            a[k][k] = F::from(1.0) / a[k][k];
            for i in k + 1..n {
                let factor = a[i][k] * a[k][k];
                a[i][k] = factor;
                if N > MAX_DENSE_SIZE && factor.magnitude() == 0.0 {
                    continue;
                }
                for j in k + 1..n {
                    a[i][j] = a[i][j] - factor * a[k][j];
                }
            }
        }
        Self { lu: a, order, n }
    }

    #[inline(always)]
    pub fn solve(&self, b: [F; N]) -> [F; N] {
        let n = self.n.min(N);
        let mut x = b;
        for i in 0..n {
            x[i] = b[self.order[i]];
        }
        for i in 1..n {
            for j in 0..i {
                x[i] = x[i] - self.lu[i][j] * x[j];
            }
        }
        for i in (0..n).rev() {
            for j in i + 1..n {
                x[i] = x[i] - self.lu[i][j] * x[j];
            }
            x[i] = x[i] * self.lu[i][i];
        }
        x
    }
}

/// Solver of (s I − J) x = r for J = [[0, I], [a_q, a_v]]: eliminating x_q leaves N equations instead of 2N.
///
/// x_q = (r_q + x_v)/s and (s − a_v − a_q/s) x_v = r_v + a_q r_q / s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShiftedSolver<'a, F, const N: usize> {
    inverse_shift: F,
    a_q: &'a [[f64; N]; N],
    lu: Lu<F, N>,
}

impl<'a, F: Field, const N: usize> ShiftedSolver<'a, F, N> {
    #[inline(always)]
    pub fn new(shift: F, a_q: &'a [[f64; N]; N], a_v: &[[f64; N]; N], n: usize) -> Self {
        let n = n.min(N);
        let inverse_shift = F::from(1.0) / shift;
        // These are loops, because closures over nested arrays of the size of a gripper are not inlined.
        let mut matrix = [[F::from(0.0); N]; N];
        for i in 0..n {
            for j in 0..n {
                matrix[i][j] = F::from(-a_v[i][j]) - F::from(a_q[i][j]) * inverse_shift;
            }
            matrix[i][i] = matrix[i][i] + shift;
        }
        Self { inverse_shift, a_q, lu: Lu::new(matrix, n) }
    }

    /// Solves for (x_q, x_v).
    #[inline(always)]
    pub fn solve(&self, r_q: [F; N], r_v: [F; N]) -> ([F; N], [F; N]) {
        let n = self.lu.n.min(N);
        let (mut x_q, mut load) = (r_q, r_v);
        for x in &mut x_q {
            *x = *x * self.inverse_shift;
        }
        for i in 0..n {
            for j in 0..n {
                load[i] = load[i] + F::from(self.a_q[i][j]) * x_q[j];
            }
        }
        let x_v = self.lu.solve(load);
        for (q, v) in x_q.iter_mut().zip(&x_v) {
            *q = *q + *v * self.inverse_shift;
        }
        (x_q, x_v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lu_solves_matrices_that_require_pivoting() {
        let a = [[0.0, 2.0, 1.0], [1.0, 0.0, 3.0], [4.0, 1.0, 0.0]];
        let x = [1.0, -2.0, 0.5];
        let b: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| a[i][j] * x[j]).sum());
        let solved = Lu::new(a, 3).solve(b);
        for i in 0..3 {
            assert!((solved[i] - x[i]).abs() < 1e-15);
        }
    }

    #[test]
    fn shifted_solver_inverts_the_full_complex_matrix() {
        let a_q = [[-3.0, 1.0], [0.5, -7.0]];
        let a_v = [[-100.0, 2.0], [3.0, -0.1]];
        let s = Complex64::new(2.0, 1.5);
        let x = [1.0, -1.0, 0.3, 2.0].map(|re| Complex64::new(re, 0.7 * re - 0.2));
        let r_q = [s * x[0] - x[2], s * x[1] - x[3]];
        let r_v: [Complex64; 2] = std::array::from_fn(|i| {
            s * x[2 + i] - (0..2).map(|j| x[j] * a_q[i][j] + x[2 + j] * a_v[i][j]).sum::<Complex64>()
        });
        let (x_q, x_v) = ShiftedSolver::new(s, &a_q, &a_v, 2).solve(r_q, r_v);
        for i in 0..2 {
            assert!((x_q[i] - x[i]).norm() < 1e-14 && (x_v[i] - x[2 + i]).norm() < 1e-14);
        }
    }
}
