//! Form closure of an underactuated grasp (thesis §1.2.4.2, errata 12): U ω ≥ 0 only for ω = 0.
//!
//! Closed ⇔ U has full column rank and there are multipliers λ > 0 with Uᵀ λ = 0 (Stiemke's lemma). Either result has a
//! certificate, which is verified numerically:
//! * not closed: a motion ω ≠ 0 with U ω ≥ 0;
//! * closed: the rank and the multipliers, which are balanced forces: for a gripper with two fingers, the contact
//!   forces, palm force and motor torques of the grasp without springs and without friction.
//!
//! In general, two linear programmes decide between them; this takes 60 to 190 µs for two fingers. If U has full rank
//! and one row more than unknowns, as for two fingers with a palm, the multipliers are unique up to a factor, and their
//! signs decide; this takes 3 µs, including U and the certificate. A test compares both methods.

use nalgebra::{DMatrix, DVector};

use super::linear::{self, Scaled, basis, orthogonal, orthogonal_component, scale_constraints, solve};
use super::{
    Blocked, GraspConfiguration, Hand, NecessaryCount, PerContact, Row, RowKind, StaticsError, Unilateral, Unknown,
    gripper_unilateral, unilateral,
};
use crate::gripper::{FinalPosture, Finger};

/// Ratio of the smallest to the largest multiplier (of normalised rows and unknowns) above which a grasp counts as
/// closed. At smaller ratios rounding dominates, and there is a motion that violates no constraint by more than this
/// value; such a grasp counts as not closed.
pub const BOUNDARY: f64 = 1e-9;

/// The programme of the motion separates some row at rate 1 if any can separate; rates below this mean that none can.
const MIN_RATE: f64 = 1e-6;

/// Largest relative residual of a certificate.
const MAX_RESIDUAL: f64 = 1e-9;

/// Speeds below this fraction of the largest are rounding and reported as 0.
const ROUNDING_RATIO: f64 = 1e-13;

/// Result of a form-closure analysis.
#[derive(Clone, Debug, PartialEq)]
pub struct FormClosure {
    pub closed: bool,
    pub certificate: Certificate,
    /// Meaning of the rows of U.
    pub rows: Vec<Row>,
    /// Meaning of the columns of U.
    pub unknowns: Vec<Unknown>,
    /// Rank of U; full if it is the number of unknowns.
    pub rank: usize,
    pub necessary: NecessaryCount,
    /// Ratio of the smallest to the largest multiplier if they are unique: distance from the boundary, negative
    /// outside.
    pub margin: Option<f64>,
    pub decision: Decision,
}

/// Method of the decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Rank of U: U does not determine the motion.
    Rank,
    /// Signs of the unique multipliers.
    Signs,
    /// Linear programmes.
    Programme,
}

/// Certificate of the result. Values are in SI units, one for each row or unknown.
#[derive(Clone, Debug, PartialEq)]
pub enum Certificate {
    /// Closed: λ > 0 with Uᵀ λ = 0, in N for contacts and palm and in N·m for motors, normalised to 1 N·m of the first
    /// motor (without motors, to a largest value of 1 N). `residual` is |Uᵀ λ| relative to λ, for normalised rows and
    /// unknowns.
    Multipliers { values: Vec<f64>, residual: f64 },
    /// Not closed: ω with U ω ≥ 0, normalised to an object speed of 1 mm/s (if the object is at rest, to 1 rad/s of the
    /// fastest joint), and the rates U ω. `residual` is the largest violation of a row relative to ω, for normalised
    /// rows and unknowns.
    Motion { values: Vec<f64>, rates: Vec<f64>, residual: f64 },
}

/// Form closure of a finger, its mirror image and the palm, with both motors not back-drivable.
///
/// # Errors
/// Returns an error for the singular postures of [`static_kinematics`](super::static_kinematics), and if the grasp is
/// so close to the boundary that no certificate exists.
pub fn form_closure(finger: &Finger, end: &FinalPosture) -> Result<FormClosure, StaticsError> {
    decide_form_closure(&unilateral(&Hand::symmetric(finger, end))?)
}

/// Form closure of any set of constraints.
///
/// # Errors
/// Returns an error if the set is so close to the boundary that no certificate exists.
pub fn decide_form_closure(u: &Unilateral) -> Result<FormClosure, StaticsError> {
    let scaled = scale_constraints(u);
    let (m, n) = scaled.matrix.shape();
    let columns = basis(&scaled.matrix);
    if columns.ncols() < n {
        return report_undetermined_motion(u, &scaled, columns.ncols());
    }
    if m != n + 1 {
        return solve_linear_program(u, &scaled, &columns);
    }
    let mut lambda = orthogonal(&columns);
    if lambda.sum() < 0.0 {
        lambda.neg_mut();
    }
    let margin = lambda.min() / lambda.amax();
    if margin > BOUNDARY {
        return report_multipliers(u, &scaled, &lambda, Decision::Signs);
    }
    let separations = separations(&lambda, &u.rows);
    let motion = solve(&scaled.matrix, &separations).unwrap_or_else(|| DVector::zeros(n));
    report_motion(u, &scaled, n, &motion, Decision::Signs, Some(margin))
}

/// Decides form closure of a posture, provided that blocked drives are not back-driven, with a certificate.
///
/// # Errors
/// See [`gripper_unilateral`]; also returns an error if the grasp is so close to the boundary that no certificate
/// exists.
pub fn gripper_closure(
    configuration: &GraspConfiguration<'_>,
    active_contacts: &PerContact<bool>,
    blocked: Blocked,
) -> Result<FormClosure, StaticsError> {
    decide_form_closure(&gripper_unilateral(configuration, active_contacts, blocked)?)
}

/// [`decide_form_closure`], always by linear programmes.
///
/// # Errors
/// See [`decide_form_closure`]; also returns an error if the linear programme has no solution.
pub fn decide_by_linear_program(u: &Unilateral) -> Result<FormClosure, StaticsError> {
    let scaled = scale_constraints(u);
    let columns = basis(&scaled.matrix);
    match columns.ncols() < u.unknowns.len() {
        true => report_undetermined_motion(u, &scaled, columns.ncols()),
        false => solve_linear_program(u, &scaled, &columns),
    }
}

/// Reports a motion that leaves all rows at zero.
fn report_undetermined_motion(u: &Unilateral, scaled: &Scaled, rank: usize) -> Result<FormClosure, StaticsError> {
    let motion = orthogonal(&basis(&scaled.matrix.transpose()));
    report_motion(u, scaled, rank, &motion, Decision::Rank, None)
}

/// Solves the programme of the motion first: an infeasible programme, as the programme of the multipliers mostly is,
/// costs several times as much.
fn solve_linear_program(u: &Unilateral, scaled: &Scaled, columns: &DMatrix<f64>) -> Result<FormClosure, StaticsError> {
    let rank = columns.ncols();
    let Some(found) = linear::motion(&scaled.matrix)? else {
        return Err(StaticsError::Program { reason: "no motion is feasible, not even rest".to_string() });
    };
    let rates = &scaled.matrix * &found;
    if rates.amax() < MIN_RATE
        && let Some(lambda) = linear::multipliers(&scaled.matrix)?
    {
        // Remove the residual of the programme.
        let lambda = orthogonal_component(columns, &lambda);
        if lambda.min() > BOUNDARY * lambda.amax() {
            return report_multipliers(u, scaled, &lambda, Decision::Programme);
        }
    }
    // Rows with negligible rates are set to exactly zero.
    let resting_rows: Vec<usize> = (0..rates.len()).filter(|&i| rates[i] < 1e-6 * rates.amax()).collect();
    let motion = orthogonal_component(&basis(&scaled.matrix.select_rows(&resting_rows).transpose()), &found);
    report_motion(u, scaled, rank, &motion, Decision::Programme, None)
}

/// s ≥ 0 with λ·s = 0 for multipliers that are not all positive. Rows of one kind get equal rates, so that a symmetric
/// gripper moves symmetrically. Motions with advancing motors are preferred: these occur without external disturbance.
fn separations(lambda: &DVector<f64>, rows: &[Row]) -> DVector<f64> {
    let order = [RowKind::Motor, RowKind::Palm, RowKind::Distal, RowKind::Proximal];
    let none = BOUNDARY * lambda.amax();
    let first = |selects: &dyn Fn(f64) -> bool| -> Vec<usize> {
        let rows_of = |kind| {
            (0..rows.len()).filter(|&i| RowKind::from(rows[i]) == kind && selects(lambda[i])).collect::<Vec<_>>()
        };
        order.into_iter().map(rows_of).find(|found| !found.is_empty()).unwrap_or_default()
    };
    let (up, down, idle) = (first(&|l| l > none), first(&|l| l < -none), first(&|l| l.abs() <= none));
    let mut s = DVector::zeros(rows.len());
    if down.is_empty() || up.is_empty() {
        // On the boundary: rows with a zero multiplier may move independently.
        idle.into_iter().for_each(|i| s[i] = 1.0);
        return s;
    }
    for group in [up, down] {
        group.iter().for_each(|&i| s[i] = 1.0 / (lambda[i].abs() * group.len() as f64));
    }
    s
}

/// Checks the multipliers that exclude a free motion, and returns them as form closure.
fn report_multipliers(
    u: &Unilateral,
    scaled: &Scaled,
    lambda: &DVector<f64>,
    decision: Decision,
) -> Result<FormClosure, StaticsError> {
    let residual = scaled.matrix.tr_mul(lambda).amax() / lambda.amax();
    if residual.is_nan() || residual > MAX_RESIDUAL {
        return Err(StaticsError::Undecided { motion_residual: f64::NAN, multiplier_residual: residual });
    }
    // Rows were divided by their lengths, so the multipliers are, too.
    let unscaled: Vec<f64> = lambda.iter().zip(&scaled.norms).map(|(l, norm)| l / norm).collect();
    let motor = u.rows.iter().position(|&row| RowKind::from(row) == RowKind::Motor);
    let unit = motor.map_or(unscaled.iter().copied().fold(0.0, f64::max), |i| unscaled[i]);
    let certificate = Certificate::Multipliers { values: unscaled.iter().map(|l| l / unit).collect(), residual };
    Ok(report(u, certificate, u.unknowns.len(), Some(lambda.min() / lambda.amax()), decision))
}

/// Checks and reports a motion.
fn report_motion(
    u: &Unilateral,
    scaled: &Scaled,
    rank: usize,
    motion: &DVector<f64>,
    decision: Decision,
    margin: Option<f64>,
) -> Result<FormClosure, StaticsError> {
    let size = motion.amax();
    let clear_rounding = |v: f64| if v.abs() <= ROUNDING_RATIO * size { 0.0 } else { v };
    let motion = motion.map(clear_rounding);
    let rates = &scaled.matrix * &motion;
    // Without rows there is no violation.
    let residual = rates.iter().fold(0.0, |worst: f64, rate| worst.max(-rate)) / size;
    if !(residual <= MAX_RESIDUAL && size > 0.0) {
        return Err(StaticsError::Undecided { motion_residual: residual, multiplier_residual: f64::NAN });
    }
    let rates: Vec<f64> = rates.iter().zip(&scaled.norms).map(|(&rate, norm)| clear_rounding(rate) * norm).collect();
    let values: Vec<f64> = motion.iter().zip(&u.scale).map(|(w, scale)| w / scale).collect();
    let object = u.unknowns.iter().zip(&values).filter(|(k, _)| matches!(k, Unknown::ObjectX | Unknown::ObjectY));
    let speed = object.map(|(_, v)| v * v).sum::<f64>().sqrt();
    let unit = match speed > MAX_RESIDUAL * size {
        true => speed * 1e3,
        false => values.iter().fold(0.0, |most: f64, v| most.max(v.abs())),
    };
    let per_unit = |values: Vec<f64>| -> Vec<f64> { values.iter().map(|v| v / unit).collect() };
    let certificate = Certificate::Motion { values: per_unit(values), rates: per_unit(rates), residual };
    Ok(report(u, certificate, rank, margin, decision))
}

fn report(
    u: &Unilateral,
    certificate: Certificate,
    rank: usize,
    margin: Option<f64>,
    decision: Decision,
) -> FormClosure {
    FormClosure {
        closed: matches!(certificate, Certificate::Multipliers { .. }),
        certificate,
        rows: u.rows.clone(),
        unknowns: u.unknowns.clone(),
        rank,
        necessary: u.necessary_count(),
        margin,
        decision,
    }
}
