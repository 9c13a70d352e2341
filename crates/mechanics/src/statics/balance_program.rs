//! The largest multiple of a load that unilateral forces and bounded torques can balance: a linear programme and its
//! dual.
//!
//! The programme seeks forces λ ≥ 0 and torques b between their bounds with G λ + B b + a D + L = 0 and the largest a ≥
//! 0. The dual seeks a motion w in which unilateral forces have no negative power (wᵀ G ≥ 0) and D has at least 1 W per
//! unit of a (wᵀ D ≥ 1). For any forces, a is at most the resisting power −wᵀ L + Σ max(−lo wᵀ B, −hi wᵀ B). The
//! smallest of these bounds equals the largest a, so that forces and motion certify each other.
//!
//! The solver's solutions are approximate. They are refined: values close to a bound are set to it, and the others get
//! the smallest correction that satisfies the equations.

use std::ops::Range;

use microlp::{ComparisonOp, OptimizationDirection, Problem, Variable};
use nalgebra::{DMatrix, DVector};

use super::form_closure::{solve_program, terms};
use super::{Result, StaticsError};

/// Generalised forces of one load: one column of the equations.
pub type Load = Vec<f64>;

/// A force or torque of unknown size: its load per unit, scaled to size 1, and its bounds.
#[derive(Clone, Debug)]
pub struct Column {
    pub load: Load,
    pub bounds: [f64; 2],
    /// Size of the load before scaling.
    pub size: f64,
}

/// Columns, scaled to loads of about 1: driving load D, unilateral forces G along edges of friction cones, torques B.
#[derive(Clone, Debug)]
pub struct Program {
    pub columns: Vec<Column>,
    /// Number of edges of friction cones.
    pub edge_count: usize,
    /// L: fixed load.
    pub fixed: Load,
}

/// Result of the programme.
#[derive(Clone, Debug)]
pub(crate) enum Optimum {
    /// Not even the fixed load can be balanced.
    Infeasible,
    /// The size of each column; that of the driving load is the largest multiple.
    Finite(Vec<f64>),
    /// Forces exist that balance any multiple of the driving load.
    Unbounded,
}

/// A motion that certifies a bound.
#[derive(Clone, Debug)]
pub struct Bound {
    pub bound: f64,
    pub motion: Load,
}

pub fn power(motion: &[f64], column: &[f64]) -> f64 {
    motion.iter().zip(column).map(|(rate, load)| rate * load).sum()
}

fn balance_error(reason: String) -> StaticsError {
    StaticsError::Balance { reason }
}

impl Program {
    /// Indices of the unilateral forces.
    pub(crate) fn contact_edges(&self) -> Range<usize> {
        1..1 + self.edge_count
    }

    pub fn torques(&self) -> Range<usize> {
        1 + self.edge_count..self.columns.len()
    }

    /// Indices of all columns; the driving load is the last.
    fn driving_last(&self) -> impl Iterator<Item = usize> + use<> {
        (1..self.columns.len()).chain([0])
    }

    /// Returns the forces that balance `fixed` and the largest multiple of the driving load, which is limited to the
    /// range `multiple`; `None` if infeasible. `braking` scales the torque bounds.
    fn forces(&self, multiple: (f64, f64), fixed: &[f64], braking: f64) -> Result<Option<Vec<f64>>> {
        let mut problem = Problem::new(OptimizationDirection::Maximize);
        // 0 times an infinite bound remains infinite: a blocked drive can resist any torque.
        let bound = |bound: f64| if bound.is_finite() { braking * bound } else { bound };
        let mut variables = vec![problem.add_var(1.0, multiple)];
        for Column { bounds: [lo, hi], .. } in &self.columns[1..] {
            variables.push(problem.add_var(0.0, (bound(*lo), bound(*hi))));
        }
        for (row, load) in fixed.iter().enumerate() {
            let all = self.driving_last().map(|index| (variables[index], self.columns[index].load[row]));
            let terms: Vec<(Variable, f64)> = all.filter(|(_, entry)| *entry != 0.0).collect();
            problem.add_constraint(terms, ComparisonOp::Eq, -load);
        }
        let solution = solve_program(&problem, balance_error)?;
        Ok(solution.map(|solution| variables.into_iter().map(|variable| solution.var_value(variable)).collect()))
    }

    /// Power that resists a motion, without the unilateral forces.
    fn resisting_power(&self, motion: &[f64]) -> f64 {
        let brake_power = self.columns[self.torques()].iter().map(|Column { load, bounds: [lo, hi], .. }| {
            let rate = power(motion, load);
            let power_at = |limit: f64| if limit.is_finite() { -limit * rate } else { f64::NEG_INFINITY };
            // A blocked drive does not move and has no power.
            Some(power_at(*lo).max(power_at(*hi))).filter(|power| power.is_finite()).unwrap_or(0.0)
        });
        brake_power.sum::<f64>() - power(motion, &self.fixed)
    }

    /// Returns the largest multiple of the driving load, at least 0.
    pub fn largest(&self) -> Result<Optimum> {
        if self.forces((0.0, 0.0), &self.fixed, 1.0)?.is_none() {
            return Ok(Optimum::Infeasible);
        }
        if self.forces((1.0, 1.0), &vec![0.0; self.fixed.len()], 0.0)?.is_some() {
            return Ok(Optimum::Unbounded);
        }
        let found = self.forces((0.0, f64::INFINITY), &self.fixed, 1.0)?;
        let contradiction = "feasible at rest, but infeasible for the largest acceleration";
        found.map(Optimum::Finite).ok_or_else(|| balance_error(contradiction.to_string()))
    }

    /// Returns the smallest bound on the multiple; `None` if no motion gives one.
    pub fn bound(&self) -> Result<Option<Bound>> {
        let mut problem = Problem::new(OptimizationDirection::Minimize);
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let motion: Vec<Variable> = self.fixed.iter().map(|load| problem.add_var(-load, free)).collect();
        let terms = |column: &[f64], factor: f64| {
            let scaled: Vec<f64> = column.iter().map(|entry| factor * entry).collect();
            terms(&motion, scaled.iter())
        };
        for column in &self.columns[self.contact_edges()] {
            problem.add_constraint(terms(&column.load, 1.0), ComparisonOp::Ge, 0.0);
        }
        for Column { load, bounds: [lo, hi], .. } in &self.columns[self.torques()] {
            let resisting_power = problem.add_var(1.0, free);
            // A drive that is blocked in a direction does not move in it.
            for (limit, sign) in [(*lo, ComparisonOp::Le), (*hi, ComparisonOp::Ge)] {
                if limit.is_finite() {
                    let mut terms = terms(load, limit);
                    terms.push((resisting_power, 1.0));
                    problem.add_constraint(terms, ComparisonOp::Ge, 0.0);
                } else {
                    problem.add_constraint(terms(load, 1.0), sign, 0.0);
                }
            }
            if lo.is_infinite() && hi.is_infinite() {
                problem.add_constraint(vec![(resisting_power, 1.0)], ComparisonOp::Ge, 0.0);
            }
        }
        problem.add_constraint(terms(&self.columns[0].load, 1.0), ComparisonOp::Ge, 1.0);
        let Some(solution) = solve_program(&problem, balance_error)? else { return Ok(None) };
        let motion: Load = motion.into_iter().map(|rate| solution.var_value(rate)).collect();
        Ok(Some(Bound { bound: self.resisting_power(&motion), motion }))
    }
}

/// Distance from its bound (with loads of about 1) within which a force is on it: ten times the programme's tolerance.
const ON_BOUND_TOLERANCE: f64 = 1e-6;

/// Singular values below this are zero (columns have size 1).
const RANK_TOLERANCE: f64 = 1e-9;

/// Rounding tolerance for a corrected force beyond its bound.
const BOUND_TOLERANCE: f64 = 1e-12;

/// Returns the minimum-norm least-squares solution x of A x = b; `None` without columns.
fn least_squares(columns: &[&Load], b: &[f64]) -> Option<DVector<f64>> {
    if columns.is_empty() {
        return None;
    }
    let matrix = DMatrix::from_fn(b.len(), columns.len(), |row, column| columns[column][row]);
    matrix.svd(true, true).solve(&DVector::from_row_slice(b), RANK_TOLERANCE).ok()
}

fn on_bound(value: f64, [lo, hi]: [f64; 2]) -> Option<f64> {
    [lo, hi].into_iter().find(|bound| (value - bound).abs() < ON_BOUND_TOLERANCE)
}

/// Projects a motion onto the column space: without friction, for instance, the rotation of a disc is arbitrary.
fn project_onto_columns(columns: &[&Load], motion: &[f64]) -> Load {
    let matrix = DMatrix::from_fn(motion.len(), columns.len(), |row, column| columns[column][row]);
    let svd = matrix.svd(true, false);
    let Some(u) = svd.u else { return motion.to_vec() };
    let rank = svd.singular_values.iter().filter(|value| **value > RANK_TOLERANCE * svd.singular_values.max()).count();
    let basis = u.columns(0, rank);
    let within = basis * basis.tr_mul(&DVector::from_row_slice(motion));
    within.as_slice().to_vec()
}

impl Program {
    /// Indices of the forces that are not on a bound; the driving load is the last.
    fn free_forces(&self, forces: &[f64]) -> Vec<usize> {
        self.driving_last().filter(|&index| on_bound(forces[index], self.columns[index].bounds).is_none()).collect()
    }

    /// Forces in exact balance; the original ones if the correction would move one of them beyond its bound.
    pub(crate) fn exact_forces(&self, found: Vec<f64>) -> Vec<f64> {
        let on_bounds = found.iter().zip(&self.columns);
        let mut forces: Vec<f64> =
            on_bounds.map(|(value, column)| on_bound(*value, column.bounds).unwrap_or(*value)).collect();
        let free = self.free_forces(&forces);
        let missing = |(row, fixed): (usize, &f64)| {
            let balanced = self.driving_last().map(|index| self.columns[index].load[row] * forces[index]);
            -fixed - balanced.sum::<f64>()
        };
        let missing: Load = self.fixed.iter().enumerate().map(missing).collect();
        let columns: Vec<&Load> = free.iter().map(|&index| &self.columns[index].load).collect();
        if let Some(correction) = least_squares(&columns, &missing) {
            free.iter().zip(correction.iter()).for_each(|(&index, by)| forces[index] += by);
        }
        let is_within = |(value, Column { bounds: [lo, hi], .. }): (&f64, &Column)| {
            *value >= lo - BOUND_TOLERANCE && *value <= hi + BOUND_TOLERANCE
        };
        if forces.iter().zip(&self.columns).all(is_within) { forces } else { found }
    }

    /// Returns the motion in which forces within their bounds have exactly zero power, and the driving load has 1 W.
    pub(crate) fn exact_motion(&self, forces: &[f64], found: Bound) -> Bound {
        let loads = self.driving_last().map(|index| &self.columns[index].load);
        let columns: Vec<&Load> = loads.chain([&self.fixed]).collect();
        let start = project_onto_columns(&columns, &found.motion);
        let free = self.free_forces(forces).into_iter().filter(|index| *index != 0);
        let mut rows: Vec<(&Load, f64)> = free.map(|index| (&self.columns[index].load, 0.0)).collect();
        rows.push((&self.columns[0].load, 1.0));
        let matrix = DMatrix::from_fn(rows.len(), start.len(), |i, j| rows[i].0[j]);
        let missing = DVector::from_fn(rows.len(), |i, _| rows[i].1 - power(&start, rows[i].0));
        let Ok(correction) = matrix.svd(true, true).solve(&missing, RANK_TOLERANCE) else { return found };
        let motion: Load = start.iter().zip(correction.iter()).map(|(rate, by)| rate + by).collect();
        Bound { bound: self.resisting_power(&motion), motion }
    }
}
