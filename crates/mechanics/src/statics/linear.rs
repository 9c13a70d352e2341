//! Ranks, null vectors and projections of U, with normalised rows and columns, and linear programmes, solved by
//! [`microlp`].

use microlp::{ComparisonOp, Error, OptimizationDirection, Problem, Solution, SolveOutcome, Variable};
use nalgebra::{DMatrix, DVector};

use super::{StaticsError, Unilateral};

/// Relative size of a pivot below which a column is linearly dependent.
const RANK_TOLERANCE: f64 = 1e-10;

/// U with unknowns scaled to speeds in m/s and rows of length 1.
#[derive(Clone, Debug)]
pub struct Scaled {
    pub matrix: DMatrix<f64>,
    /// Length of each row before scaling; 1 for a row of zeros.
    pub norms: Vec<f64>,
}

/// Scales U: column j by 1/scale_j, row i by 1/norm_i.
pub(crate) fn scale_constraints(u: &Unilateral) -> Scaled {
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

/// Component of a vector orthogonal to a basis; projected twice, so that it is orthogonal up to rounding.
pub(crate) fn orthogonal_component(basis: &DMatrix<f64>, vector: &DVector<f64>) -> DVector<f64> {
    let projected = vector - basis * basis.tr_mul(vector);
    &projected - basis * basis.tr_mul(&projected)
}

/// Returns a unit vector orthogonal to a basis that does not span the whole space.
pub(crate) fn orthogonal(basis: &DMatrix<f64>) -> DVector<f64> {
    let n = basis.nrows();
    // Select the axis with the smallest projection onto the basis.
    let coverage = |i: usize| basis.row(i).norm_squared();
    let axis = (0..n).min_by(|&a, &b| coverage(a).total_cmp(&coverage(b))).unwrap_or(0);
    orthogonal_component(basis, &DVector::from_fn(n, |i, _| if i == axis { 1.0 } else { 0.0 })).normalize()
}

/// ω with A ω = s for a matrix of full column rank and an s in its column space.
pub fn solve(matrix: &DMatrix<f64>, s: &DVector<f64>) -> Option<DVector<f64>> {
    let qr = matrix.clone().qr();
    qr.r().solve_upper_triangular(&qr.q().tr_mul(s))
}

/// Multipliers λ ≥ 1 with Aᵀ λ = 0 and the smallest sum, if they exist.
///
/// If they exist, A ω ≥ 0 implies A ω = 0, since λ·A ω = 0 has no negative terms.
pub fn multipliers(matrix: &DMatrix<f64>) -> Result<Option<DVector<f64>>, StaticsError> {
    let mut problem = Problem::new(OptimizationDirection::Minimize);
    let lambda: Vec<Variable> = matrix.row_iter().map(|_| problem.add_var(1.0, (1.0, f64::INFINITY))).collect();
    for column in matrix.column_iter() {
        problem.add_constraint(terms(&lambda, column.iter()), ComparisonOp::Eq, 0.0);
    }
    values(&problem, &lambda)
}

/// Returns the motion ω of the largest sum of separations A ω with 0 ≤ A ω ≤ 1.
pub fn motion(matrix: &DMatrix<f64>) -> Result<Option<DVector<f64>>, StaticsError> {
    let mut problem = Problem::new(OptimizationDirection::Maximize);
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    let omega: Vec<Variable> = matrix.column_iter().map(|column| problem.add_var(column.sum(), free)).collect();
    for row in matrix.row_iter() {
        let terms = terms(&omega, row.iter());
        problem.add_constraint(terms.clone(), ComparisonOp::Ge, 0.0);
        problem.add_constraint(terms, ComparisonOp::Le, 1.0);
    }
    values(&problem, &omega)
}

/// Terms of a constraint; zero entries are omitted.
pub fn terms<'a>(variables: &[Variable], entries: impl Iterator<Item = &'a f64>) -> Vec<(Variable, f64)> {
    variables.iter().copied().zip(entries.copied()).filter(|(_, entry)| *entry != 0.0).collect()
}

fn values(problem: &Problem, of: &[Variable]) -> Result<Option<DVector<f64>>, StaticsError> {
    let solution = solve_program(problem, |reason| StaticsError::Program { reason })?;
    let read = |solution: Solution| DVector::from_iterator(of.len(), of.iter().map(|&v| solution.var_value(v)));
    Ok(solution.map(read))
}

/// Solves a linear programme; `None` if it is infeasible.
pub(crate) fn solve_program(
    problem: &Problem,
    error: impl Fn(String) -> StaticsError,
) -> Result<Option<Solution>, StaticsError> {
    match problem.solve() {
        Ok(SolveOutcome::Solution(solution)) => Ok(Some(solution)),
        Ok(SolveOutcome::Interrupted(_)) => Err(error("interrupted".to_string())),
        Err(Error::Infeasible) => Ok(None),
        Err(other) => Err(error(other.to_string())),
    }
}
