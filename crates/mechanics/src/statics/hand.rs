//! The hand: fingers in any posture with their active contacts, and the palm.

use crate::gripper::{FinalPosture, Finger, Posture};
use crate::numeric::elementary::{cos, sin};
use crate::numeric::plane::{Vector, add, cross, perp, scale, sub};

/// Side of a finger: the modelled finger is to the right of the object, its mirror image to the left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Right,
    Left,
}

impl Side {
    pub const BOTH: [Self; 2] = [Side::Right, Side::Left];

    /// Returns +1 if the x axis of the finger frame is the x axis of the palm, −1 if it is mirrored.
    #[inline]
    pub fn mirror(self) -> f64 {
        if self == Side::Right { 1.0 } else { -1.0 }
    }

    pub fn name(self) -> &'static str {
        if self == Side::Right { "right" } else { "left" }
    }
}

/// Contact of a phalanx with the object, in the frame of a right finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhalanxContact {
    /// Unit normal, from the phalanx into the object.
    pub normal: [f64; 2],
    /// Speed of the phalanx along the normal per rad/s of θ̇1 and θ̇2: the row of J of (1.8) without friction.
    pub levers_m: [f64; 2],
}

impl PhalanxContact {
    /// Contact of the proximal phalanx, which rotates about the origin. `foot` is the point of its centre line nearest
    /// to the object: all points on the normal have the same lever, so that the half width is irrelevant.
    pub fn proximal(foot: Vector<f64>, normal: Vector<f64>) -> Self {
        PhalanxContact { normal, levers_m: [cross(foot, normal), 0.0] }
    }

    /// Contact of the distal phalanx, which rotates with the proximal phalanx and about A22.
    pub fn distal(foot: Vector<f64>, normal: Vector<f64>, a22: Vector<f64>) -> Self {
        PhalanxContact { normal, levers_m: [cross(foot, normal), cross(sub(foot, a22), normal)] }
    }
}

/// One finger and its contacts with the object.
#[derive(Clone, Copy, Debug)]
pub struct FingerGrip<'a> {
    pub finger: &'a Finger,
    /// Posture in the frame of a right finger; a left finger is its mirror image.
    pub posture: Posture,
    pub side: Side,
    /// Contact of the proximal phalanx, if active (S of (1.17)).
    pub proximal: Option<PhalanxContact>,
    /// Contact of the distal phalanx, if active.
    pub distal: Option<PhalanxContact>,
    /// Whether the finger can back-drive the motor; if not, θ̇_a ≥ 0.
    pub backdrivable: bool,
}

impl<'a> FingerGrip<'a> {
    /// Both phalanges are in contact, and the motor cannot be back-driven.
    pub fn with_both_contacts(finger: &'a Finger, end: &FinalPosture, side: Side) -> Self {
        let FinalPosture { posture, l_c21_m, l_c22_m, .. } = *end;
        let direction = |angle: f64| [cos(angle), sin(angle)];
        let along = direction(posture.q21_rad);
        let tip = direction(posture.q21_rad + posture.q22_rad + finger.lengths.phi22_rad);
        let a22 = scale(along, finger.lengths.l21_m);
        Self {
            finger,
            posture,
            side,
            proximal: Some(PhalanxContact::proximal(scale(along, l_c21_m), perp(along))),
            distal: Some(PhalanxContact::distal(add(a22, scale(tip, l_c22_m)), perp(tip), a22)),
            backdrivable: false,
        }
    }
}

/// All fingers and the palm.
#[derive(Clone, Debug)]
pub struct Hand<'a> {
    pub fingers: Vec<FingerGrip<'a>>,
    /// Whether the object is in contact with the palm.
    pub palm: bool,
}

impl<'a> Hand<'a> {
    /// Returns the gripper of the thesis: a finger, its mirror image and the palm.
    pub fn symmetric(finger: &'a Finger, end: &FinalPosture) -> Self {
        Self { fingers: Side::BOTH.map(|side| FingerGrip::with_both_contacts(finger, end, side)).to_vec(), palm: true }
    }
}
