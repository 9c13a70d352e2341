//! The largest multiple of a load that forces which only press, and torques within bounds, can balance: a linear programme, and its dual.
//!
//! The programme seeks forces λ ≥ 0 and torques b between their bounds with G λ + B b + a D + L = 0 and the largest a ≥ 0. The dual seeks a
//! motion w in which no force that presses takes power away (wᵀ G ≥ 0) and of which D drives 1 W for each unit of a (wᵀ D ≥ 1): whatever
//! the forces are, a is at most what then resists, −wᵀ L + Σ max(−lo wᵀ B, −hi wᵀ B). The least of these bounds is the largest a, so that
//! forces and motion prove each other.

use microlp::{ComparisonOp, Error, OptimizationDirection, Problem, Solution, SolveOutcome, Variable};

use super::StaticsError;
use super::loads::{Load, ROWS};

/// Columns of the equations, scaled so that what they weigh is about 1.
#[derive(Clone, Debug)]
pub struct Program {
    /// G: of forces that press only.
    pub pressing: Vec<Load>,
    /// B, with bounds.
    pub bounded: Vec<(Load, [f64; 2])>,
    /// D and L.
    pub driving: Load,
    pub fixed: Load,
}

/// Forces in balance with a load.
#[derive(Clone, Debug)]
pub struct Forces {
    pub multiple: f64,
    pub pressing: Vec<f64>,
    pub bounded: Vec<f64>,
}

/// What the programme says.
#[derive(Clone, Debug)]
pub enum Largest {
    /// Not even the fixed load can be balanced.
    Nothing,
    Finite(Forces),
    /// There are forces that balance the driving load by itself, as often as it is applied.
    Any,
}

/// A motion that proves a bound.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    pub bound: f64,
    pub motion: Load,
}

/// Power of a load in a motion.
pub fn weigh(motion: &Load, column: &Load) -> f64 {
    motion.iter().zip(column).map(|(rate, load)| rate * load).sum()
}

fn refused(error: impl ToString) -> StaticsError {
    StaticsError::Balance { reason: error.to_string() }
}

fn solved(problem: &Problem) -> Result<Option<Solution>, StaticsError> {
    match problem.solve() {
        Ok(SolveOutcome::Solution(solution)) => Ok(Some(solution)),
        Ok(SolveOutcome::Interrupted(_)) => Err(refused("it was interrupted")),
        Err(Error::Infeasible) => Ok(None),
        Err(error) => Err(refused(error)),
    }
}

impl Program {
    /// Forces with the load at a multiple within these bounds, the largest; `None` where there are none.
    fn forces(&self, multiple: (f64, f64), fixed: &Load, braking: f64) -> Result<Option<Forces>, StaticsError> {
        let mut problem = Problem::new(OptimizationDirection::Maximize);
        let driving = problem.add_var(1.0, multiple);
        let pressing: Vec<Variable> =
            self.pressing.iter().map(|_| problem.add_var(0.0, (0.0, f64::INFINITY))).collect();
        // 0 times an infinite bound is still infinite: what nothing turns gives any torque for any load.
        let bound = |bound: f64| if bound.is_finite() { braking * bound } else { bound };
        let bounded: Vec<Variable> =
            self.bounded.iter().map(|(_, [lo, hi])| problem.add_var(0.0, (bound(*lo), bound(*hi)))).collect();
        for (row, load) in fixed.iter().enumerate() {
            let of_pressing = pressing.iter().zip(&self.pressing).map(|(variable, column)| (*variable, column[row]));
            let of_bounded = bounded.iter().zip(&self.bounded).map(|(variable, (column, _))| (*variable, column[row]));
            let all = of_pressing.chain(of_bounded).chain([(driving, self.driving[row])]);
            let terms: Vec<(Variable, f64)> = all.filter(|(_, entry)| *entry != 0.0).collect();
            problem.add_constraint(terms, ComparisonOp::Eq, -load);
        }
        let Some(solution) = solved(&problem)? else { return Ok(None) };
        let values = |of: &[Variable]| of.iter().map(|&variable| solution.var_value(variable)).collect();
        Ok(Some(Forces {
            multiple: solution.var_value(driving),
            pressing: values(&pressing),
            bounded: values(&bounded),
        }))
    }

    /// What resists a motion: all but the forces that press.
    pub fn resists(&self, motion: &Load) -> f64 {
        let braked = self.bounded.iter().map(|(column, [lo, hi])| {
            let rate = weigh(motion, column);
            let of = |limit: f64| if limit.is_finite() { -limit * rate } else { f64::NEG_INFINITY };
            // What nothing turns does not move, and takes no power.
            Some(of(*lo).max(of(*hi))).filter(|power| power.is_finite()).unwrap_or(0.0)
        });
        braked.sum::<f64>() - weigh(motion, &self.fixed)
    }

    /// The largest multiple of the driving load, from 0 on.
    pub fn largest(&self) -> Result<Largest, StaticsError> {
        if self.forces((0.0, 0.0), &self.fixed, 1.0)?.is_none() {
            return Ok(Largest::Nothing);
        }
        if self.forces((1.0, 1.0), &[0.0; ROWS], 0.0)?.is_some() {
            return Ok(Largest::Any);
        }
        let found = self.forces((0.0, f64::INFINITY), &self.fixed, 1.0)?;
        found.map(Largest::Finite).ok_or_else(|| refused("forces were found at rest, and then none"))
    }

    /// The least bound on the multiple; `None` where no motion gives one.
    pub fn bound(&self) -> Result<Option<Bound>, StaticsError> {
        let mut problem = Problem::new(OptimizationDirection::Minimize);
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let motion: [Variable; ROWS] = std::array::from_fn(|row| problem.add_var(-self.fixed[row], free));
        let terms = |column: &Load, factor: f64| -> Vec<(Variable, f64)> {
            let all = motion.iter().zip(column).map(|(variable, entry)| (*variable, factor * entry));
            all.filter(|(_, entry)| *entry != 0.0).collect()
        };
        for column in &self.pressing {
            problem.add_constraint(terms(column, 1.0), ComparisonOp::Ge, 0.0);
        }
        for (column, [lo, hi]) in &self.bounded {
            let resists = problem.add_var(1.0, free);
            // What nothing turns does not move that way.
            for (limit, sign) in [(*lo, ComparisonOp::Le), (*hi, ComparisonOp::Ge)] {
                if limit.is_finite() {
                    let mut terms = terms(column, limit);
                    terms.push((resists, 1.0));
                    problem.add_constraint(terms, ComparisonOp::Ge, 0.0);
                } else {
                    problem.add_constraint(terms(column, 1.0), sign, 0.0);
                }
            }
            if lo.is_infinite() && hi.is_infinite() {
                problem.add_constraint(vec![(resists, 1.0)], ComparisonOp::Ge, 0.0);
            }
        }
        problem.add_constraint(terms(&self.driving, 1.0), ComparisonOp::Ge, 1.0);
        let Some(solution) = solved(&problem)? else { return Ok(None) };
        let motion: Load = std::array::from_fn(|row| solution.var_value(motion[row]));
        Ok(Some(Bound { bound: self.resists(&motion), motion }))
    }
}
