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
const MAX_DENSE_SIZE: usize = 3;

/// LU factorisation with row pivoting, P A = L U. The diagonal of U is stored as reciprocals.
#[derive(Clone, Debug)]
pub(crate) struct Lu<F, const N: usize> {
    lu: [[F; N]; N],
    order: [usize; N],
}

impl<F: Field, const N: usize> Lu<F, N> {
    /// Factors the first `n` rows and columns of `a`. A singular matrix yields non-finite numbers, and the step control
    /// rejects the step.
    #[cfg(test)]
    pub fn new(a: [[F; N]; N], n: usize) -> Self {
        let mut lu = Self { lu: a, ..Self::zero() };
        lu.factor(n);
        lu
    }

    fn zero() -> Self {
        Self { lu: [[F::from(0.0); N]; N], order: [0; N] }
    }

    /// Factors the first `n` rows and columns of the matrix that has been written to `lu`.
    #[inline(always)]
    fn factor(&mut self, n: usize) {
        let n = n.min(N);
        let Self { lu: a, order, .. } = self;
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
    }

    #[inline(always)]
    pub fn solve(&self, b: [F; N], n: usize) -> [F; N] {
        let n = n.min(N);
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
/// x_q = (r_q + x_v)/s and (s − a_v − a_q/s) x_v = r_v + a_q r_q / s. First-order states depend on coordinates and rates
/// of second order and on themselves only, so they are eliminated first, each by its own diagonal entry.
#[derive(Clone, Debug)]
pub(crate) struct ShiftedSolver<F, const N: usize> {
    inverse_shift: F,
    /// Rows of the first-order states: a_v + a_q/s.
    state_rows: [[F; N]; N],
    /// Columns of the first-order states in a_v, for access in order.
    state_columns: [[f64; N]; N],
    /// 1/(s − ∂a/∂v) of the first-order states.
    pivots: [F; N],
    lu: Lu<F, N>,
}

/// Number of coordinates with equations of second order, and of all coordinates in use.
pub(crate) type Sizes = [usize; 2];

/// Sum of products of the first `n` numbers, in two parts, which the compiler can vectorise.
#[inline(always)]
pub(crate) fn dot<A: Copy, F: Field + From<A>, const N: usize>(row: &[A; N], x: &[F; N], n: usize) -> F {
    let mut sums = [F::from(0.0); 2];
    for k in 0..n / 2 {
        sums[0] = sums[0] + F::from(row[2 * k]) * x[2 * k];
        sums[1] = sums[1] + F::from(row[2 * k + 1]) * x[2 * k + 1];
    }
    if n % 2 == 1 {
        sums[0] = sums[0] + F::from(row[n - 1]) * x[n - 1];
    }
    sums[0] + sums[1]
}

impl<F: Field, const N: usize> ShiftedSolver<F, N> {
    /// A solver without a matrix.
    pub fn zero() -> Self {
        let zero = F::from(0.0);
        Self {
            inverse_shift: zero,
            state_rows: [[zero; N]; N],
            state_columns: [[0.0; N]; N],
            pivots: [zero; N],
            lu: Lu::zero(),
        }
    }

    /// Factors the matrix.
    #[inline(always)]
    pub fn new(shift: F, matrices: (&[[f64; N]; N], &[[f64; N]; N]), sizes: Sizes) -> Self {
        let mut solver = Self::zero();
        solver.factor(shift, matrices, sizes);
        solver
    }

    /// Like [`ShiftedSolver::new`], in place.
    #[inline(always)]
    pub fn factor(&mut self, shift: F, (a_q, a_v): (&[[f64; N]; N], &[[f64; N]; N]), [second_order, n]: Sizes) {
        let (n, m) = (n.min(N), second_order.min(n).min(N));
        let inverse_shift = F::from(1.0) / shift;
        // These are loops, because closures over nested arrays of the size of a gripper are not inlined.
        let Self { state_rows, state_columns, pivots, lu, .. } = self;
        let matrix = &mut lu.lu;
        for i in 0..m {
            for j in 0..m {
                matrix[i][j] = F::from(-a_v[i][j]) - F::from(a_q[i][j]) * inverse_shift;
            }
            matrix[i][i] = matrix[i][i] + shift;
        }
        for state in m..n {
            for j in 0..m {
                state_rows[state][j] = F::from(a_v[state][j]) + F::from(a_q[state][j]) * inverse_shift;
            }
            pivots[state] = F::from(1.0) / (shift - F::from(a_v[state][state]));
            for i in 0..m {
                state_columns[state][i] = a_v[i][state];
                if a_v[i][state] != 0.0 {
                    let factor = F::from(a_v[i][state]) * pivots[state];
                    for j in 0..m {
                        matrix[i][j] = matrix[i][j] - factor * state_rows[state][j];
                    }
                }
            }
        }
        lu.factor(m);
        self.inverse_shift = inverse_shift;
    }

    /// Solves for (x_q, x_v), with the matrix a_q and the sizes from which this was factored. The coordinates of first-order
    /// states stay at 0.
    #[inline(always)]
    pub fn solve(
        &self,
        a_q: &[[f64; N]; N],
        [second_order, n]: Sizes,
        (r_q, r_v): ([F; N], [F; N]),
    ) -> ([F; N], [F; N]) {
        let (n, m) = (n.min(N), second_order.min(n).min(N));
        let (mut x_q, mut load) = ([F::from(0.0); N], r_v);
        for i in 0..m {
            x_q[i] = r_q[i] * self.inverse_shift;
        }
        for i in 0..n {
            // Without first-order states the products are added in order, so that closings keep their rounding.
            if second_order < N {
                load[i] = load[i] + dot(&a_q[i], &x_q, m);
                continue;
            }
            for j in 0..m {
                load[i] = load[i] + F::from(a_q[i][j]) * x_q[j];
            }
        }
        for state in m..n {
            load[state] = load[state] * self.pivots[state];
            for i in 0..m {
                load[i] = load[i] + F::from(self.state_columns[state][i]) * load[state];
            }
        }
        let mut x_v = self.lu.solve(load, m);
        for state in m..n {
            x_v[state] = load[state] + self.pivots[state] * dot(&self.state_rows[state], &x_v, m);
        }
        for i in 0..m {
            x_q[i] = x_q[i] + x_v[i] * self.inverse_shift;
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
        let solved = Lu::new(a, 3).solve(b, 3);
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
        let (x_q, x_v) = ShiftedSolver::new(s, (&a_q, &a_v), [2, 2]).solve(&a_q, [2, 2], (r_q, r_v));
        for i in 0..2 {
            assert!((x_q[i] - x[i]).norm() < 1e-14 && (x_v[i] - x[2 + i]).norm() < 1e-14);
        }
    }
}
