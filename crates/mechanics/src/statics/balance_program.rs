//! The largest multiple of a load that unilateral forces and bounded torques can balance: a linear programme and its
//! dual.
//!
//! The programme seeks forces λ ≥ 0 and torques b between their bounds with G λ + B b + a D + L = 0 and the largest a ≥
//! 0. The dual seeks a motion w in which unilateral forces have no negative power (wᵀ G ≥ 0) and D has at least 1 W per
//! unit of a (wᵀ D ≥ 1). For any forces, a is at most the resisting power −wᵀ L + Σ max(−lo wᵀ B, −hi wᵀ B). The
//! smallest of these bounds equals the largest a, so that forces and motion certify each other.

use microlp::{ComparisonOp, Error, OptimizationDirection, Problem, Solution, SolveOutcome, Variable};

use super::StaticsError;
use super::loads::{Load, ROWS};

/// Columns of the equations, scaled so that the loads are about 1.
#[derive(Clone, Debug)]
pub struct Program {
    /// G: unilateral forces along the edges of the friction cones.
    pub contact_edges: Vec<Load>,
    /// B: torques with their bounds.
    pub bounded_torques: Vec<(Load, [f64; 2])>,
    /// D: driving load.
    pub driving: Load,
    /// L: fixed load.
    pub fixed: Load,
}

/// Forces in balance with a load.
#[derive(Clone, Debug)]
pub struct Forces {
    pub multiple: f64,
    pub contact_edges: Vec<f64>,
    pub bounded_torques: Vec<f64>,
}

/// Result of the programme.
#[derive(Clone, Debug)]
pub enum Optimum {
    /// Not even the fixed load can be balanced.
    Infeasible,
    Finite(Forces),
    /// Forces exist that balance any multiple of the driving load.
    Unbounded,
}

/// A motion that certifies a bound.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    pub bound: f64,
    pub motion: Load,
}

/// Power of a load in a motion.
pub fn power(motion: &Load, column: &Load) -> f64 {
    motion.iter().zip(column).map(|(rate, load)| rate * load).sum()
}

fn balance_error(error: impl ToString) -> StaticsError {
    StaticsError::Balance { reason: error.to_string() }
}

fn solve_problem(problem: &Problem) -> Result<Option<Solution>, StaticsError> {
    match problem.solve() {
        Ok(SolveOutcome::Solution(solution)) => Ok(Some(solution)),
        Ok(SolveOutcome::Interrupted(_)) => Err(balance_error("interrupted")),
        Err(Error::Infeasible) => Ok(None),
        Err(error) => Err(balance_error(error)),
    }
}

impl Program {
    /// Returns the forces that balance `fixed` and the largest multiple of the driving load, which is limited to the
    /// range `multiple`; `None` if infeasible. `braking` scales the torque bounds.
    fn forces(&self, multiple: (f64, f64), fixed: &Load, braking: f64) -> Result<Option<Forces>, StaticsError> {
        let mut problem = Problem::new(OptimizationDirection::Maximize);
        let driving = problem.add_var(1.0, multiple);
        let contact_edges: Vec<Variable> =
            self.contact_edges.iter().map(|_| problem.add_var(0.0, (0.0, f64::INFINITY))).collect();
        // 0 times an infinite bound remains infinite: a blocked drive can resist any torque.
        let bound = |bound: f64| if bound.is_finite() { braking * bound } else { bound };
        let bounded_torques: Vec<Variable> =
            self.bounded_torques.iter().map(|(_, [lo, hi])| problem.add_var(0.0, (bound(*lo), bound(*hi)))).collect();
        for (row, load) in fixed.iter().enumerate() {
            let contact_terms =
                contact_edges.iter().zip(&self.contact_edges).map(|(variable, column)| (*variable, column[row]));
            let torque_terms = bounded_torques
                .iter()
                .zip(&self.bounded_torques)
                .map(|(variable, (column, _))| (*variable, column[row]));
            let all = contact_terms.chain(torque_terms).chain([(driving, self.driving[row])]);
            let terms: Vec<(Variable, f64)> = all.filter(|(_, entry)| *entry != 0.0).collect();
            problem.add_constraint(terms, ComparisonOp::Eq, -load);
        }
        let Some(solution) = solve_problem(&problem)? else { return Ok(None) };
        let values = |variables: &[Variable]| variables.iter().map(|&variable| solution.var_value(variable)).collect();
        Ok(Some(Forces {
            multiple: solution.var_value(driving),
            contact_edges: values(&contact_edges),
            bounded_torques: values(&bounded_torques),
        }))
    }

    /// Power that resists a motion, without the unilateral forces.
    pub fn resisting_power(&self, motion: &Load) -> f64 {
        let brake_power = self.bounded_torques.iter().map(|(column, [lo, hi])| {
            let rate = power(motion, column);
            let power_at = |limit: f64| if limit.is_finite() { -limit * rate } else { f64::NEG_INFINITY };
            // A blocked drive does not move and has no power.
            Some(power_at(*lo).max(power_at(*hi))).filter(|power| power.is_finite()).unwrap_or(0.0)
        });
        brake_power.sum::<f64>() - power(motion, &self.fixed)
    }

    /// Returns the largest multiple of the driving load, at least 0.
    pub fn largest(&self) -> Result<Optimum, StaticsError> {
        if self.forces((0.0, 0.0), &self.fixed, 1.0)?.is_none() {
            return Ok(Optimum::Infeasible);
        }
        if self.forces((1.0, 1.0), &[0.0; ROWS], 0.0)?.is_some() {
            return Ok(Optimum::Unbounded);
        }
        let found = self.forces((0.0, f64::INFINITY), &self.fixed, 1.0)?;
        found
            .map(Optimum::Finite)
            .ok_or_else(|| balance_error("feasible at rest, but infeasible for the largest acceleration"))
    }

    /// Returns the smallest bound on the multiple; `None` if no motion gives one.
    pub fn bound(&self) -> Result<Option<Bound>, StaticsError> {
        let mut problem = Problem::new(OptimizationDirection::Minimize);
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let motion: [Variable; ROWS] = std::array::from_fn(|row| problem.add_var(-self.fixed[row], free));
        let terms = |column: &Load, factor: f64| -> Vec<(Variable, f64)> {
            let all = motion.iter().zip(column).map(|(variable, entry)| (*variable, factor * entry));
            all.filter(|(_, entry)| *entry != 0.0).collect()
        };
        for column in &self.contact_edges {
            problem.add_constraint(terms(column, 1.0), ComparisonOp::Ge, 0.0);
        }
        for (column, [lo, hi]) in &self.bounded_torques {
            let resisting_power = problem.add_var(1.0, free);
            // A drive that is blocked in a direction does not move in it.
            for (limit, sign) in [(*lo, ComparisonOp::Le), (*hi, ComparisonOp::Ge)] {
                if limit.is_finite() {
                    let mut terms = terms(column, limit);
                    terms.push((resisting_power, 1.0));
                    problem.add_constraint(terms, ComparisonOp::Ge, 0.0);
                } else {
                    problem.add_constraint(terms(column, 1.0), sign, 0.0);
                }
            }
            if lo.is_infinite() && hi.is_infinite() {
                problem.add_constraint(vec![(resisting_power, 1.0)], ComparisonOp::Ge, 0.0);
            }
        }
        problem.add_constraint(terms(&self.driving, 1.0), ComparisonOp::Ge, 1.0);
        let Some(solution) = solve_problem(&problem)? else { return Ok(None) };
        let motion: Load = std::array::from_fn(|row| solution.var_value(motion[row]));
        Ok(Some(Bound { bound: self.resisting_power(&motion), motion }))
    }
}
