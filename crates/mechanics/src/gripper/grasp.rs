//! Postures against an object: where the proximal phalanx meets it, where the finger starts, where it ends.
//!
//! The half width w is moved onto the object ("virtual width", thesis B.10): a phalanx is its centre line, and a disc a
//! virtual circle of radius R = r_c + w.

use super::posture::{Posture, PostureError, posture_at, straight};
use super::{Assembly, Lengths};
use crate::numeric::elementary::hypot;
use crate::shape::{self, Placed, Tangent, other_tangent, tangent};
use std::f64::consts::FRAC_PI_2;

/// Relative slack for a contact that lies on the very end of a phalanx (l21 = l21,max makes it so).
const SLACK: f64 = 1e-9;

/// The proximal phalanx tangent to the object, from its right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProximalContact {
    /// q_c21.
    pub q21_rad: f64,
    /// l_c21, from O to the contact along the phalanx.
    pub length_m: f64,
}

/// Both phalanges tangent to the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinalPosture {
    pub posture: Posture,
    /// l_c21, from O to the contact along l21.
    pub l_c21_m: f64,
    /// l_c22, from A22 to the contact along t22.
    pub l_c22_m: f64,
    /// φ_c: direction of the object's outward normal at the tip's contact.
    pub phi_c_rad: f64,
}

/// Why the finger does not grasp the object.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GraspError {
    #[error("{name} of the grasp is {value}, but {allowed}: give another value")]
    Number { name: &'static str, value: f64, allowed: &'static str },
    #[error(
        "the object's centre is {:.4} mm from the ground joint, but must be more than {:.4} mm (its radius and the half \
         width) away: move it, or make it smaller",
        .distance_m * 1e3, .min_m * 1e3
    )]
    TooNear { distance_m: f64, min_m: f64 },
    #[error(
        "the proximal phalanx misses the object: it is {:.4} mm long, but the contact is {:.4} mm from its joint, so \
         make l21 longer or move the object nearer",
        .l21_m * 1e3, .contact_m * 1e3
    )]
    ProximalTooShort { l21_m: f64, contact_m: f64 },
    #[error(
        "the distal phalanx does not reach its contact: it is {:.4} mm long, but the contact is {:.4} mm from its joint, \
         so make t22 longer or l21 shorter",
        .t22_m * 1e3, .contact_m * 1e3
    )]
    TipTooShort { t22_m: f64, contact_m: f64 },
    #[error(transparent)]
    Loop(#[from] PostureError),
}

/// Where the proximal phalanx, swung counter-clockwise from the object's right, is tangent to it (thesis (B.3)). The disc of a design has
/// (x_c, y_c) = (−base, r_c).
pub fn contact_proximal(half_width_m: f64, object: Placed) -> Result<ProximalContact, GraspError> {
    let [x, y] = object.centre_m;
    for (name, size_m) in shape::sizes(&object.shape) {
        number(name, size_m, size_m > 0.0, "must be a finite length above 0")?;
    }
    number("half_width_m", half_width_m, half_width_m >= 0.0, "must be a finite length, 0 or more")?;
    number("centre_m x", x, true, "must be a finite length")?;
    number("centre_m y", y, true, "must be a finite length")?;

    let too_near = |min_m| GraspError::TooNear { distance_m: hypot(x, y), min_m };
    let line = tangent(&object, half_width_m).map_err(too_near)?;
    Ok(ProximalContact { q21_rad: line.angle_rad, length_m: line.length_m })
}

/// q_c21 of [`contact_proximal`] alone.
pub fn contact_angle_proximal(half_width_m: f64, object: Placed) -> Result<f64, GraspError> {
    Ok(contact_proximal(half_width_m, object)?.q21_rad)
}

/// Start of the closing: straight, `opening_rad` (q_0 of thesis Table 3.2) short of the proximal contact.
pub fn start_posture(lengths: &Lengths, object: Placed, opening_rad: f64) -> Result<Posture, GraspError> {
    number("opening_rad", opening_rad, true, "must be a finite angle")?;
    let contact = contact_proximal(lengths.half_width_m, object)?;
    Ok(straight(lengths, contact.q21_rad - opening_rad)?)
}

/// The final posture: both phalanges tangent to the object.
///
/// q21 = q_c21. The tip lies on the second tangent from A22, by whose angle it bends: φ_c = q21 − 90° + bend, and the tip points along
/// φ_c + 90°, i.e. q22 = bend − φ22. q11 follows from the loop.
pub fn final_posture(lengths: &Lengths, assembly: Assembly, object: Placed) -> Result<FinalPosture, GraspError> {
    let contact = contact_proximal(lengths.half_width_m, object)?;
    let (l21, t22, l_c21) = (lengths.l21_m, lengths.t22_m, contact.length_m);
    if l_c21 > l21 * (1.0 + SLACK) {
        return Err(GraspError::ProximalTooShort { l21_m: l21, contact_m: l_c21 });
    }
    let first = Tangent { angle_rad: contact.q21_rad, length_m: l_c21 };
    let Tangent { angle_rad: bend, length_m: l_c22 } =
        other_tangent(&object, lengths.half_width_m, &first, (l21 - l_c21).max(0.0));
    if l_c22 > t22 * (1.0 + SLACK) {
        return Err(GraspError::TipTooShort { t22_m: t22, contact_m: l_c22 });
    }
    // Lengths that are not numbers pass the comparisons above; `posture_at` refuses them.
    Ok(FinalPosture {
        posture: posture_at(lengths, assembly, contact.q21_rad, bend - lengths.phi22_rad)?,
        l_c21_m: l_c21,
        l_c22_m: l_c22,
        phi_c_rad: contact.q21_rad - FRAC_PI_2 + bend,
    })
}

fn number(name: &'static str, value: f64, in_range: bool, allowed: &'static str) -> Result<(), GraspError> {
    if value.is_finite() && in_range { Ok(()) } else { Err(GraspError::Number { name, value, allowed }) }
}
