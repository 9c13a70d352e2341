//! LU factorisation with partial pivoting, over real or complex numbers.

use std::ops::{Add, Div, Mul, Sub};

use num_complex::Complex64;

use super::layout::{Entry, Layout, Matrix};
use crate::numeric::array_from;

/// Evaluates an expression with a constant in place of a number of at most [`MAX_UNROLLED`].
macro_rules! unrolled {
    ($number:expr, $constant:ident => $value:expr) => {
        unrolled!($number, $constant => $value, [0 1 2 3 4 5 6 7 8 9 10 11])
    };
    ($number:expr, $constant:ident => $value:expr, [$($size:literal)*]) => {
        match $number {
            $($size => {
                const $constant: usize = $size;
                $value
            })*
            _ => {
                const $constant: usize = MAX_UNROLLED;
                $value
            }
        }
    };
}

/// Entries of a matrix.
pub trait Field:
    Entry
    + Default
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + From<f64>
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
        let order = self.order.as_mut();
        let size = order.len();
        let n = n.min(size);
        let (a, width) = self.lu.entries_mut();
        for (i, row) in order[..n].iter_mut().enumerate() {
            *row = i;
        }
        for k in 0..n {
            let magnitude = |a: &[F], i: usize| a[i * width + k].magnitude();
            let (mut pivot, mut largest) = (k, magnitude(a, k));
            for i in k + 1..n {
                let other = magnitude(a, i);
                if other > largest {
                    (pivot, largest) = (i, other);
                }
            }
            let (above, below) = a.split_at_mut((k + 1) * width);
            let of_pivot = &mut above[k * width..][..n];
            if pivot != k {
                of_pivot.swap_with_slice(&mut below[(pivot - k - 1) * width..][..n]);
                order.swap(k, pivot);
            }
            of_pivot[k] = F::from(1.0) / of_pivot[k];
            for row in below.chunks_exact_mut(width).take(n - k - 1) {
                let row = &mut row[..n];
                let factor = row[k] * of_pivot[k];
                row[k] = factor;
                if size > MAX_DENSE_SIZE && factor.magnitude() == 0.0 {
                    continue;
                }
                subtract_scaled(&mut row[k + 1..], factor, &of_pivot[k + 1..]);
            }
        }
    }

    /// Solves for the first `n` entries of `b`, in place.
    #[inline(always)]
    fn solve(&self, b: &mut [F], n: usize, x: &mut [F]) {
        let order = self.order.as_ref();
        let n = n.min(order.len());
        let (lu, width) = self.lu.entries();
        let (b, x) = (&mut b[..n], &mut x[..n]);
        for (x, row) in x.iter_mut().zip(order) {
            *x = b[*row];
        }
        for i in 1..n {
            let (done, rest) = x.split_at_mut(i);
            rest[0] = rest[0] - dot(&lu[i * width..][..i], done);
        }
        for i in (0..n).rev() {
            let (rest, done) = x.split_at_mut(i + 1);
            let row = &lu[i * width + i..][..n - i];
            rest[i] = (rest[i] - dot(&row[1..], done)) * row[0];
        }
        b.copy_from_slice(x);
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
    let mut sums = [F::from(0.0); 2];
    let ((rows, row_rest), (xs, x_rest)) = (row.as_chunks::<4>(), x.as_chunks::<4>());
    for (row, x) in rows.iter().zip(xs) {
        for k in [0, 2] {
            sums[0] = sums[0] + F::from(row[k]) * x[k];
            sums[1] = sums[1] + F::from(row[k + 1]) * x[k + 1];
        }
    }
    for (k, (entry, x)) in row_rest.iter().zip(x_rest).enumerate() {
        sums[k % 2] = sums[k % 2] + F::from(*entry) * *x;
    }
    sums[0] + sums[1]
}

/// y −= w x.
#[inline(always)]
fn subtract_scaled<F: Field>(y: &mut [F], w: F, x: &[F]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y = *y - w * *x);
}

impl<F: Field, L: Layout> ShiftedSolver<F, L> {
    /// Creates a solver that does not yet hold a matrix.
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

    /// Factors the matrix for a shift.
    #[inline(always)]
    pub fn factor(&mut self, shift: F, (a_q, a_v): (&L::Square<f64>, &L::Square<f64>), [second_order, n]: Sizes) {
        let size = self.pivots.as_ref().len();
        let (n, m) = (n.min(size), second_order.min(n).min(size));
        let inverse_shift = F::from(1.0) / shift;
        self.inverse_shift = inverse_shift;
        // These are loops, because closures over nested arrays of the size of a gripper are not inlined.
        let Self { state_rows, state_columns, pivots, lu, .. } = self;
        if !L::IS_FIXED && m <= MAX_UNROLLED {
            let (matrix, width) = lu.lu.entries_mut();
            let factored = Factored {
                matrix,
                width,
                order: lu.order.as_mut(),
                state_rows: state_rows.entries_mut().0,
                state_columns: state_columns.entries_mut().0,
                pivots: pivots.as_mut(),
            };
            let [a_q, a_v] = [a_q, a_v].map(|matrix| matrix.entries().0);
            return unrolled!(m, M => factored.factor::<M>(n, [shift, inverse_shift], [a_q, a_v]));
        }
        let matrix = &mut lu.lu;
        for i in 0..m {
            let (row, by_q, by_v) = (&mut matrix[i][..m], &a_q[i][..m], &a_v[i][..m]);
            for (entry, (by_q, by_v)) in row.iter_mut().zip(by_q.iter().zip(by_v)) {
                *entry = F::from(-by_v) - F::from(*by_q) * inverse_shift;
            }
            row[i] = row[i] + shift;
        }
        for state in m..n {
            let (of_state, by_q, by_v) = (&mut state_rows[state][..m], &a_q[state][..m], &a_v[state][..]);
            for (entry, (by_q, by_v)) in of_state.iter_mut().zip(by_q.iter().zip(by_v)) {
                *entry = F::from(*by_v) + F::from(*by_q) * inverse_shift;
            }
            pivots[state] = F::from(1.0) / (shift - F::from(by_v[state]));
            let column = &mut state_columns[state][..m];
            for (i, entry) in column.iter_mut().enumerate() {
                *entry = a_v[i][state];
                if *entry != 0.0 {
                    subtract_scaled(&mut matrix[i][..m], F::from(*entry) * pivots[state], of_state);
                }
            }
        }
        lu.factor(m);
    }

    /// Solves for (x_q, x_v), which replace the right-hand side. The matrix a_q and the sizes must be those of
    /// [`factor`](Self::factor). The coordinates of first-order states stay at 0. `scratch` is working memory.
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
        let (r_q, r_v) = (r_q.as_mut(), r_v.as_mut());
        r_q[m..].fill(F::from(0.0));
        if !L::IS_FIXED && m <= MAX_UNROLLED {
            return self.solve_unrolled(a_q, [m, n], (r_q, r_v));
        }
        let x_q = &mut r_q[..m];
        x_q.iter_mut().for_each(|x| *x = *x * self.inverse_shift);
        let (entries, width) = a_q.entries();
        for (row, r_v) in entries.chunks_exact(width).zip(r_v.iter_mut()).take(n) {
            // Without first-order states the products are added in order, so that closings keep their rounding.
            *r_v = match second_order < size {
                true => *r_v + dot(&row[..m], x_q),
                false => row.iter().zip(&*x_q).fold(*r_v, |sum, (entry, x)| sum + F::from(*entry) * *x),
            };
        }
        for state in m..n {
            r_v[state] = r_v[state] * self.pivots[state];
            let rate = r_v[state];
            let column = &self.state_columns[state][..m];
            r_v.iter_mut().zip(column).for_each(|(r_v, entry)| *r_v = *r_v + F::from(*entry) * rate);
        }
        self.lu.solve(r_v, m, scratch.as_mut());
        for state in m..n {
            r_v[state] = r_v[state] + self.pivots[state] * dot(&self.state_rows[state][..m], &r_v[..m]);
        }
        x_q.iter_mut().zip(&*r_v).for_each(|(x, v)| *x = *x + *v * self.inverse_shift);
    }

    /// [`ShiftedSolver::solve`] for few coordinates, whose loops the compiler unrolls.
    #[inline(always)]
    fn solve_unrolled(&self, a_q: &L::Square<f64>, [m, n]: Sizes, r: (&mut [F], &mut [F])) {
        let parts = Parts {
            inverse_shift: self.inverse_shift,
            a_q: a_q.entries().0,
            state_rows: self.state_rows.entries().0,
            state_columns: self.state_columns.entries().0,
            pivots: self.pivots.as_ref(),
            lu: self.lu.lu.entries(),
            order: self.lu.order.as_ref(),
        };
        unrolled!(m, M => parts.solve::<M>(n, r))
    }
}

/// Largest number of coordinates for which factorisation and solution are compiled by themselves.
const MAX_UNROLLED: usize = 12;

/// Memory of the factors of a [`ShiftedSolver`]: entries by rows, all of one width.
struct Factored<'a, F> {
    matrix: &'a mut [F],
    width: usize,
    order: &'a mut [usize],
    state_rows: &'a mut [F],
    state_columns: &'a mut [f64],
    pivots: &'a mut [F],
}

impl<F: Field> Factored<'_, F> {
    /// [`ShiftedSolver::factor`] for M coordinates with equations of second order, of n, with the shift and its inverse.
    #[inline(never)]
    fn factor<const M: usize>(self, n: usize, [shift, inverse_shift]: [F; 2], [a_q, a_v]: [&[f64]; 2]) {
        let Self { matrix, width, order, state_rows, state_columns, pivots } = self;
        let rows = |i: usize| (first::<_, M>(&a_q[i * width..]), first::<_, M>(&a_v[i * width..]));
        for i in 0..M {
            let (by_q, by_v) = rows(i);
            let row = first_mut::<_, M>(&mut matrix[i * width..]);
            for j in 0..M {
                row[j] = F::from(-by_v[j]) - F::from(by_q[j]) * inverse_shift;
            }
            row[i] = row[i] + shift;
        }
        for state in M..n {
            let (by_q, by_v) = rows(state);
            let of_state: [F; M] = array_from(|j| F::from(by_v[j]) + F::from(by_q[j]) * inverse_shift);
            let pivot = F::from(1.0) / (shift - F::from(a_v[state * width + state]));
            for i in 0..M {
                let entry = a_v[i * width + state];
                state_columns[state * width + i] = entry;
                if entry != 0.0 {
                    subtract_row(first_mut(&mut matrix[i * width..]), F::from(entry) * pivot, &of_state, 0);
                }
            }
            state_rows[state * width..][..M].copy_from_slice(&of_state);
            pivots[state] = pivot;
        }
        (0..M).for_each(|i| order[i] = i);
        for k in 0..M {
            let mut pivot = k;
            for i in k + 1..M {
                if matrix[i * width + k].magnitude() > matrix[pivot * width + k].magnitude() {
                    pivot = i;
                }
            }
            let mut of_pivot: [F; M] = *first(&matrix[pivot * width..]);
            if pivot != k {
                matrix.copy_within(k * width..k * width + M, pivot * width);
                order.swap(k, pivot);
            }
            of_pivot[k] = F::from(1.0) / of_pivot[k];
            matrix[k * width..][..M].copy_from_slice(&of_pivot);
            for i in k + 1..M {
                let row = first_mut::<_, M>(&mut matrix[i * width..]);
                row[k] = row[k] * of_pivot[k];
                if row[k].magnitude() != 0.0 {
                    subtract_row(row, row[k], &of_pivot, k + 1);
                }
            }
        }
    }
}

/// A factored [`ShiftedSolver`] with its matrix a_q: entries by rows, all of the width of `lu`.
struct Parts<'a, F> {
    inverse_shift: F,
    a_q: &'a [f64],
    state_rows: &'a [F],
    state_columns: &'a [f64],
    pivots: &'a [F],
    lu: (&'a [F], usize),
    order: &'a [usize],
}

impl<F: Field> Parts<'_, F> {
    /// [`ShiftedSolver::solve`] for M coordinates with equations of second order, of n.
    #[inline(never)]
    fn solve<const M: usize>(&self, n: usize, (r_q, r_v): (&mut [F], &mut [F])) {
        let (lu, width) = self.lu;
        let x_q: [F; M] = array_from(|i| r_q[i] * self.inverse_shift);
        let mut products = self.a_q.chunks_exact(width).map(|row| dot_of(first::<_, M>(row), &x_q));
        let mut right: [F; M] = *first(r_v);
        for (entry, product) in right.iter_mut().zip(&mut products) {
            *entry = *entry + product;
        }
        for (state, product) in (M..n).zip(products) {
            let rate = (r_v[state] + product) * self.pivots[state];
            r_v[state] = rate;
            let column = first::<_, M>(&self.state_columns[state * width..]);
            right.iter_mut().zip(column).for_each(|(entry, by_state)| *entry = *entry + F::from(*by_state) * rate);
        }
        let mut x: [F; M] = array_from(|i| right[self.order[i]]);
        for i in 1..M {
            let row = first::<_, M>(&lu[i * width..]);
            x[i] = (0..i).fold(x[i], |sum, k| sum - row[k] * x[k]);
        }
        for i in (0..M).rev() {
            let row = first::<_, M>(&lu[i * width..]);
            x[i] = (i + 1..M).fold(x[i], |sum, k| sum - row[k] * x[k]) * row[i];
        }
        r_v[..M].copy_from_slice(&x);
        for state in M..n {
            let row = first::<_, M>(&self.state_rows[state * width..]);
            r_v[state] = r_v[state] + self.pivots[state] * dot_of(row, &x);
        }
        for i in 0..M {
            r_q[i] = x_q[i] + x[i] * self.inverse_shift;
        }
    }
}

/// y −= w x for the entries from `start` on.
#[inline(always)]
fn subtract_row<F: Field, const M: usize>(y: &mut [F; M], w: F, x: &[F; M], start: usize) {
    for j in start..M {
        y[j] = y[j] - w * x[j];
    }
}

/// The first M numbers, to be changed.
#[inline(always)]
fn first_mut<T, const M: usize>(numbers: &mut [T]) -> &mut [T; M] {
    numbers.first_chunk_mut().expect("a row is as long as the number of coordinates")
}

/// The first M numbers.
#[inline(always)]
fn first<T, const M: usize>(numbers: &[T]) -> &[T; M] {
    numbers.first_chunk().expect("a row is as long as the number of coordinates")
}

/// [`dot`] of a constant length.
#[inline(always)]
fn dot_of<A: Copy, F: Field + From<A>, const M: usize>(row: &[A; M], x: &[F; M]) -> F {
    let mut sums = [F::from(0.0); 2];
    for k in 0..M {
        sums[k % 2] = sums[k % 2] + F::from(row[k]) * x[k];
    }
    sums[0] + sums[1]
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
        lu.solve(b.as_mut(), 3, scratch.as_mut());
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
