//! Unilateral constraints on a motion of the grasp, of one finger and its mirror image or of a whole gripper: U of
//! (1.18), row by row.

use super::posture::static_kinematics_at;
use super::{GraspConfiguration, Hand, PerContact, PhalanxContact, StaticKinematics, StaticsError};
use crate::gripper::FingerContact;

/// One constraint; fingers are counted from 0 as in [`Hand::fingers`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Row {
    /// Separation rate of a phalanx and the object, in m/s.
    Contact { finger: usize, site: FingerContact },
    /// Separation rate of the object and the palm, in m/s.
    Palm,
    /// Rate θ̇_a of a motor that cannot be back-driven, in rad/s.
    Motor { finger: usize },
    /// Rate (θ̇_a,right + θ̇_a,left)/2 of the input of a differential that cannot be back-driven, in rad/s.
    Input,
}

/// Kind of a constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowKind {
    /// A motor: its rate is in rad/s and its multiplier is a torque. All other kinds have a speed and a force.
    Motor,
    Palm,
    Distal,
    Proximal,
}

impl From<Row> for RowKind {
    fn from(row: Row) -> Self {
        match row {
            Row::Motor { .. } | Row::Input => RowKind::Motor,
            Row::Palm => RowKind::Palm,
            Row::Contact { site: FingerContact::Distal, .. } => RowKind::Distal,
            Row::Contact { .. } => RowKind::Proximal,
        }
    }
}

/// One coordinate of a motion of the grasp. The object is a disc under central forces, so its rotation is not included
/// (d = 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// Velocity of the object, in m/s.
    ObjectX,
    ObjectY,
    /// θ̇1 = q̇21 of a finger, in rad/s; counter-clockwise on the right, clockwise on the left.
    Proximal {
        finger: usize,
    },
    /// θ̇2 = q̇22 of a finger, in rad/s.
    Distal {
        finger: usize,
    },
}

/// U ω ≥ 0 (1.18): each row is a rate that must not be negative, each column an unknown of ω.
#[derive(Clone, Debug, PartialEq)]
pub struct Unilateral {
    pub rows: Vec<Row>,
    pub unknowns: Vec<Unknown>,
    /// U by rows, in units of [`Row`] per unit of [`Unknown`].
    pub matrix: Vec<f64>,
    /// For each unknown, the speed in m/s that corresponds to one unit, so that rates of different kinds are
    /// comparable.
    pub scale: Vec<f64>,
}

/// Necessary condition (1.19) of form closure: n_c + n_u ≥ n_h + d + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NecessaryCount {
    /// n_c: contacts with phalanges and palm.
    pub contacts: usize,
    /// n_u: motors that cannot be back-driven.
    pub motors: usize,
    /// n_h: degrees of freedom of the fingers.
    pub hand: usize,
    /// d: degrees of freedom of the object.
    pub object: usize,
}

impl NecessaryCount {
    pub fn is_met(&self) -> bool {
        self.contacts + self.motors > self.hand + self.object
    }
}

impl Unilateral {
    /// Returns an empty set of constraints on these unknowns.
    pub fn new(unknowns: Vec<Unknown>, scale: Vec<f64>) -> Self {
        Self { rows: Vec::new(), unknowns, matrix: Vec::new(), scale }
    }

    /// Appends a row, given its entry for each unknown.
    pub fn push(&mut self, row: Row, entry: impl Fn(Unknown) -> f64) {
        self.rows.push(row);
        self.matrix.extend(self.unknowns.iter().map(|&unknown| entry(unknown)));
    }

    /// Appends a row with these entries, in the order of the unknowns.
    pub fn append(&mut self, row: Row, entries: &[f64]) {
        self.rows.push(row);
        self.matrix.extend(entries);
    }

    /// Entries of one row.
    pub fn row(&self, index: usize) -> &[f64] {
        let width = self.unknowns.len();
        &self.matrix[index * width..(index + 1) * width]
    }

    /// Returns the numbers of contacts, motors and unknowns in (1.19).
    pub fn necessary_count(&self) -> NecessaryCount {
        let motors = self.rows.iter().filter(|&&row| RowKind::from(row) == RowKind::Motor).count();
        let object = self.unknowns.iter().filter(|u| matches!(u, Unknown::ObjectX | Unknown::ObjectY)).count();
        NecessaryCount { contacts: self.rows.len() - motors, motors, hand: self.unknowns.len() - object, object }
    }
}

/// U of a hand (1.15)–(1.18): contacts of each finger, then motors, then the palm.
///
/// * Contact: (velocity of the object − velocity of the phalanx) · n ≥ 0, n from the phalanx into the object; the speed
///   of the phalanx along n is J θ̇ with J of (1.8) without friction.
/// * Motor that cannot be back-driven: θ̇_a = θ̇1 + θ̇2/(∂q22/∂q11) ≥ 0, the actuator's row of T⁻¹ (errata 12).
/// * Palm: the object does not penetrate it.
///
/// # Errors
/// Returns an error for the singular postures of [`static_kinematics`](super::static_kinematics).
pub fn unilateral(hand: &Hand<'_>) -> Result<Unilateral, StaticsError> {
    let mut unknowns = vec![Unknown::ObjectX, Unknown::ObjectY];
    let mut scale = vec![1.0, 1.0];
    for (finger, grip) in hand.fingers.iter().enumerate() {
        unknowns.extend([Unknown::Proximal { finger }, Unknown::Distal { finger }]);
        scale.extend([grip.finger.lengths.l21_m; 2]);
    }
    let mut u = Unilateral::new(unknowns, scale);
    let mut motors = Vec::with_capacity(hand.fingers.len());
    for (finger, grip) in hand.fingers.iter().enumerate() {
        let StaticKinematics { tip_slope: [alpha, _], .. } = static_kinematics_at(grip.finger, &grip.posture)?;
        // The object is to the left of the phalanges of a right finger.
        let mirror = grip.side.mirror();
        for (site, phalanx_contact) in [(FingerContact::Proximal, grip.proximal), (FingerContact::Distal, grip.distal)]
        {
            let Some(PhalanxContact { normal: [x, y], levers_m: levers }) = phalanx_contact else { continue };
            u.push(Row::Contact { finger, site }, |unknown| match unknown {
                Unknown::ObjectX => mirror * x,
                Unknown::ObjectY => y,
                Unknown::Proximal { finger: index } if index == finger => -levers[0],
                Unknown::Distal { finger: index } if index == finger => -levers[1],
                _ => 0.0,
            });
        }
        if !grip.backdrivable {
            motors.push((finger, alpha));
        }
    }
    for (finger, alpha) in motors {
        u.push(Row::Motor { finger }, |unknown| match unknown {
            Unknown::Proximal { finger: index } if index == finger => 1.0,
            Unknown::Distal { finger: index } if index == finger => 1.0 / alpha,
            _ => 0.0,
        });
    }
    if hand.palm {
        u.push(Row::Palm, |unknown| if unknown == Unknown::ObjectY { 1.0 } else { 0.0 });
    }
    Ok(u)
}

/// Parts of the drive that cannot be back-driven. Blocking them in both directions only adds constraints: a grasp that
/// is closed with these constraints remains closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blocked {
    /// Each driven link separately: both motors, or both outputs of a differential. n_u = 2 in (1.19).
    Outputs,
    /// Only the input of a differential, whose rotation is the mean of its outputs: one finger may yield while the
    /// other follows. n_u = 1.
    Input,
}

/// U of (1.18) of a gripper in this posture with these contacts of phalanges and palm. A table is not included, because
/// the gripper moves its object away from it; a joint limit is not included either, as for one finger.
///
/// The object is a disc, all of whose normals pass through its centre: its rotation does not appear in any row and is
/// not an unknown (d = 2). With rotation as an unknown, a disc would never be form-closed.
///
/// # Errors
/// Returns an error if a loop does not close, and for the singular postures of
/// [`static_kinematics`](super::static_kinematics).
pub fn gripper_unilateral(
    configuration: &GraspConfiguration<'_>,
    active_contacts: &PerContact<bool>,
    blocked: Blocked,
) -> Result<Unilateral, StaticsError> {
    let outputs = unilateral(&configuration.hand(active_contacts)?)?;
    if blocked == Blocked::Outputs {
        return Ok(outputs);
    }
    let mut u = Unilateral::new(outputs.unknowns.clone(), outputs.scale.clone());
    let mut input = vec![0.0; outputs.unknowns.len()];
    for (index, &row) in outputs.rows.iter().enumerate() {
        if RowKind::from(row) == RowKind::Motor {
            input.iter_mut().zip(outputs.row(index)).for_each(|(sum, entry)| *sum += 0.5 * entry);
        } else {
            u.append(row, outputs.row(index));
        }
    }
    u.append(Row::Input, &input);
    Ok(u)
}
