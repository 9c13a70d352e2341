//! Small dense linear systems, row by row, solved in place, and lists that are refilled, because engine steps must not
//! allocate.

use std::cell::Cell;

/// Replaces the items of a list, reusing its allocation.
pub(crate) fn refill<T>(list: &mut Vec<T>, items: impl IntoIterator<Item = T>) {
    list.clear();
    list.extend(items);
}

/// Sets a list to `count` equal items, reusing its allocation.
pub(crate) fn reset<T: Clone>(list: &mut Vec<T>, count: usize, item: T) {
    list.clear();
    list.resize(count, item);
}

/// Work between two checks for cancellation, in multiplications: about a millisecond.
pub(crate) const WORK_BETWEEN_CHECKS: usize = 1 << 20;

/// Cancellation of a computation whose parts can take seconds: with a thousand contacts, one elimination has 10¹⁰
/// multiplications.
pub(crate) struct Cancellation<'a> {
    keep_running: &'a dyn Fn() -> bool,
    /// Work since the last check.
    work: Cell<usize>,
}

impl<'a> Cancellation<'a> {
    pub fn new(keep_running: &'a dyn Fn() -> bool) -> Self {
        Self { keep_running, work: Cell::new(0) }
    }

    /// Adds work, in multiplications; returns false once the computation is cancelled.
    #[inline]
    pub fn add_work(&self, work: usize) -> bool {
        let total = self.work.get() + work;
        let is_running = total < WORK_BETWEEN_CHECKS || (self.keep_running)();
        self.work.set(if is_running { total % WORK_BETWEEN_CHECKS } else { WORK_BETWEEN_CHECKS });
        is_running
    }
}

/// Solves a x = b by elimination with row pivoting; `a` is destroyed, `b` becomes x. Returns false if a is singular, or if
/// the computation is cancelled.
pub(crate) fn solve(a: &mut [f64], b: &mut [f64], size: usize, cancellation: &Cancellation) -> bool {
    let (a, b) = (&mut a[..size * size], &mut b[..size]);
    // Compile-time sizes are three times faster; contact spaces are small.
    match size {
        1 => eliminate(a, b, 1, None),
        2 => eliminate(a, b, 2, None),
        3 => eliminate(a, b, 3, None),
        4 => eliminate(a, b, 4, None),
        5 => eliminate(a, b, 5, None),
        6 => eliminate(a, b, 6, None),
        8 => eliminate(a, b, 8, None),
        10 => eliminate(a, b, 10, None),
        _ => eliminate(a, b, size, Some(cancellation)),
    }
}

/// Like [`solve`], but for slices of the exact lengths; inlined for compile-time sizes.
#[inline(always)]
pub(crate) fn eliminate(a: &mut [f64], b: &mut [f64], size: usize, cancellation: Option<&Cancellation>) -> bool {
    assert!(a.len() == size * size && b.len() == size);
    for k in 0..size {
        if cancellation.is_some_and(|cancellation| !cancellation.add_work((size - k) * (size - k))) {
            return false;
        }
        let mut pivot = k;
        for i in k + 1..size {
            if a[i * size + k].abs() > a[pivot * size + k].abs() {
                pivot = i;
            }
        }
        let value = a[pivot * size + k];
        if value == 0.0 || !value.is_finite() {
            return false;
        }
        if pivot != k {
            for column in k..size {
                a.swap(k * size + column, pivot * size + column);
            }
            b.swap(k, pivot);
        }
        let inverse = 1.0 / value;
        let (above, below) = a.split_at_mut((k + 1) * size);
        let (pivot_row, b_pivot, b_below) = (&above[k * size + k + 1..], b[k], &mut b[k + 1..]);
        for (row, b) in below.chunks_exact_mut(size).zip(b_below) {
            // Parts of the mechanism that do not touch are not coupled.
            if row[k] == 0.0 {
                continue;
            }
            let factor = row[k] * inverse;
            for (x, pivot) in row[k + 1..].iter_mut().zip(pivot_row) {
                *x -= factor * pivot;
            }
            *b -= factor * b_pivot;
        }
    }
    for k in (0..size).rev() {
        let row = &a[k * size..(k + 1) * size];
        let known = row[k + 1..].iter().zip(&b[k + 1..]);
        b[k] = known.fold(b[k], |rest, (x, b)| rest - x * b) / row[k];
    }
    true
}

/// Computes the Cholesky factor L of a symmetric positive definite matrix and stores it in the matrix's lower triangle,
/// with 1/Lᵢᵢ on the diagonal. Row i is zero before column `first[i]` in the matrix and in the factor; the array must
/// contain these zeros. Returns false if the matrix is not positive definite.
pub(crate) fn factorise(a: &mut [f64], first: &[usize]) -> bool {
    match first.len() {
        // Five pins are the usual case: unrolled, and processing zeros is cheaper than skipping them.
        10 => cholesky(a, 10, |_| 0),
        size => cholesky(a, size, |row| first[row]),
    }
}

#[inline(always)]
fn cholesky(a: &mut [f64], size: usize, first: impl Fn(usize) -> usize) -> bool {
    assert!(a.len() == size * size);
    for i in 0..size {
        let (above, rest) = a.split_at_mut(i * size);
        let row = &mut rest[..=i];
        for j in first(i)..i {
            let start = first(i).max(first(j));
            let other = &above[j * size..j * size + j + 1];
            let sum: f64 =
                if start < j { row[start..j].iter().zip(&other[start..j]).map(|(x, y)| x * y).sum() } else { 0.0 };
            row[j] = (row[j] - sum) * other[j];
        }
        let square = row[i] - row[first(i)..i].iter().map(|x| x * x).sum::<f64>();
        if square.is_nan() || square <= 0.0 {
            return false;
        }
        row[i] = 1.0 / square.sqrt();
    }
    true
}

/// Solves L Lᵀ x = b with the factor of [`factorise`]; `b` becomes x.
pub(crate) fn solve_factorised(factor: &[f64], first: &[usize], b: &mut [f64]) {
    match first.len() {
        10 => substitute(factor, b, 10),
        size => substitute_sparse(factor, first, b, size),
    }
}

#[inline(always)]
fn substitute(factor: &[f64], b: &mut [f64], size: usize) {
    assert!(factor.len() == size * size && b.len() == size);
    for i in 0..size {
        let mut rest = b[i];
        for j in 0..i {
            rest -= factor[i * size + j] * b[j];
        }
        b[i] = rest * factor[i * size + i];
    }
    for i in (0..size).rev() {
        let x = b[i] * factor[i * size + i];
        b[i] = x;
        for j in 0..i {
            b[j] -= factor[i * size + j] * x;
        }
    }
}

/// Skips the zeros of the factor, and those of `b` that belong to parts of the mechanism on which nothing acts.
fn substitute_sparse(factor: &[f64], first: &[usize], b: &mut [f64], size: usize) {
    let mut nonzero_end = 0;
    for i in 0..size {
        let row = &factor[i * size..(i + 1) * size];
        let columns = first[i]..nonzero_end.max(first[i]);
        let known = row[columns.clone()].iter().zip(&b[columns]);
        b[i] = known.fold(b[i], |rest, (x, b)| rest - x * b) * row[i];
        if b[i] != 0.0 {
            nonzero_end = i + 1;
        }
    }
    for i in (0..size).rev() {
        let row = &factor[i * size..(i + 1) * size];
        let x = b[i] * row[i];
        b[i] = x;
        if x != 0.0 {
            let columns = first[i]..i;
            for (b, factor) in b[columns.clone()].iter_mut().zip(&row[columns]) {
                *b -= factor * x;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Cancellation, WORK_BETWEEN_CHECKS};
    use std::cell::Cell;

    #[test]
    fn a_long_elimination_is_cancelled() {
        let size: usize = 300;
        let matrix: Vec<f64> =
            (0..size * size).map(|at: usize| 1.0 / (1.0 + (at / size).abs_diff(at % size) as f64)).collect();
        let work: usize = (0..size).map(|k| (size - k) * (size - k)).sum();
        for last in [u32::MAX, 3, 1] {
            let checks = Cell::new(0);
            let keep_running = || {
                checks.set(checks.get() + 1);
                checks.get() < last
            };
            let cancellation = Cancellation::new(&keep_running);
            let solved = super::solve(&mut matrix.clone(), &mut vec![1.0; size], size, &cancellation);
            assert_eq!(solved, last == u32::MAX);
            match solved {
                true => assert_eq!(checks.get() as usize, work / WORK_BETWEEN_CHECKS),
                false => {
                    assert_eq!(checks.get(), last);
                    // A cancelled computation stays cancelled.
                    assert!(!cancellation.add_work(1));
                }
            }
        }
    }

    #[test]
    fn solves_with_a_zero_on_the_diagonal() {
        let cancellation = &Cancellation::new(&|| true);
        let mut a = [0.0, 2.0, 1.0, 1.0, 1.0, 0.0, 3.0, 0.0, 4.0];
        let x = [1.5, -2.0, 0.25];
        let mut b: Vec<f64> = (0..3).map(|i| (0..3).map(|j| a[3 * i + j] * x[j]).sum()).collect();
        assert!(super::solve(&mut a, &mut b, 3, cancellation));
        for (found, expected) in b.iter().zip(x) {
            assert!((found - expected).abs() < 1e-14);
        }
        assert!(!super::solve(&mut [1.0, 2.0, 2.0, 4.0], &mut [1.0, 1.0], 2, cancellation));
    }

    #[test]
    fn factorises_only_positive_definite_matrices() {
        let a = [4.0, 2.0, -1.0, 2.0, 5.0, 0.5, -1.0, 0.5, 3.0];
        let x = [0.3, -1.0, 2.0];
        let mut b: Vec<f64> = (0..3).map(|i| (0..3).map(|j| a[3 * i + j] * x[j]).sum()).collect();
        let mut factor = a;
        assert!(super::factorise(&mut factor, &[0, 0, 0]));
        super::solve_factorised(&factor, &[0, 0, 0], &mut b);
        for (found, expected) in b.iter().zip(x) {
            assert!((found - expected).abs() < 1e-14);
        }
        assert!(!super::factorise(&mut [1.0, 0.0, 2.0, 1.0], &[0, 0]));
        assert!(!super::factorise(&mut [f64::NAN, 0.0, 0.0, 1.0], &[0, 0]));
    }
}
