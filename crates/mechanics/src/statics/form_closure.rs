//! Form closure of an underactuated grasp (thesis §1.2.4.2, errata 12): U ω ≥ 0 only for ω = 0.
//!
//! Closed ⇔ U has full column rank and there are multipliers λ > 0 with Uᵀ λ = 0 (Stiemke's lemma). Both answers come with what
//! proves them, and the proof is checked by numbers after it was found:
//! * not closed: a motion ω ≠ 0 with U ω ≥ 0;
//! * closed: the rank and the multipliers. They are forces in balance: of a gripper of two fingers, contact forces, palm force
//!   and motor torques of the grasp without springs and without friction.
//!
//! Two linear programmes decide in general. They cost 60 to 190 µs for two fingers; a system of full rank with one row more
//! than unknowns, which that is, has a single vector of multipliers up to a factor, so their signs decide in 3 µs, U and
//! certificate included. A test holds one to the other.

use nalgebra::{DMatrix, DVector};

use super::linear::{Scaled, basis, beside, orthogonal, scaled, solve};
use super::{Hand, Kind, NecessaryCount, Row, StaticsError, Unilateral, Unknown, program, unilateral};
use crate::gripper::{FinalPosture, Finger};

/// Smallest over largest multiplier (rows and unknowns scaled alike) from which on a grasp counts as closed. Nearer to the
/// boundary than this, rounding decides, and a motion violates no constraint by more than it: that grasp is not closed.
pub const BOUNDARY: f64 = 1e-9;

/// The programme of the motion opens some row by 1 if any can open: below this, none can.
const NOTHING: f64 = 1e-6;

/// What a certificate may be off by, relative to what it weighs.
const RESIDUAL: f64 = 1e-9;

/// Speeds below this part of the largest are rounding, and reported as 0.
const ROUNDING: f64 = 1e-13;

/// Whether a grasp is form-closed, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct FormClosure<R = Row> {
    pub closed: bool,
    pub certificate: Certificate,
    /// What the rows and columns of U are.
    pub rows: Vec<R>,
    pub unknowns: Vec<Unknown>,
    /// Rank of U; full if it is the number of unknowns.
    pub rank: usize,
    pub necessary: NecessaryCount,
    /// Smallest over largest multiplier where these are unique: how far within (or, negative, outside) the boundary.
    pub margin: Option<f64>,
    pub decision: Decision,
}

impl<R> FormClosure<R> {
    /// The same with its constraints by other names.
    pub fn named<S>(self, name: impl Fn(R) -> S) -> FormClosure<S> {
        let FormClosure { closed, certificate, rows, unknowns, rank, necessary, margin, decision } = self;
        let rows = rows.into_iter().map(name).collect();
        FormClosure { closed, certificate, rows, unknowns, rank, necessary, margin, decision }
    }
}

/// How it was decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// U does not determine the motion.
    Rank,
    /// By the signs of the only multipliers.
    Signs,
    /// By linear programmes.
    Programme,
}

/// What proves the answer. Values are in SI, one for each row or unknown.
#[derive(Clone, Debug, PartialEq)]
pub enum Certificate {
    /// Closed: λ > 0 with Uᵀ λ = 0. In N for contacts and palm and in N·m for motors, of which the first has 1 N·m (without
    /// motors the largest is 1 N). `residual` is |Uᵀ λ| relative to λ, rows and unknowns scaled alike.
    Multipliers { values: Vec<f64>, residual: f64 },
    /// Not closed: ω with U ω ≥ 0, the object at 1 mm/s (or, if it stays, the fastest joint at 1 rad/s), and the rates U ω.
    /// `residual` is the worst violation of a row, rows and unknowns scaled alike, relative to ω.
    Motion { values: Vec<f64>, rates: Vec<f64>, residual: f64 },
}

/// Form closure of a finger, its mirror image and the palm, both motors not to be turned back.
///
/// # Errors
/// The singular postures of [`at_rest`](super::at_rest); a grasp so near to the boundary that nothing can be proven.
pub fn form_closure(finger: &Finger, end: &FinalPosture) -> Result<FormClosure, StaticsError> {
    decide(&unilateral(&Hand::symmetric(finger, end))?)
}

/// Form closure of any set of constraints.
///
/// # Errors
/// A set so near to the boundary that nothing can be proven.
pub fn decide<R: Copy + Into<Kind>>(u: &Unilateral<R>) -> Result<FormClosure<R>, StaticsError> {
    let scaled = scaled(u);
    let (m, n) = scaled.matrix.shape();
    let columns = basis(&scaled.matrix);
    if columns.ncols() < n {
        return unhindered(u, &scaled, columns.ncols());
    }
    if m != n + 1 {
        return by_program(u, &scaled, &columns);
    }
    let mut lambda = orthogonal(&columns);
    if lambda.sum() < 0.0 {
        lambda.neg_mut();
    }
    let margin = lambda.min() / lambda.amax();
    if margin > BOUNDARY {
        return closed(u, &scaled, &lambda, Decision::Signs);
    }
    let separations = separations(&lambda, &u.rows);
    let motion = solve(&scaled.matrix, &separations).unwrap_or_else(|| DVector::zeros(n));
    free(u, &scaled, n, &motion, Decision::Signs, Some(margin))
}

/// The same, always by linear programmes.
///
/// # Errors
/// See [`decide`]; and a programme without an answer.
pub fn decide_by_program<R: Copy + Into<Kind>>(u: &Unilateral<R>) -> Result<FormClosure<R>, StaticsError> {
    let scaled = scaled(u);
    let columns = basis(&scaled.matrix);
    match columns.ncols() < u.unknowns.len() {
        true => unhindered(u, &scaled, columns.ncols()),
        false => by_program(u, &scaled, &columns),
    }
}

/// A motion that no row notices.
fn unhindered<R: Copy + Into<Kind>>(
    u: &Unilateral<R>,
    scaled: &Scaled,
    rank: usize,
) -> Result<FormClosure<R>, StaticsError> {
    let motion = orthogonal(&basis(&scaled.matrix.transpose()));
    free(u, scaled, rank, &motion, Decision::Rank, None)
}

/// The motion first: a programme without a solution, as that of the multipliers mostly is, costs several times as much.
fn by_program<R: Copy + Into<Kind>>(
    u: &Unilateral<R>,
    scaled: &Scaled,
    columns: &DMatrix<f64>,
) -> Result<FormClosure<R>, StaticsError> {
    let rank = columns.ncols();
    let Some(found) = program::motion(&scaled.matrix)? else {
        return Err(StaticsError::Program { reason: "no motion, not even rest, is allowed".to_string() });
    };
    let rates = &scaled.matrix * &found;
    if rates.amax() < NOTHING
        && let Some(lambda) = program::multipliers(&scaled.matrix)?
    {
        // What the programme left over is taken off.
        let lambda = beside(columns, &lambda);
        if lambda.min() > BOUNDARY * lambda.amax() {
            return closed(u, scaled, &lambda, Decision::Programme);
        }
    }
    // Rows that hardly move are held exactly.
    let held: Vec<usize> = (0..rates.len()).filter(|&i| rates[i] < 1e-6 * rates.amax()).collect();
    let motion = beside(&basis(&scaled.matrix.select_rows(&held).transpose()), &found);
    free(u, scaled, rank, &motion, Decision::Programme, None)
}

/// s ≥ 0 with λ·s = 0 for multipliers that are not all positive. Rows of one kind move alike, so that a symmetric gripper moves
/// symmetrically, and motors that advance are preferred: what the motors do by themselves is the motion to fear most.
fn separations<R: Copy + Into<Kind>>(lambda: &DVector<f64>, rows: &[R]) -> DVector<f64> {
    let order = [Kind::Motor, Kind::Palm, Kind::Distal, Kind::Proximal];
    let none = BOUNDARY * lambda.amax();
    let first = |wanted: &dyn Fn(f64) -> bool| -> Vec<usize> {
        let of = |kind| (0..rows.len()).filter(|&i| rows[i].into() == kind && wanted(lambda[i])).collect::<Vec<_>>();
        order.into_iter().map(of).find(|found| !found.is_empty()).unwrap_or_default()
    };
    let (up, down, idle) = (first(&|l| l > none), first(&|l| l < -none), first(&|l| l.abs() <= none));
    let mut s = DVector::zeros(rows.len());
    if down.is_empty() || up.is_empty() {
        // On the boundary: rows without a multiplier may move by themselves.
        idle.into_iter().for_each(|i| s[i] = 1.0);
        return s;
    }
    for group in [up, down] {
        group.iter().for_each(|&i| s[i] = 1.0 / (lambda[i].abs() * group.len() as f64));
    }
    s
}

/// Checks and reports multipliers.
fn closed<R: Copy + Into<Kind>>(
    u: &Unilateral<R>,
    scaled: &Scaled,
    lambda: &DVector<f64>,
    decision: Decision,
) -> Result<FormClosure<R>, StaticsError> {
    let residual = scaled.matrix.tr_mul(lambda).amax() / lambda.amax();
    if residual.is_nan() || residual > RESIDUAL {
        return Err(StaticsError::Undecided { motion_residual: f64::NAN, multiplier_residual: residual });
    }
    // Rows were divided by their lengths, so multipliers are too.
    let physical: Vec<f64> = lambda.iter().zip(&scaled.norms).map(|(l, norm)| l / norm).collect();
    let motor = u.rows.iter().position(|&row| row.into() == Kind::Motor);
    let unit = motor.map_or(physical.iter().copied().fold(0.0, f64::max), |i| physical[i]);
    Ok(FormClosure {
        closed: true,
        certificate: Certificate::Multipliers { values: physical.iter().map(|l| l / unit).collect(), residual },
        rows: u.rows.clone(),
        unknowns: u.unknowns.clone(),
        rank: u.unknowns.len(),
        necessary: u.necessary_count(),
        margin: Some(lambda.min() / lambda.amax()),
        decision,
    })
}

/// Checks and reports a motion.
fn free<R: Copy + Into<Kind>>(
    u: &Unilateral<R>,
    scaled: &Scaled,
    rank: usize,
    motion: &DVector<f64>,
    decision: Decision,
    margin: Option<f64>,
) -> Result<FormClosure<R>, StaticsError> {
    let size = motion.amax();
    let clean = |v: f64| if v.abs() <= ROUNDING * size { 0.0 } else { v };
    let motion = motion.map(clean);
    let rates = &scaled.matrix * &motion;
    // A system without rows has no rate that could be too low.
    let residual = rates.iter().fold(0.0, |worst: f64, rate| worst.max(-rate)) / size;
    if !(residual <= RESIDUAL && size > 0.0) {
        return Err(StaticsError::Undecided { motion_residual: residual, multiplier_residual: f64::NAN });
    }
    let rates: Vec<f64> = rates.iter().zip(&scaled.norms).map(|(&rate, norm)| clean(rate) * norm).collect();
    let values: Vec<f64> = motion.iter().zip(&u.scale).map(|(w, scale)| w / scale).collect();
    let object = u.unknowns.iter().zip(&values).filter(|(k, _)| matches!(k, Unknown::ObjectX | Unknown::ObjectY));
    let speed = object.map(|(_, v)| v * v).sum::<f64>().sqrt();
    let unit = match speed > RESIDUAL * size {
        true => speed * 1e3,
        false => values.iter().fold(0.0, |most: f64, v| most.max(v.abs())),
    };
    let per_unit = |values: Vec<f64>| -> Vec<f64> { values.iter().map(|v| v / unit).collect() };
    Ok(FormClosure {
        closed: false,
        certificate: Certificate::Motion { values: per_unit(values), rates: per_unit(rates), residual },
        rows: u.rows.clone(),
        unknowns: u.unknowns.clone(),
        rank,
        necessary: u.necessary_count(),
        margin,
        decision,
    })
}
