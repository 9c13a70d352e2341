//! What a motion of the grasp may not do: U of (1.18), row by row.

use super::posture::at_posture;
use super::{AtRest, Hand, StaticsError, Touch};
use crate::gripper::Site;

/// One constraint; fingers are counted from 0 as in [`Hand::fingers`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Row {
    /// Rate at which a phalanx and the object part, in m/s.
    Contact { finger: usize, site: Site },
    /// Rate at which the object leaves the palm, in m/s.
    Palm,
    /// Rate θ̇_a of a motor that cannot be turned back, in rad/s.
    Motor { finger: usize },
}

/// What a constraint is, as far as a decision asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Its rate is in rad/s and its multiplier a torque; of all others they are a speed and a force.
    Motor,
    Palm,
    Distal,
    Proximal,
}

impl From<Row> for Kind {
    fn from(row: Row) -> Self {
        match row {
            Row::Motor { .. } => Kind::Motor,
            Row::Palm => Kind::Palm,
            Row::Contact { site: Site::Distal, .. } => Kind::Distal,
            Row::Contact { .. } => Kind::Proximal,
        }
    }
}

/// One coordinate of a motion of the grasp. The object is a disc under central forces: its rotation is none of them (d = 2).
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
pub struct Unilateral<R = Row> {
    pub rows: Vec<R>,
    pub unknowns: Vec<Unknown>,
    /// U by rows, in the units of [`Row`] for each unit of [`Unknown`].
    pub matrix: Vec<f64>,
    /// For each unknown, the speed in m/s that one unit of it stands for, so that rates of any kind can be weighed together.
    pub scale: Vec<f64>,
}

/// (1.19): n_c + n_u ≥ n_h + d + 1, without which no grasp is form-closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NecessaryCount {
    /// n_c: contacts with phalanges and palm.
    pub contacts: usize,
    /// n_u: motors that cannot be turned back.
    pub motors: usize,
    /// n_h: freedoms of the fingers.
    pub hand: usize,
    /// d: freedoms of the object.
    pub object: usize,
}

impl NecessaryCount {
    pub fn is_met(&self) -> bool {
        self.contacts + self.motors > self.hand + self.object
    }
}

impl<R: Copy + Into<Kind>> Unilateral<R> {
    /// No constraints yet on these unknowns.
    pub fn new(unknowns: Vec<Unknown>, scale: Vec<f64>) -> Self {
        Self { rows: Vec::new(), unknowns, matrix: Vec::new(), scale }
    }

    /// Adds a row: its entry for each unknown.
    pub fn push(&mut self, row: R, entry: impl Fn(Unknown) -> f64) {
        self.rows.push(row);
        self.matrix.extend(self.unknowns.iter().map(|&unknown| entry(unknown)));
    }

    /// Adds a row whose entries are known, in the order of the unknowns.
    pub fn append(&mut self, row: R, entries: &[f64]) {
        self.rows.push(row);
        self.matrix.extend(entries);
    }

    /// The same constraints by other names.
    pub fn named<S>(self, name: impl Fn(R) -> S) -> Unilateral<S> {
        let Self { rows, unknowns, matrix, scale } = self;
        Unilateral { rows: rows.into_iter().map(name).collect(), unknowns, matrix, scale }
    }

    /// Entries of one row.
    pub fn row(&self, index: usize) -> &[f64] {
        let width = self.unknowns.len();
        &self.matrix[index * width..(index + 1) * width]
    }

    /// The count of (1.19).
    pub fn necessary_count(&self) -> NecessaryCount {
        let motors = self.rows.iter().filter(|&&row| row.into() == Kind::Motor).count();
        let object = self.unknowns.iter().filter(|u| matches!(u, Unknown::ObjectX | Unknown::ObjectY)).count();
        NecessaryCount { contacts: self.rows.len() - motors, motors, hand: self.unknowns.len() - object, object }
    }
}

/// U of a hand (1.15)–(1.18): contacts of each finger, then motors, then the palm.
///
/// * Contact: (velocity of the object − that of the phalanx) · n ≥ 0, n from the phalanx into the object; the phalanx moves
///   along n at (J θ̇) with the J of (1.8) without friction.
/// * Motor that cannot be turned back: θ̇_a = θ̇1 + θ̇2/(∂q22/∂q11) ≥ 0, the actuator's row of T⁻¹ (errata 12).
/// * Palm: the object does not go into it.
///
/// # Errors
/// The singular postures of [`at_rest`](super::at_rest).
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
        let AtRest { tip_slope: [alpha, _], .. } = at_posture(grip.finger, &grip.posture)?;
        // The object is to the left of the phalanges of a finger on the right.
        let mirror = grip.side.mirror();
        for (site, touch) in [(Site::Proximal, grip.proximal), (Site::Distal, grip.distal)] {
            let Some(Touch { normal: [x, y], levers_m: levers }) = touch else { continue };
            u.push(Row::Contact { finger, site }, |unknown| match unknown {
                Unknown::ObjectX => mirror * x,
                Unknown::ObjectY => y,
                Unknown::Proximal { finger: of } if of == finger => -levers[0],
                Unknown::Distal { finger: of } if of == finger => -levers[1],
                _ => 0.0,
            });
        }
        if !grip.backdrivable {
            motors.push((finger, alpha));
        }
    }
    for (finger, alpha) in motors {
        u.push(Row::Motor { finger }, |unknown| match unknown {
            Unknown::Proximal { finger: of } if of == finger => 1.0,
            Unknown::Distal { finger: of } if of == finger => 1.0 / alpha,
            _ => 0.0,
        });
    }
    if hand.palm {
        u.push(Row::Palm, |unknown| if unknown == Unknown::ObjectY { 1.0 } else { 0.0 });
    }
    Ok(u)
}
