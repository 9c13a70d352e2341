//! LU factorisation with partial pivoting, over real or complex numbers.

use std::ops::{Add, Div, Mul, Sub};

use num_complex::Complex64;

use super::layout::{Entry, Layout, Matrix};

/// Entries of a matrix.
pub trait Field:
    Entry + PartialEq + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + From<f64>
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
pub(crate) struct Lu<F: Field, L: Layout> {
    lu: L::Square<F>,
    order: L::Vector<usize>,
}

impl<F: Field, L: Layout> Lu<F, L> {
    fn zero(layout: L) -> Self {
        Self { lu: layout.square(F::from(0.0)), order: layout.vector(0) }
    }

    /// Factors the first `n` rows and columns of the matrix that has been written to `lu`. A singular matrix yields
    /// non-finite numbers, and the step control rejects the step.
    #[inline(always)]
    fn factor(&mut self, n: usize) {
        let size = self.order.as_ref().len();
        let n = n.min(size);
        let Self { lu: a, order, .. } = self;
        for i in 0..n {
            order[i] = i;
        }
        for k in 0..n {
            let mut pivot = k;
            for i in k + 1..n {
                if a[i][k].magnitude() > a[pivot][k].magnitude() {
                    pivot = i;
                }
            }
            if pivot != k {
                for j in 0..n {
                    (a[k][j], a[pivot][j]) = (a[pivot][j], a[k][j]);
                }
                order.as_mut().swap(k, pivot);
            }
            a[k][k] = F::from(1.0) / a[k][k];
            for i in k + 1..n {
                let factor = a[i][k] * a[k][k];
                a[i][k] = factor;
                if size > MAX_DENSE_SIZE && factor.magnitude() == 0.0 {
                    continue;
                }
                let (row, of_pivot) = a.rows_mut(i, k);
                let (row, of_pivot) = (&mut row[k + 1..n], &of_pivot[k + 1..n]);
                for j in 0..row.len() {
                    row[j] = row[j] - factor * of_pivot[j];
                }
            }
        }
    }

    /// Solves for the first `n` entries of `b`, in place.
    #[inline(always)]
    fn solve(&self, b: &mut L::Vector<F>, n: usize, x: &mut L::Vector<F>) {
        let n = n.min(self.order.as_ref().len());
        for i in 0..n {
            x[i] = b[self.order[i]];
        }
        for i in 1..n {
            let row = &self.lu[i];
            for j in 0..i {
                x[i] = x[i] - row[j] * x[j];
            }
        }
        for i in (0..n).rev() {
            let row = &self.lu[i];
            for j in i + 1..n {
                x[i] = x[i] - row[j] * x[j];
            }
            x[i] = x[i] * row[i];
        }
        b.as_mut()[..n].copy_from_slice(&x.as_ref()[..n]);
    }
}

/// Solver of (s I − J) x = r for J = [[0, I], [a_q, a_v]]: eliminating x_q leaves N equations instead of 2N.
///
/// x_q = (r_q + x_v)/s and (s − a_v − a_q/s) x_v = r_v + a_q r_q / s. First-order states depend on coordinates and rates
/// of second order and on themselves only, so they are eliminated first, each by its own diagonal entry.
#[derive(Clone, Debug)]
pub(crate) struct ShiftedSolver<F: Field, L: Layout> {
    inverse_shift: F,
    /// Rows of the first-order states: a_v + a_q/s.
    state_rows: L::Square<F>,
    /// Columns of the first-order states in a_v, for access in order.
    state_columns: L::Square<f64>,
    /// 1/(s − ∂a/∂v) of the first-order states.
    pivots: L::Vector<F>,
    lu: Lu<F, L>,
}

/// Number of coordinates with equations of second order, and of all coordinates in use.
pub(crate) type Sizes = [usize; 2];

/// Sum of products, in two parts, which the compiler can vectorise.
#[inline(always)]
pub(crate) fn dot<A: Copy, F: Field + From<A>>(row: &[A], x: &[F]) -> F {
    let n = row.len().min(x.len());
    let (row, x) = (&row[..n], &x[..n]);
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

impl<F: Field, L: Layout> ShiftedSolver<F, L> {
    /// A solver without a matrix.
    pub fn zero(layout: L) -> Self {
        let zero = F::from(0.0);
        Self {
            inverse_shift: zero,
            state_rows: layout.square(zero),
            state_columns: layout.square(0.0),
            pivots: layout.vector(zero),
            lu: Lu::zero(layout),
        }
    }

    /// Factors the matrix of a shift.
    #[inline(always)]
    pub fn factor(&mut self, shift: F, (a_q, a_v): (&L::Square<f64>, &L::Square<f64>), [second_order, n]: Sizes) {
        let size = self.pivots.as_ref().len();
        let (n, m) = (n.min(size), second_order.min(n).min(size));
        let inverse_shift = F::from(1.0) / shift;
        // These are loops, because closures over nested arrays of the size of a gripper are not inlined.
        let Self { state_rows, state_columns, pivots, lu, .. } = self;
        let matrix = &mut lu.lu;
        for i in 0..m {
            let (row, by_q, by_v) = (&mut matrix[i][..m], &a_q[i][..m], &a_v[i][..m]);
            for j in 0..m {
                row[j] = F::from(-by_v[j]) - F::from(by_q[j]) * inverse_shift;
            }
            row[i] = row[i] + shift;
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

    /// Replaces the right-hand side by (x_q, x_v), with the matrix a_q and the sizes from which this was factored. The
    /// coordinates of first-order states stay at 0. `scratch` is memory.
    #[inline(always)]
    pub fn solve(
        &self,
        a_q: &L::Square<f64>,
        [second_order, n]: Sizes,
        (r_q, r_v): (&mut L::Vector<F>, &mut L::Vector<F>),
        scratch: &mut L::Vector<F>,
    ) {
        let size = self.pivots.as_ref().len();
        let (n, m) = (n.min(size), second_order.min(n).min(size));
        for i in 0..m {
            r_q[i] = r_q[i] * self.inverse_shift;
        }
        r_q.as_mut()[m..].fill(F::from(0.0));
        for i in 0..n {
            // Without first-order states the products are added in order, so that closings keep their rounding.
            if second_order < size {
                r_v[i] = r_v[i] + dot(&a_q[i][..m], &r_q.as_ref()[..m]);
                continue;
            }
            let by_q = &a_q[i][..m];
            for j in 0..m {
                r_v[i] = r_v[i] + F::from(by_q[j]) * r_q[j];
            }
        }
        for state in m..n {
            r_v[state] = r_v[state] * self.pivots[state];
            for i in 0..m {
                r_v[i] = r_v[i] + F::from(self.state_columns[state][i]) * r_v[state];
            }
        }
        self.lu.solve(r_v, m, scratch);
        for state in m..n {
            r_v[state] = r_v[state] + self.pivots[state] * dot(&self.state_rows[state][..m], &r_v.as_ref()[..m]);
        }
        for i in 0..m {
            r_q[i] = r_q[i] + r_v[i] * self.inverse_shift;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{Dynamic, Fixed, FixedMatrix};

    fn lu_solves<L: Layout>(layout: L) {
        let a = [[0.0, 2.0, 1.0], [1.0, 0.0, 3.0], [4.0, 1.0, 0.0]];
        let x = [1.0, -2.0, 0.5];
        let (mut lu, mut b, mut scratch) = (Lu::<f64, L>::zero(layout), layout.vector(0.0), layout.vector(0.0));
        for i in 0..3 {
            lu.lu[i].copy_from_slice(&a[i]);
            b[i] = (0..3).map(|j| a[i][j] * x[j]).sum();
        }
        lu.factor(3);
        lu.solve(&mut b, 3, &mut scratch);
        for i in 0..3 {
            assert!((b[i] - x[i]).abs() < 1e-15);
        }
    }

    #[test]
    fn lu_solves_matrices_that_require_pivoting() {
        lu_solves(Fixed::<3, 0>);
        lu_solves(Dynamic { coordinates: 3, quadratures: 0 });
    }

    #[test]
    fn shifted_solver_inverts_the_full_complex_matrix() {
        let a_q = FixedMatrix([[-3.0, 1.0], [0.5, -7.0]]);
        let a_v = FixedMatrix([[-100.0, 2.0], [3.0, -0.1]]);
        let s = Complex64::new(2.0, 1.5);
        let x = [1.0, -1.0, 0.3, 2.0].map(|re| Complex64::new(re, 0.7 * re - 0.2));
        let mut r_q = [s * x[0] - x[2], s * x[1] - x[3]];
        let mut r_v: [Complex64; 2] = std::array::from_fn(|i| {
            s * x[2 + i] - (0..2).map(|j| x[j] * a_q[i][j] + x[2 + j] * a_v[i][j]).sum::<Complex64>()
        });
        let mut solver = ShiftedSolver::<Complex64, Fixed<2, 0>>::zero(Fixed);
        solver.factor(s, (&a_q, &a_v), [2, 2]);
        solver.solve(&a_q, [2, 2], (&mut r_q, &mut r_v), &mut [Complex64::ZERO; 2]);
        for i in 0..2 {
            assert!((r_q[i] - x[i]).norm() < 1e-14 && (r_v[i] - x[2 + i]).norm() < 1e-14);
        }
    }
}
