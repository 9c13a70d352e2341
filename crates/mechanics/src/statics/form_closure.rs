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

use super::simplex::{LinearProgram, Outcome, Rule};
use super::{
    Blocked, GraspConfiguration, Hand, NecessaryCount, PerContact, Result, Row, RowKind, StaticsError, Unilateral,
    Unknown, gripper_unilateral, unilateral,
};
use crate::gripper::{FinalPosture, Finger};
use nalgebra::{DMatrix, DVector};

/// Boundary of form closure: a grasp counts as closed if the ratio of the smallest to the largest multiplier (of
/// normalised rows and unknowns) is larger. At smaller ratios rounding errors dominate: a motion exists that violates
/// no constraint by more than this value.
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
    /// Ratio of the smallest to the largest multiplier, a measure of the distance from the boundary of form closure;
    /// negative outside. `None` if there are no unique multipliers.
    pub margin: Option<f64>,
    pub decision: Decision,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Rank of U: U does not determine the motion.
    Rank,
    /// Signs of the unique multipliers.
    Signs,
    Programme,
}

/// Certificate of the result: one value in SI units for each row or unknown.
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
pub fn form_closure(finger: &Finger, end: &FinalPosture) -> Result<FormClosure> {
    decide_form_closure(&unilateral(&Hand::symmetric(finger, end))?)
}

/// Form closure of any set of constraints.
pub fn decide_form_closure(u: &Unilateral) -> Result<FormClosure> {
    if u.unknowns.is_empty() {
        return Ok(report_nothing_moves(u));
    }
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

/// Decides form closure of a posture, with a certificate. Blocked drives are assumed not to be back-driven.
pub fn gripper_closure(
    configuration: &GraspConfiguration<'_>,
    active_contacts: &PerContact<bool>,
    blocked: Blocked,
) -> Result<FormClosure> {
    decide_form_closure(&gripper_unilateral(configuration, active_contacts, blocked)?)
}

/// Like [`decide_form_closure`], but always uses linear programmes.
pub fn decide_by_linear_program(u: &Unilateral) -> Result<FormClosure> {
    if u.unknowns.is_empty() {
        return Ok(report_nothing_moves(u));
    }
    let scaled = scale_constraints(u);
    let columns = basis(&scaled.matrix);
    match columns.ncols() < u.unknowns.len() {
        true => report_undetermined_motion(u, &scaled, columns.ncols()),
        false => solve_linear_program(u, &scaled, &columns),
    }
}

/// Without unknowns there is no motion, and any multipliers prove it.
fn report_nothing_moves(u: &Unilateral) -> FormClosure {
    let certificate = Certificate::Multipliers { values: vec![1.0; u.rows.len()], residual: 0.0 };
    report(u, certificate, 0, None, Decision::Rank)
}

/// Reports a motion that leaves all rows at zero.
fn report_undetermined_motion(u: &Unilateral, scaled: &Scaled, rank: usize) -> Result<FormClosure> {
    let motion = orthogonal(&basis(&scaled.matrix.transpose()));
    report_motion(u, scaled, rank, &motion, Decision::Rank, None)
}

/// Solves the programme of the motion first: that of the multipliers is mostly infeasible, which costs more.
fn solve_linear_program(u: &Unilateral, scaled: &Scaled, columns: &DMatrix<f64>) -> Result<FormClosure> {
    let rank = columns.ncols();
    let Some(found) = motion(&scaled.matrix)? else {
        return Err(StaticsError::Program { reason: "no motion is feasible, not even rest".to_string() });
    };
    let rates = &scaled.matrix * &found;
    if rates.amax() < MIN_RATE
        && let Some(lambda) = multipliers(&scaled.matrix)?
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
    let order = [RowKind::Motor, RowKind::Palm, RowKind::Distal, RowKind::Proximal, RowKind::Constraint];
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
fn report_multipliers(u: &Unilateral, scaled: &Scaled, lambda: &DVector<f64>, by: Decision) -> Result<FormClosure> {
    let residual = scaled.matrix.tr_mul(lambda).amax() / lambda.amax();
    if residual.is_nan() || residual > MAX_RESIDUAL {
        return Err(undecided("the multipliers that exclude a free motion", residual));
    }
    // Rows were divided by their lengths, so the multipliers are, too.
    let unscaled: Vec<f64> = lambda.iter().zip(&scaled.norms).map(|(l, norm)| l / norm).collect();
    let motor = u.rows.iter().position(|&row| RowKind::from(row) == RowKind::Motor);
    let unit = motor.map_or(unscaled.iter().copied().fold(0.0, f64::max), |i| unscaled[i]);
    let certificate = Certificate::Multipliers { values: unscaled.iter().map(|l| l / unit).collect(), residual };
    Ok(report(u, certificate, u.unknowns.len(), Some(lambda.min() / lambda.amax()), by))
}

fn undecided(certificate: &'static str, residual: f64) -> StaticsError {
    match residual.is_nan() {
        true => StaticsError::Program { reason: "the posture is not a number".to_string() },
        false => StaticsError::Undecided { certificate, residual },
    }
}

fn report_motion(
    u: &Unilateral,
    scaled: &Scaled,
    rank: usize,
    motion: &DVector<f64>,
    decision: Decision,
    margin: Option<f64>,
) -> Result<FormClosure> {
    let size = motion.amax();
    if size == 0.0 {
        return Err(StaticsError::NeitherMotionNorMultipliers);
    }
    let clear_rounding = |v: f64| if v.abs() <= ROUNDING_RATIO * size { 0.0 } else { v };
    let motion = motion.map(clear_rounding);
    let rates = &scaled.matrix * &motion;
    // Without rows there is no violation.
    let residual = rates.iter().fold(0.0, |worst: f64, rate| worst.max(-rate)) / size;
    if residual.is_nan() || residual > MAX_RESIDUAL {
        return Err(undecided("the free motion", residual));
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

fn report(u: &Unilateral, proof: Certificate, rank: usize, margin: Option<f64>, decision: Decision) -> FormClosure {
    FormClosure {
        closed: matches!(proof, Certificate::Multipliers { .. }),
        certificate: proof,
        rows: u.rows.clone(),
        unknowns: u.unknowns.clone(),
        rank,
        necessary: u.necessary_count(),
        margin,
        decision,
    }
}

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

/// Returns an orthonormal basis of the column space; its vectors are the columns of the result.
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

/// Returns ω with A ω = s. A has full column rank, and s is in its column space.
pub fn solve(matrix: &DMatrix<f64>, s: &DVector<f64>) -> Option<DVector<f64>> {
    let qr = matrix.clone().qr();
    qr.r().solve_upper_triangular(&qr.q().tr_mul(s))
}

/// Returns the multipliers λ ≥ 1 with Aᵀ λ = 0 that have the smallest sum; `None` if there are no such multipliers.
///
/// If they exist, A ω ≥ 0 implies A ω = 0, since λ·A ω = 0 has no negative terms.
pub fn multipliers(matrix: &DMatrix<f64>) -> Result<Option<DVector<f64>>> {
    let (m, n) = matrix.shape();
    let programme = LinearProgram {
        matrix: matrix.transpose(),
        right: DVector::zeros(n),
        bounds: vec![[1.0, f64::INFINITY]; m],
        objective: vec![-1.0; m],
    };
    Ok(optimum(&programme)?.map(DVector::from_vec))
}

/// Returns the motion ω with the largest sum of separation rates A ω, subject to 0 ≤ A ω ≤ 1.
pub fn motion(matrix: &DMatrix<f64>) -> Result<Option<DVector<f64>>> {
    let (m, n) = matrix.shape();
    // A ω − s = 0.
    let entry = |i: usize, j: usize| {
        if j < n {
            matrix[(i, j)]
        } else if j - n == i {
            -1.0
        } else {
            0.0
        }
    };
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let programme = LinearProgram {
        matrix: DMatrix::from_fn(m, n + m, entry),
        right: DVector::zeros(m),
        bounds: (0..n + m).map(|j| if j < n { free } else { [0.0, 1.0] }).collect(),
        objective: (0..n + m).map(|j| if j < n { 0.0 } else { 1.0 }).collect(),
    };
    Ok(optimum(&programme)?.map(|x| DVector::from_column_slice(&x[..n])))
}

/// Optimum of a bounded programme; `None` if it is infeasible.
fn optimum(programme: &LinearProgram) -> Result<Option<Vec<f64>>> {
    for rule in [Rule::Steepest, Rule::First] {
        match programme.solve(rule) {
            Some(Outcome::Optimal { x, .. }) => return Ok(Some(x)),
            Some(Outcome::Infeasible { .. }) => return Ok(None),
            Some(Outcome::Unbounded { .. }) | None => {}
        }
    }
    Err(StaticsError::Program { reason: "the method does not end".to_string() })
}
