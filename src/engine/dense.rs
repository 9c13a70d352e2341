//! Small dense systems, solved in place: the contact solver may not allocate.

/// Solves a x = b by elimination with row pivoting; `a` (row by row) is destroyed, `b` becomes x. False if a is singular.
pub fn solve(a: &mut [f64], b: &mut [f64], size: usize) -> bool {
    for k in 0..size {
        let pivot = (k..size).max_by(|&i, &j| a[i * size + k].abs().total_cmp(&a[j * size + k].abs())).unwrap_or(k);
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
        for i in k + 1..size {
            let factor = a[i * size + k] / value;
            for column in k + 1..size {
                a[i * size + column] -= factor * a[k * size + column];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..size).rev() {
        let rest: f64 = (k + 1..size).map(|column| a[k * size + column] * b[column]).sum();
        b[k] = (b[k] - rest) / a[k * size + k];
    }
    true
}

#[cfg(test)]
mod tests {
    #[test]
    fn solves_with_a_zero_on_the_diagonal() {
        let mut a = [0.0, 2.0, 1.0, 1.0, 1.0, 0.0, 3.0, 0.0, 4.0];
        let x = [1.5, -2.0, 0.25];
        let mut b: Vec<f64> = (0..3).map(|i| (0..3).map(|j| a[3 * i + j] * x[j]).sum()).collect();
        assert!(super::solve(&mut a, &mut b, 3));
        for (found, wanted) in b.iter().zip(x) {
            assert!((found - wanted).abs() < 1e-14);
        }
        assert!(!super::solve(&mut [1.0, 2.0, 2.0, 4.0], &mut [1.0, 1.0], 2));
    }
}
