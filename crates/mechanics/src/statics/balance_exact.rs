//! What a programme found to its tolerance, exactly: what is on a bound is put there, and the rest moved as little as closes the equations.

use nalgebra::{DMatrix, DVector};

use super::balance_program::{Bound, Forces, Program, weigh};
use super::loads::{Load, ROWS};

/// Nearer to its bound than this (what is fixed being about 1) a force is on it: ten times what the programme may be off by.
const ON_BOUND: f64 = 1e-6;

/// Singular values below this part of a column's size are none.
const RANK: f64 = 1e-9;

/// What a corrected force may be beyond its bound by: rounding.
const BEYOND: f64 = 1e-12;

/// The least x with A x = b, or as near to it as can be.
fn least(columns: &[Load], b: &Load) -> Option<DVector<f64>> {
    let matrix = DMatrix::from_fn(ROWS, columns.len(), |row, column| columns[column][row]);
    matrix.svd(true, true).solve(&DVector::from_row_slice(b), RANK).ok()
}

/// Columns of all forces, then of all torques, then of the driving load; each with its value and its bounds.
fn all(program: &Program, forces: &Forces) -> Vec<(Load, f64, [f64; 2])> {
    let pressing = program.pressing.iter().zip(&forces.pressing);
    let pressing = pressing.map(|(column, force)| (*column, *force, [0.0, f64::INFINITY]));
    let bounded = program.bounded.iter().zip(&forces.bounded);
    let bounded = bounded.map(|((column, bounds), torque)| (*column, *torque, *bounds));
    pressing.chain(bounded).chain([(program.driving, forces.multiple, [0.0, f64::INFINITY])]).collect()
}

fn on_bound(value: f64, [lo, hi]: [f64; 2]) -> Option<f64> {
    [lo, hi].into_iter().find(|bound| (value - bound).abs() < ON_BOUND)
}

/// Forces in exact balance; those that were found where that takes one of them beyond its bound.
pub fn forces(program: &Program, found: Forces) -> Forces {
    let mut all = all(program, &found);
    all.iter_mut().for_each(|(_, value, bounds)| *value = on_bound(*value, *bounds).unwrap_or(*value));
    let free: Vec<usize> = (0..all.len()).filter(|&i| on_bound(all[i].1, all[i].2).is_none()).collect();
    let missing: Load = std::array::from_fn(|row| {
        -program.fixed[row] - all.iter().map(|(column, value, _)| column[row] * value).sum::<f64>()
    });
    let columns: Vec<Load> = free.iter().map(|&i| all[i].0).collect();
    if let Some(correction) = least(&columns, &missing) {
        free.iter().zip(correction.iter()).for_each(|(&i, by)| all[i].1 += by);
    }
    let within = |(_, value, [lo, hi]): &(Load, f64, [f64; 2])| *value >= lo - BEYOND && *value <= hi + BEYOND;
    if !all.iter().all(within) {
        return found;
    }
    let values: Vec<f64> = all.iter().map(|(_, value, _)| *value).collect();
    let (pressing, rest) = values.split_at(program.pressing.len());
    let (bounded, driving) = rest.split_at(program.bounded.len());
    Forces { multiple: driving[0], pressing: pressing.to_vec(), bounded: bounded.to_vec() }
}

/// What of a motion some column notices: without friction a disc may turn as fast as it likes.
fn noticed(columns: &[Load], motion: &Load) -> Load {
    let matrix = DMatrix::from_fn(ROWS, columns.len(), |row, column| columns[column][row]);
    let svd = matrix.svd(true, false);
    let Some(u) = svd.u else { return *motion };
    let rank = svd.singular_values.iter().filter(|value| **value > RANK * svd.singular_values.max()).count();
    let basis = u.columns(0, rank);
    let within = basis * basis.tr_mul(&DVector::from_row_slice(motion));
    std::array::from_fn(|row| within[row])
}

/// The motion in which exactly no force takes part that is within its bounds, and the driving load does 1 W.
pub fn motion(program: &Program, forces: &Forces, found: Bound) -> Bound {
    let every = all(program, forces);
    let columns: Vec<Load> = every.iter().map(|(column, ..)| *column).chain([program.fixed]).collect();
    let start = noticed(&columns, &found.motion);
    let (driving, idle) = every.split_last().map_or((program.driving, &every[..]), |(last, rest)| (last.0, rest));
    let idle = idle.iter().filter(|(_, value, bounds)| on_bound(*value, *bounds).is_none()).map(|(column, ..)| *column);
    let mut rows: Vec<(Load, f64)> = idle.map(|column| (column, 0.0)).collect();
    rows.push((driving, 1.0));
    let matrix = DMatrix::from_fn(rows.len(), ROWS, |i, j| rows[i].0[j]);
    let missing = DVector::from_fn(rows.len(), |i, _| rows[i].1 - weigh(&start, &rows[i].0));
    let Ok(correction) = matrix.svd(true, true).solve(&missing, RANK) else { return found };
    let motion: Load = std::array::from_fn(|row| start[row] + correction[row]);
    Bound { bound: program.resists(&motion), motion }
}
