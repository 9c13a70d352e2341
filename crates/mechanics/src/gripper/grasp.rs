//! Postures at an object: proximal contact, start of the closing motion, and final posture.
//!
//! The half width w is added to the object ("virtual width", thesis B.10): a phalanx becomes its centre line, and a
//! disc becomes a virtual circle of radius R = r_c + w.

use super::posture::{Posture, PostureError, posture_at, straight_posture};
use super::{Assembly, Lengths};
use crate::numeric::elementary::hypot;
use crate::shape::{self, PlacedShape, Tangent, second_tangent, tangent};
use std::f64::consts::FRAC_PI_2;

/// Relative tolerance for a contact at the very end of a phalanx (as for l21 = l21,max).
const SLACK: f64 = 1e-9;

/// The proximal phalanx tangent to the object, from its right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProximalContact {
    /// Contact angle q_c21.
    pub q21_rad: f64,
    /// l_c21, distance from O to the contact along the phalanx.
    pub length_m: f64,
}

/// Both phalanges tangent to the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinalPosture {
    pub posture: Posture,
    /// l_c21, distance from O to the contact along l21.
    pub l_c21_m: f64,
    /// l_c22, distance from A22 to the contact along t22.
    pub l_c22_m: f64,
    /// φ_c: direction of the object's outward normal at the tip contact.
    pub phi_c_rad: f64,
}

/// Error for a finger that cannot grasp the object.
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
         make l21 longer or move the object closer",
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

/// Contact of the proximal phalanx, rotated counter-clockwise towards the object from its right (thesis (B.3)). The
/// disc of a design has (x_c, y_c) = (−base, r_c).
pub fn contact_proximal(half_width_m: f64, object: PlacedShape) -> Result<ProximalContact, GraspError> {
    let [x, y] = object.centre_m;
    for (name, size_m) in shape::dimensions(&object.shape) {
        number(name, size_m, size_m > 0.0, "must be a finite length above 0")?;
    }
    number("half_width_m", half_width_m, half_width_m >= 0.0, "must be a finite length, 0 or more")?;
    number("centre_m x", x, true, "must be a finite length")?;
    number("centre_m y", y, true, "must be a finite length")?;

    let too_near_error = |min_m| GraspError::TooNear { distance_m: hypot(x, y), min_m };
    let line = tangent(&object, half_width_m).map_err(too_near_error)?;
    Ok(ProximalContact { q21_rad: line.angle_rad, length_m: line.length_m })
}

/// q_c21 of [`contact_proximal`] alone.
pub fn contact_angle_proximal(half_width_m: f64, object: PlacedShape) -> Result<f64, GraspError> {
    Ok(contact_proximal(half_width_m, object)?.q21_rad)
}

/// Start of the closing motion: straight, at the angle `opening_rad` (q_0 of thesis Table 3.2) before the proximal
/// contact.
pub fn start_posture(lengths: &Lengths, object: PlacedShape, opening_rad: f64) -> Result<Posture, GraspError> {
    number("opening_rad", opening_rad, true, "must be a finite angle")?;
    let contact = contact_proximal(lengths.half_width_m, object)?;
    Ok(straight_posture(lengths, contact.q21_rad - opening_rad)?)
}

/// Returns the final posture: both phalanges tangent to the object.
///
/// q21 = q_c21. The tip lies on the second tangent from A22, and the angle of that tangent is the bend of the tip: φ_c
/// = q21 − 90° + bend, and the tip points along φ_c + 90°, i.e. q22 = bend − φ22. q11 follows from the loop.
pub fn final_posture(lengths: &Lengths, assembly: Assembly, object: PlacedShape) -> Result<FinalPosture, GraspError> {
    let contact = contact_proximal(lengths.half_width_m, object)?;
    let (l21, t22, l_c21) = (lengths.l21_m, lengths.t22_m, contact.length_m);
    if l_c21 > l21 * (1.0 + SLACK) {
        return Err(GraspError::ProximalTooShort { l21_m: l21, contact_m: l_c21 });
    }
    let first = Tangent { angle_rad: contact.q21_rad, length_m: l_c21 };
    let Tangent { angle_rad: bend, length_m: l_c22 } =
        second_tangent(&object, lengths.half_width_m, &first, (l21 - l_c21).max(0.0));
    if l_c22 > t22 * (1.0 + SLACK) {
        return Err(GraspError::TipTooShort { t22_m: t22, contact_m: l_c22 });
    }
    // NaN lengths pass the comparisons above; `posture_at` rejects them.
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
