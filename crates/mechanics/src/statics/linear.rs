//! Ranks, null vectors and projections of U, whose rows and columns are scaled to weigh alike.

use nalgebra::{DMatrix, DVector};

use super::{Kind, Unilateral};

/// Relative size of a pivot below which a row adds nothing to the others.
const RANK_TOLERANCE: f64 = 1e-10;

/// U with unknowns as speeds in m/s and rows of length 1.
#[derive(Clone, Debug)]
pub struct Scaled {
    pub matrix: DMatrix<f64>,
    /// Length of each row before; 1 for a row of zeros.
    pub norms: Vec<f64>,
}

/// Scales U: column j by 1/scale_j, row i by 1/norm_i.
pub fn scaled<R: Copy + Into<Kind>>(u: &Unilateral<R>) -> Scaled {
    let (m, n) = (u.rows.len(), u.unknowns.len());
    let mut matrix = DMatrix::from_fn(m, n, |i, j| u.row(i)[j] / u.scale[j]);
    let norms: Vec<f64> =
        (0..m).map(|i| Some(matrix.row(i).norm()).filter(|&norm| norm > 0.0).unwrap_or(1.0)).collect();
    for (i, norm) in norms.iter().enumerate() {
        matrix.row_mut(i).unscale_mut(*norm);
    }
    Scaled { matrix, norms }
}

/// Orthonormal basis of the span of the columns, as columns.
pub fn basis(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    if matrix.is_empty() {
        return DMatrix::zeros(matrix.nrows(), 0);
    }
    let qr = matrix.clone().col_piv_qr();
    let r = qr.r();
    let pivot = |i: usize| r[(i, i)].abs();
    let rank = (0..r.nrows()).take_while(|&i| pivot(i) > 0.0 && pivot(i) > RANK_TOLERANCE * pivot(0)).count();
    qr.q().columns(0, rank).into_owned()
}

/// What of a vector is orthogonal to a basis; projected twice, which is orthogonal to rounding.
pub fn beside(basis: &DMatrix<f64>, vector: &DVector<f64>) -> DVector<f64> {
    let once = vector - basis * basis.tr_mul(vector);
    &once - basis * basis.tr_mul(&once)
}

/// A vector of length 1 orthogonal to a basis that leaves room for one.
pub fn orthogonal(basis: &DMatrix<f64>) -> DVector<f64> {
    let n = basis.nrows();
    // The axis that the basis covers least.
    let covered = |i: usize| basis.row(i).norm_squared();
    let axis = (0..n).min_by(|&a, &b| covered(a).total_cmp(&covered(b))).unwrap_or(0);
    beside(basis, &DVector::from_fn(n, |i, _| if i == axis { 1.0 } else { 0.0 })).normalize()
}

/// ω with A ω = s for a matrix of full column rank and an s among its columns' combinations.
pub fn solve(matrix: &DMatrix<f64>, s: &DVector<f64>) -> Option<DVector<f64>> {
    let qr = matrix.clone().qr();
    qr.r().solve_upper_triangular(&qr.q().tr_mul(s))
}
