//! What holds the object: fingers in any posture with the phalanges that touch, and the palm.

use crate::gripper::{FinalPosture, Finger, Posture};
use crate::numeric::elementary::{cos, sin};
use crate::numeric::plane::{Vector, add, cross, perp, scale, sub};

/// Which way a finger stands: the modelled one is to the right of the object, its mirror image to the left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Right,
    Left,
}

impl Side {
    pub const BOTH: [Self; 2] = [Side::Right, Side::Left];

    /// +1 where x of the finger's frame is that of the palm, −1 where it is its mirror image.
    #[inline]
    pub fn mirror(self) -> f64 {
        if self == Side::Right { 1.0 } else { -1.0 }
    }

    pub fn word(self) -> &'static str {
        if self == Side::Right { "right" } else { "left" }
    }
}

/// How a phalanx touches the object, as of the finger on the right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Unit normal, from the phalanx into the object.
    pub normal: [f64; 2],
    /// Speed of the phalanx along the normal for each rad/s of θ̇1 and θ̇2: its row of the J of (1.8) without friction.
    pub levers_m: [f64; 2],
}

impl Touch {
    /// Of the proximal phalanx, which turns about the origin. `foot` is the point of its centre line nearest to the object's centre: all
    /// that is on the normal has the same lever, so that the half width does not matter.
    pub fn proximal(foot: Vector<f64>, normal: Vector<f64>) -> Self {
        Touch { normal, levers_m: [cross(foot, normal), 0.0] }
    }

    /// The same of the distal phalanx, which turns with the proximal one, and about A22.
    pub fn distal(foot: Vector<f64>, normal: Vector<f64>, a22: Vector<f64>) -> Self {
        Touch { normal, levers_m: [cross(foot, normal), cross(sub(foot, a22), normal)] }
    }
}

/// One finger on the object.
#[derive(Clone, Copy, Debug)]
pub struct Grip<'a> {
    pub finger: &'a Finger,
    /// As of the finger on the right; a finger on the left is its mirror image.
    pub posture: Posture,
    pub side: Side,
    /// The phalanges that touch (S of (1.17)).
    pub proximal: Option<Touch>,
    pub distal: Option<Touch>,
    /// Whether the motor can be turned back from the finger; if not, θ̇_a ≥ 0.
    pub backdrivable: bool,
}

impl<'a> Grip<'a> {
    /// Both phalanges touch, and the motor cannot be turned back.
    pub fn firm(finger: &'a Finger, end: &FinalPosture, side: Side) -> Self {
        let FinalPosture { posture, l_c21_m, l_c22_m, .. } = *end;
        let direction = |angle: f64| [cos(angle), sin(angle)];
        let along = direction(posture.q21_rad);
        let tip = direction(posture.q21_rad + posture.q22_rad + finger.lengths.phi22_rad);
        let a22 = scale(along, finger.lengths.l21_m);
        Self {
            finger,
            posture,
            side,
            proximal: Some(Touch::proximal(scale(along, l_c21_m), perp(along))),
            distal: Some(Touch::distal(add(a22, scale(tip, l_c22_m)), perp(tip), a22)),
            backdrivable: false,
        }
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
    pub fn symmetric(finger: &'a Finger, end: &FinalPosture) -> Self {
        Self { fingers: Side::BOTH.map(|side| Grip::firm(finger, end, side)).to_vec(), palm: true }
    }
}
