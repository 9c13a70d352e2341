//! What a motion of the grasp may not do: U of (1.18), row by row.

use super::{AtRest, StaticsError, at_rest};
use crate::gripper::{FinalPosture, Finger, Site};
use crate::numeric::plane::{perp, rotate};

/// Which way a finger stands: the modelled one is to the right of the object, its mirror image to the left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Right,
    Left,
}

/// One finger on the object.
#[derive(Clone, Copy, Debug)]
pub struct Grip<'a> {
    pub finger: &'a Finger,
    /// As of the finger on the right; a finger on the left is its mirror image.
    pub end: &'a FinalPosture,
    pub side: Side,
    /// Which phalanges touch (S of (1.17)).
    pub proximal: bool,
    pub distal: bool,
    /// Whether the motor can be turned back from the finger; if not, θ̇_a ≥ 0.
    pub backdrivable: bool,
}

impl<'a> Grip<'a> {
    /// Both phalanges touch, and the motor cannot be turned back.
    pub fn firm(finger: &'a Finger, end: &'a FinalPosture, side: Side) -> Self {
        Self { finger, end, side, proximal: true, distal: true, backdrivable: false }
    }
}

/// All that holds the object.
#[derive(Clone, Debug)]
pub struct Hand<'a> {
    pub fingers: Vec<Grip<'a>>,
    /// Whether the object rests on the palm.
    pub palm: bool,
}

impl<'a> Hand<'a> {
    /// The gripper of the thesis: a finger, its mirror image and the palm.
    pub fn symmetric(finger: &'a Finger, end: &'a FinalPosture) -> Self {
        Self { fingers: [Side::Right, Side::Left].map(|side| Grip::firm(finger, end, side)).to_vec(), palm: true }
    }
}

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
pub struct Unilateral {
    pub rows: Vec<Row>,
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

impl Unilateral {
    /// No constraints yet on these unknowns.
    pub fn new(unknowns: Vec<Unknown>, scale: Vec<f64>) -> Self {
        Self { rows: Vec::new(), unknowns, matrix: Vec::new(), scale }
    }

    /// Adds a row: its entry for each unknown.
    pub fn push(&mut self, row: Row, entry: impl Fn(Unknown) -> f64) {
        self.rows.push(row);
        self.matrix.extend(self.unknowns.iter().map(|&unknown| entry(unknown)));
    }

    /// Entries of one row.
    pub fn row(&self, index: usize) -> &[f64] {
        let width = self.unknowns.len();
        &self.matrix[index * width..(index + 1) * width]
    }

    /// The count of (1.19).
    pub fn necessary_count(&self) -> NecessaryCount {
        let motors = self.rows.iter().filter(|row| matches!(row, Row::Motor { .. })).count();
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
/// The singular postures of [`at_rest`].
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
        let AtRest { pose, tip_slope: [alpha, _], .. } = at_rest(grip.finger, grip.end)?;
        let lengths = &grip.finger.lengths;
        let (sin, cos) = lengths.phi22_rad.sin_cos();
        // The object is to the left of the phalanges of a finger on the right.
        let mirror = if grip.side == Side::Right { 1.0 } else { -1.0 };
        let bend = grip.end.posture.q22_rad + lengths.phi22_rad;
        let (l_c21, l_c22) = (grip.end.l_c21_m, grip.end.l_c22_m);
        let contacts = [
            (grip.proximal, Site::Proximal, perp(pose.e2), [l_c21, 0.0]),
            (grip.distal, Site::Distal, perp(rotate(pose.e4, [cos, sin])), [l_c22 + lengths.l21_m * bend.cos(), l_c22]),
        ];
        for (_, site, [x, y], levers) in contacts.into_iter().filter(|contact| contact.0) {
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
