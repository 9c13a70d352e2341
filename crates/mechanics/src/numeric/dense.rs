//! Small dense linear systems over slices, row by row: elimination for one right-hand side, factors for several.

/// Solves A x = b by elimination with row pivoting; `a` is destroyed, and `b` becomes x. `add_work` is called for each
/// column of a large matrix with the number of multiplications; it returns false to cancel. Returns false if A is
/// singular, or if the computation is cancelled.
#[inline]
pub fn solve(a: &mut [f64], b: &mut [f64], size: usize, add_work: impl Fn(usize) -> bool) -> bool {
    let (a, b) = (&mut a[..size * size], &mut b[..size]);
    // Compile-time sizes are three times faster.
    match size {
        1 => eliminate(a, b, 1, |_| true),
        2 => eliminate(a, b, 2, |_| true),
        3 => eliminate(a, b, 3, |_| true),
        4 => eliminate(a, b, 4, |_| true),
        5 => eliminate(a, b, 5, |_| true),
        6 => eliminate(a, b, 6, |_| true),
        8 => eliminate(a, b, 8, |_| true),
        10 => eliminate(a, b, 10, |_| true),
        _ => eliminate(a, b, size, add_work),
    }
}

/// Like [`solve`], but the slices must have the exact lengths; inlined for sizes known at compile time.
#[inline(always)]
pub fn eliminate(a: &mut [f64], b: &mut [f64], size: usize, add_work: impl Fn(usize) -> bool) -> bool {
    assert!(a.len() == size * size && b.len() == size);
    for k in 0..size {
        if !add_work((size - k) * (size - k)) {
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
            // Parts of a mechanism that do not touch are not coupled.
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
#[inline]
pub fn factor_cholesky(a: &mut [f64], first: &[usize]) -> bool {
    match first.len() {
        // The five pins of a finger are the usual case: unrolled, and processing zeros is cheaper than skipping them.
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

/// Solves L Lᵀ x = b with the factor of [`factor_cholesky`]; `b` becomes x.
#[inline]
pub fn solve_cholesky(factor: &[f64], first: &[usize], b: &mut [f64]) {
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

/// Skips the zeros of the factor, and those of `b` that belong to parts of a mechanism on which nothing acts.
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

/// Factors a matrix in place, P A = L U, with row pivoting; returns the order of the rows. For a singular matrix, the
/// factors are not finite. Unlike [`eliminate`], it divides by the pivots instead of multiplying by their reciprocals.
pub fn factor_lu(matrix: &mut [f64], size: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..size).collect();
    for k in 0..size {
        let magnitude = |row: &usize| matrix[row * size + k].abs();
        let pivot = (k..size).max_by(|a, b| magnitude(a).total_cmp(&magnitude(b))).unwrap_or(k);
        order.swap(k, pivot);
        (0..size).for_each(|j| matrix.swap(k * size + j, pivot * size + j));
        for i in k + 1..size {
            let multiple = matrix[i * size + k] / matrix[k * size + k];
            matrix[i * size + k] = multiple;
            if multiple != 0.0 {
                (k + 1..size).for_each(|j| matrix[i * size + j] -= multiple * matrix[k * size + j]);
            }
        }
    }
    order
}

/// Solves A x = b with the factors of [`factor_lu`]; `b` becomes x.
pub fn solve_lu(matrix: &[f64], order: &[usize], b: &mut [f64]) {
    let size = order.len();
    let mut x: Vec<f64> = order.iter().map(|row| b[*row]).collect();
    for i in 0..size {
        x[i] -= (0..i).map(|j| matrix[i * size + j] * x[j]).sum::<f64>();
    }
    for i in (0..size).rev() {
        x[i] -= (i + 1..size).map(|j| matrix[i * size + j] * x[j]).sum::<f64>();
        x[i] /= matrix[i * size + i];
    }
    b.copy_from_slice(&x);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_with_a_zero_on_the_diagonal() {
        let mut a = [0.0, 2.0, 1.0, 1.0, 1.0, 0.0, 3.0, 0.0, 4.0];
        let x = [1.5, -2.0, 0.25];
        let mut b: Vec<f64> = (0..3).map(|i| (0..3).map(|j| a[3 * i + j] * x[j]).sum()).collect();
        let (mut lu, mut by_lu) = (a, b.clone());
        let order = factor_lu(&mut lu, 3);
        solve_lu(&lu, &order, &mut by_lu);
        assert!(solve(&mut a, &mut b, 3, |_| true));
        for (found, expected) in b.iter().chain(&by_lu).zip(x.iter().chain(&x)) {
            assert!((found - expected).abs() < 1e-14);
        }
        assert!(!solve(&mut [1.0, 2.0, 2.0, 4.0], &mut [1.0, 1.0], 2, |_| true));
    }

    #[test]
    fn factorises_only_positive_definite_matrices() {
        let a = [4.0, 2.0, -1.0, 2.0, 5.0, 0.5, -1.0, 0.5, 3.0];
        let x = [0.3, -1.0, 2.0];
        let mut b: Vec<f64> = (0..3).map(|i| (0..3).map(|j| a[3 * i + j] * x[j]).sum()).collect();
        let mut factor = a;
        assert!(factor_cholesky(&mut factor, &[0, 0, 0]));
        solve_cholesky(&factor, &[0, 0, 0], &mut b);
        for (found, expected) in b.iter().zip(x) {
            assert!((found - expected).abs() < 1e-14);
        }
        assert!(!factor_cholesky(&mut [1.0, 0.0, 2.0, 1.0], &[0, 0]));
        assert!(!factor_cholesky(&mut [f64::NAN, 0.0, 0.0, 1.0], &[0, 0]));
    }
}
