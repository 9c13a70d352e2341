//! The two linear programmes of form closure, solved by [`microlp`].

use microlp::{ComparisonOp, Error, OptimizationDirection, Problem, Solution, SolveOutcome, Variable};
use nalgebra::{DMatrix, DVector};

use super::StaticsError;

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

fn terms<'a>(variables: &[Variable], entries: impl Iterator<Item = &'a f64>) -> Vec<(Variable, f64)> {
    variables.iter().copied().zip(entries.copied()).filter(|(_, entry)| *entry != 0.0).collect()
}

fn values(problem: &Problem, of: &[Variable]) -> Result<Option<DVector<f64>>, StaticsError> {
    let read = |solution: &Solution| DVector::from_iterator(of.len(), of.iter().map(|&v| solution.var_value(v)));
    match problem.solve() {
        Ok(SolveOutcome::Solution(solution)) => Ok(Some(read(&solution))),
        Ok(SolveOutcome::Interrupted(_)) => Err(StaticsError::Program { reason: "interrupted".to_string() }),
        Err(Error::Infeasible) => Ok(None),
        Err(error) => Err(StaticsError::Program { reason: error.to_string() }),
    }
}
