//! Refines the approximate solution of a linear programme: values close to a bound are set to it, and the others get
//! the smallest correction that satisfies the equations.

use nalgebra::{DMatrix, DVector};

use super::balance_program::{Bound, Forces, Program, power};
use super::loads::{Load, ROWS};

/// Distance from its bound (with fixed loads of about 1) within which a force counts as on it: ten times the tolerance
/// of the programme.
const ON_BOUND_TOLERANCE: f64 = 1e-6;

/// Singular values below this are zero (columns have size 1).
const RANK_TOLERANCE: f64 = 1e-9;

/// Rounding tolerance for a corrected force beyond its bound.
const BOUND_TOLERANCE: f64 = 1e-12;

/// Returns the minimum-norm least-squares solution x of A x = b.
fn least_squares(columns: &[Load], b: &Load) -> Option<DVector<f64>> {
    let matrix = DMatrix::from_fn(ROWS, columns.len(), |row, column| columns[column][row]);
    matrix.svd(true, true).solve(&DVector::from_row_slice(b), RANK_TOLERANCE).ok()
}

/// All variables of the programme with column, value and bounds: contact forces, then torques, then the multiple of the
/// driving load.
fn all_variables(program: &Program, forces: &Forces) -> Vec<(Load, f64, [f64; 2])> {
    let contact_edges = program.contact_edges.iter().zip(&forces.contact_edges);
    let contact_edges = contact_edges.map(|(column, force)| (*column, *force, [0.0, f64::INFINITY]));
    let bounded_torques = program.bounded_torques.iter().zip(&forces.bounded_torques);
    let bounded_torques = bounded_torques.map(|((column, bounds), torque)| (*column, *torque, *bounds));
    contact_edges.chain(bounded_torques).chain([(program.driving, forces.multiple, [0.0, f64::INFINITY])]).collect()
}

fn on_bound(value: f64, [lo, hi]: [f64; 2]) -> Option<f64> {
    [lo, hi].into_iter().find(|bound| (value - bound).abs() < ON_BOUND_TOLERANCE)
}

/// Forces in exact balance; the original ones if the correction would move one of them beyond its bound.
pub fn forces(program: &Program, found: Forces) -> Forces {
    let mut all_variables = all_variables(program, &found);
    all_variables.iter_mut().for_each(|(_, value, bounds)| *value = on_bound(*value, *bounds).unwrap_or(*value));
    let free: Vec<usize> =
        (0..all_variables.len()).filter(|&i| on_bound(all_variables[i].1, all_variables[i].2).is_none()).collect();
    let missing: Load = std::array::from_fn(|row| {
        -program.fixed[row] - all_variables.iter().map(|(column, value, _)| column[row] * value).sum::<f64>()
    });
    let columns: Vec<Load> = free.iter().map(|&i| all_variables[i].0).collect();
    if let Some(correction) = least_squares(&columns, &missing) {
        free.iter().zip(correction.iter()).for_each(|(&i, by)| all_variables[i].1 += by);
    }
    let within =
        |(_, value, [lo, hi]): &(Load, f64, [f64; 2])| *value >= lo - BOUND_TOLERANCE && *value <= hi + BOUND_TOLERANCE;
    if !all_variables.iter().all(within) {
        return found;
    }
    let values: Vec<f64> = all_variables.iter().map(|(_, value, _)| *value).collect();
    let (contact_edges, rest) = values.split_at(program.contact_edges.len());
    let (bounded_torques, driving) = rest.split_at(program.bounded_torques.len());
    Forces { multiple: driving[0], contact_edges: contact_edges.to_vec(), bounded_torques: bounded_torques.to_vec() }
}

/// Projects a motion onto the column space: without friction, for instance, the rotation of a disc is arbitrary.
fn project_onto_columns(columns: &[Load], motion: &Load) -> Load {
    let matrix = DMatrix::from_fn(ROWS, columns.len(), |row, column| columns[column][row]);
    let svd = matrix.svd(true, false);
    let Some(u) = svd.u else { return *motion };
    let rank = svd.singular_values.iter().filter(|value| **value > RANK_TOLERANCE * svd.singular_values.max()).count();
    let basis = u.columns(0, rank);
    let within = basis * basis.tr_mul(&DVector::from_row_slice(motion));
    std::array::from_fn(|row| within[row])
}

/// Returns the motion in which forces strictly within their bounds have exactly zero power, and the driving load has 1
/// W.
pub fn motion(program: &Program, forces: &Forces, found: Bound) -> Bound {
    let variables = all_variables(program, forces);
    let columns: Vec<Load> = variables.iter().map(|(column, ..)| *column).chain([program.fixed]).collect();
    let start = project_onto_columns(&columns, &found.motion);
    let (driving, inactive) =
        variables.split_last().map_or((program.driving, &variables[..]), |(last, rest)| (last.0, rest));
    let inactive =
        inactive.iter().filter(|(_, value, bounds)| on_bound(*value, *bounds).is_none()).map(|(column, ..)| *column);
    let mut rows: Vec<(Load, f64)> = inactive.map(|column| (column, 0.0)).collect();
    rows.push((driving, 1.0));
    let matrix = DMatrix::from_fn(rows.len(), ROWS, |i, j| rows[i].0[j]);
    let missing = DVector::from_fn(rows.len(), |i, _| rows[i].1 - power(&start, &rows[i].0));
    let Ok(correction) = matrix.svd(true, true).solve(&missing, RANK_TOLERANCE) else { return found };
    let motion: Load = std::array::from_fn(|row| start[row] + correction[row]);
    Bound { bound: program.resisting_power(&motion), motion }
}
