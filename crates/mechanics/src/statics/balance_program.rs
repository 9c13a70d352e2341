//! The largest multiple of a load that unilateral forces and bounded torques can balance: a linear programme and its
//! dual.
//!
//! The programme seeks forces λ ≥ 0 and torques b between their bounds with G λ + B b + a D + L = 0 and the largest a ≥
//! 0. The dual seeks a motion w in which unilateral forces have no negative power (wᵀ G ≥ 0) and D has at least 1 W per
//! unit of a (wᵀ D ≥ 1). For any forces, a is at most the resisting power −wᵀ L + Σ max(−lo wᵀ B, −hi wᵀ B). The
//! smallest of these bounds equals the largest a, so that forces and motion certify each other.
//!
//! Each result has a certificate, which is verified: forces and motion of a limit; forces that grow with a; a motion in
//! which all admissible forces have positive power, so that they cannot balance. A result without its certificate is
//! computed again by another method, and is an error if that fails as well.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::simplex::{LinearProgram, Outcome, Rule};
use super::{Result, StaticsError};

/// Generalised forces of one load: one column of the equations.
pub type Load = Vec<f64>;

/// A force or torque of unknown magnitude: its bounds, and the load per unit, scaled to size 1.
#[derive(Clone, Debug)]
pub struct Column {
    pub load: Load,
    pub bounds: [f64; 2],
    /// Size of the load before scaling.
    pub size: f64,
}

/// Linear programme with columns scaled to loads of about 1: the driving load D, the unilateral forces G along the
/// edges of the friction cones, and the torques B.
#[derive(Clone, Debug)]
pub struct Program {
    pub columns: Vec<Column>,
    /// Number of edges of friction cones.
    pub edge_count: usize,
    /// L: fixed load.
    pub fixed: Load,
}

/// Verified result of the programme.
#[derive(Clone, Debug)]
pub(super) enum Optimum {
    /// Not even the fixed load can be balanced: all admissible forces have positive power in the motion.
    Infeasible { motion: Load },
    /// The size of each column; that of the driving load is the largest multiple.
    Finite(ProgramLimit),
    /// Forces exist that balance any multiple of the driving load.
    Unbounded,
}

/// The largest multiple, with its forces and the motion that bounds it.
#[derive(Clone, Debug)]
pub(super) struct ProgramLimit {
    /// The size of each column; that of the driving load is the largest multiple.
    pub forces: Vec<f64>,
    pub motion: Load,
    /// Difference of the bounds from forces and motion, relative to the multiple or to 1.
    pub gap: f64,
}

/// Largest difference of the bounds from forces and motion, relative to the multiple or to 1 (that of the fixed load).
const GAP: f64 = 1e-6;

/// Rates below this fraction of the largest are rounding.
pub(super) const ROUNDING: f64 = 1e-7;

/// Largest rate against a unilateral force, relative to the largest rate.
const BACKWARD: f64 = 1e-9;

/// Unbalanced remainder of forces, relative to the largest terms of a row, that counts as zero.
const REMAINDER: f64 = 1e-7;

/// The same for forces that grow without limit: rounding errors of the columns and of the sums only.
const RAY_REMAINDER: f64 = 1e-12;

/// The same relative to the driving load, which forces that balance each other may exceed by far.
const RAY_SHARE: f64 = 1e-9;

/// Singular values below this are zero (columns have size 1).
const RANK_TOLERANCE: f64 = 1e-9;

pub fn power(motion: &[f64], column: &[f64]) -> f64 {
    motion.iter().zip(column).map(|(rate, load)| rate * load).sum()
}

impl Program {
    /// Indices of the unilateral forces.
    pub(super) fn contact_edges(&self) -> Range<usize> {
        1..1 + self.edge_count
    }

    pub fn torques(&self) -> Range<usize> {
        1 + self.edge_count..self.columns.len()
    }

    /// Returns the largest multiple of the driving load, at least 0. `is_balanced` says whether the fixed load is known to be
    /// balanced, which does not depend on the driving load; it is set once it is known.
    pub(super) fn largest(&self, is_balanced: &mut bool) -> Result<Optimum> {
        let entries = self.columns.iter().flat_map(|column| &column.load).chain(&self.fixed);
        if !entries.clone().all(|entry| entry.is_finite()) {
            let reason = "a load is not a number: a cable or spring has no direction".to_string();
            return Err(StaticsError::Balance { reason });
        }
        if self.fixed.is_empty() {
            return Ok(Optimum::Unbounded);
        }
        let programme = LinearProgram {
            matrix: DMatrix::from_fn(self.fixed.len(), self.columns.len(), |row, index| self.columns[index].load[row]),
            right: DVector::from_iterator(self.fixed.len(), self.fixed.iter().map(|load| -load)),
            bounds: self.columns.iter().map(|column| column.bounds).collect(),
            objective: (0..self.columns.len()).map(|index| if index == 0 { 1.0 } else { 0.0 }).collect(),
        };
        // A hand may need an acceleration to be balanced; it is not at rest.
        let mut at_rest = programme.clone();
        (at_rest.bounds[0], at_rest.objective[0]) = ([0.0; 2], 0.0);
        let mut reason = String::new();
        for rule in [Rule::Steepest, Rule::First] {
            let outcome_at_rest = if *is_balanced { None } else { Some(at_rest.solve(rule)) };
            let verified = match outcome_at_rest {
                Some(Some(Outcome::Infeasible { y })) => self.verified_contradiction(y),
                None | Some(Some(Outcome::Optimal { .. })) => {
                    *is_balanced = true;
                    match programme.solve_with_smallest_multipliers(rule) {
                        Some(Outcome::Optimal { x, y }) => self.verified_limit(x, y),
                        Some(Outcome::Unbounded { x, ray }) => self.verified_ray(&x, &ray),
                        Some(Outcome::Infeasible { .. }) => {
                            Err("feasible at rest, but for no acceleration".to_string())
                        }
                        None => Err("the method does not end".to_string()),
                    }
                }
                _ => Err("the method does not end".to_string()),
            };
            match verified {
                Ok(found) => return Ok(found),
                Err(why) => reason = why,
            }
        }
        Err(StaticsError::Balance { reason })
    }

    /// Sum of the loads with these sizes in each row, with the sum of the magnitudes of all terms.
    fn balance(&self, forces: &[f64], fixed: &[f64]) -> Vec<(f64, f64)> {
        let row = |(row, fixed): (usize, &f64)| {
            let terms = self.columns.iter().zip(forces).map(|(column, force)| column.load[row] * force);
            terms.fold((*fixed, fixed.abs()), |(sum, size), term| (sum + term, size + term.abs()))
        };
        fixed.iter().enumerate().map(row).collect()
    }

    /// Checks that forces are within their bounds and balance the fixed load.
    fn verify_forces(&self, forces: &[f64]) -> std::result::Result<(), String> {
        let is_within = |(force, Column { bounds: [lo, hi], .. }): (&f64, &Column)| {
            let slack = 1e-9 * (1.0 + force.abs());
            *force >= lo - slack && *force <= hi + slack
        };
        if !forces.iter().zip(&self.columns).all(is_within) {
            return Err("a force exceeds its bounds".to_string());
        }
        let rows = self.balance(forces, &self.fixed);
        let size = rows.iter().map(|(_, size)| *size).fold(0.0, f64::max);
        match rows.iter().map(|(sum, _)| sum.abs()).fold(0.0, f64::max) {
            rest if rest <= REMAINDER * size => Ok(()),
            rest => Err(format!("the forces leave {rest:.1e} of {size:.1e} unbalanced")),
        }
    }

    fn verified_limit(&self, forces: Vec<f64>, motion: Load) -> std::result::Result<Optimum, String> {
        self.verify_forces(&forces)?;
        let motion = self.within_columns(&motion);
        // The remainder, which counts as zero, belongs to the fixed load.
        let rows = self.balance(&forces, &self.fixed);
        let fixed: Load = self.fixed.iter().zip(rows).map(|(load, (rest, _))| load - rest).collect();
        let (multiple, driving) = (forces[0], power(&motion, &self.columns[0].load));
        let bound = self.resisting_power(&motion, &fixed);
        let gap = (bound - multiple).abs() / multiple.max(1.0);
        if gap.is_nan() || gap > GAP || driving < 1.0 - GAP {
            return Err(format!(
                "the limit is {multiple:e} from forces, but {:e} from motion",
                bound / driving.min(1.0)
            ));
        }
        let rates = self.contact_edges().map(|index| power(&motion, &self.columns[index].load));
        match rates.fold(0.0, f64::min) {
            rate if rate >= -BACKWARD * size(&motion) => Ok(Optimum::Finite(ProgramLimit { forces, motion, gap })),
            rate => Err(format!("a contact force has negative power, {rate:e}")),
        }
    }

    /// Checks forces that balance a growing multiple: they have the admissible signs, and the remainder is rounding,
    /// with the largest rounding error of its own sum.
    fn verified_ray(&self, forces: &[f64], ray: &[f64]) -> std::result::Result<Optimum, String> {
        self.verify_forces(forces)?;
        let grows = |(change, Column { bounds: [lo, hi], .. }): (&f64, &Column)| {
            (*change >= 0.0 || lo.is_infinite()) && (*change <= 0.0 || hi.is_infinite())
        };
        if !(ray[0] > 0.0 && ray.iter().zip(&self.columns).all(grows)) {
            return Err("a growing force exceeds its bounds".to_string());
        }
        let error = 2.0 * (self.columns.len() + 2) as f64 * f64::EPSILON;
        let rows = self.balance(ray, &vec![0.0; self.fixed.len()]);
        let size = rows.iter().map(|(_, size)| *size).fold(0.0, f64::max);
        match rows.iter().map(|(sum, size)| sum.abs() + error * size).fold(0.0, f64::max) {
            rest if rest <= RAY_REMAINDER * size && rest <= RAY_SHARE * ray[0] => Ok(Optimum::Unbounded),
            rest => Err(format!("growing forces leave {rest:.1e} of {size:.1e} unbalanced")),
        }
    }

    /// Checks that all admissible forces without the driving load have positive power in a motion.
    fn verified_contradiction(&self, motion: Load) -> std::result::Result<Optimum, String> {
        let motion = self.within_columns(&motion);
        let unilateral = self.contact_edges().map(|index| power(&motion, &self.columns[index].load));
        let least = unilateral.fold(0.0, f64::min);
        let driving = -self.resisting_power(&motion, &self.fixed);
        match driving > 0.0 && least >= -BACKWARD * size(&motion) {
            true => Ok(Optimum::Infeasible { motion }),
            false => Err(format!("no motion shows that the forces cannot balance ({driving:.1e}, {least:.1e})")),
        }
    }

    /// Least power that resists a motion, without the unilateral forces.
    fn resisting_power(&self, motion: &[f64], fixed: &[f64]) -> f64 {
        let rounding = ROUNDING * size(motion);
        let brake_power = self.columns[self.torques()].iter().map(|Column { load, bounds: [lo, hi], .. }| {
            let rate = power(motion, load);
            let bound = if rate > 0.0 { *lo } else { *hi };
            // A blocked drive does not move and has no power.
            if bound.is_infinite() && rate.abs() <= rounding { 0.0 } else { -bound * rate }
        });
        brake_power.sum::<f64>() - power(motion, fixed)
    }

    /// Projects a motion onto the space of the loads: without friction, for instance, the rotation of a disc is
    /// arbitrary.
    fn within_columns(&self, motion: &[f64]) -> Load {
        let loads: Vec<&Load> = self.columns.iter().map(|column| &column.load).chain([&self.fixed]).collect();
        let svd = DMatrix::from_fn(motion.len(), loads.len(), |row, column| loads[column][row]).svd(true, false);
        let Some(u) = svd.u else { return motion.to_vec() };
        let largest = svd.singular_values.max();
        let kept: Vec<usize> =
            (0..svd.singular_values.len()).filter(|k| svd.singular_values[*k] > RANK_TOLERANCE * largest).collect();
        let basis = u.select_columns(&kept);
        let within = &basis * basis.tr_mul(&DVector::from_row_slice(motion));
        within.as_slice().to_vec()
    }
}

/// Largest entry.
pub(super) fn size(column: &[f64]) -> f64 {
    column.iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()))
}
