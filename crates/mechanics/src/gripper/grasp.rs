//! Postures against a disc: where the proximal phalanx meets it, where the finger starts, where it ends.
//!
//! The half width w is moved onto the disc ("virtual width", thesis B.10): a phalanx is its centre line, and the disc a
//! virtual circle of radius R = r_c + w.

use super::posture::{Posture, PostureError, posture_at, straight};
use super::{Assembly, Lengths};
use crate::numeric::elementary::{asin, atan2, hypot};
use std::f64::consts::FRAC_PI_2;

/// Relative slack for a contact that lies on the very end of a phalanx (l21 = l21,max makes it so).
const SLACK: f64 = 1e-9;

/// A disc in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    pub radius_m: f64,
    pub centre_m: [f64; 2],
}

/// The proximal phalanx tangent to the virtual circle, from its right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProximalContact {
    /// q_c21.
    pub q21_rad: f64,
    /// l_c21, from O to the contact along the phalanx.
    pub length_m: f64,
}

/// Both phalanges tangent to the virtual circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinalPosture {
    pub posture: Posture,
    /// l_c21, from O to the contact along l21.
    pub l_c21_m: f64,
    /// l_c22, from A22 to the contact along t22.
    pub l_c22_m: f64,
    /// φ_c: direction from the centre of the disc to the tip's contact.
    pub phi_c_rad: f64,
}

/// Why the finger does not grasp the disc.
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

/// Where the proximal phalanx, swung counter-clockwise from the disc's right, is tangent to the virtual circle.
///
/// With D² = x_c² + y_c², R = r_c + w: q_c21 = atan2(y_c, x_c) − asin(R/D), l_c21 = √(D² − R²) (thesis (B.3)). The disc
/// of a design has (x_c, y_c) = (−base, r_c).
pub fn contact_proximal(half_width_m: f64, disc: Circle) -> Result<ProximalContact, GraspError> {
    let [x, y] = disc.centre_m;
    number("radius_m", disc.radius_m, disc.radius_m > 0.0, "must be a finite length above 0")?;
    number("half_width_m", half_width_m, half_width_m >= 0.0, "must be a finite length, 0 or more")?;
    number("centre_m x", x, true, "must be a finite length")?;
    number("centre_m y", y, true, "must be a finite length")?;

    let (r, d) = (disc.radius_m + half_width_m, hypot(x, y));
    if !(d > r && d.is_finite()) {
        return Err(GraspError::TooNear { distance_m: d, min_m: r });
    }
    Ok(ProximalContact { q21_rad: atan2(y, x) - asin(r / d), length_m: ((d - r) * (d + r)).sqrt() })
}

/// q_c21 of [`contact_proximal`] alone.
pub fn contact_angle_proximal(half_width_m: f64, disc: Circle) -> Result<f64, GraspError> {
    Ok(contact_proximal(half_width_m, disc)?.q21_rad)
}

/// Start of the closing: straight, `opening_rad` (q_0 of thesis Table 3.2) short of the proximal contact.
pub fn start_posture(lengths: &Lengths, disc: Circle, opening_rad: f64) -> Result<Posture, GraspError> {
    number("opening_rad", opening_rad, true, "must be a finite angle")?;
    let contact = contact_proximal(lengths.half_width_m, disc)?;
    Ok(straight(lengths, contact.q21_rad - opening_rad)?)
}

/// The final posture: both phalanges tangent to the virtual circle.
///
/// q21 = q_c21. The tip lies on the second tangent from A22; the two tangents from one point are equally long, so
/// l_c22 = l21 − l_c21 =: t (errata 14), the tip bends by 2β with tan β = t/R, φ_c = q21 − 90° + 2β, and the tip points
/// along φ_c + 90°, i.e. q22 = 2β − φ22. q11 follows from the loop.
pub fn final_posture(lengths: &Lengths, assembly: Assembly, disc: Circle) -> Result<FinalPosture, GraspError> {
    let contact = contact_proximal(lengths.half_width_m, disc)?;
    let (l21, t22, l_c21) = (lengths.l21_m, lengths.t22_m, contact.length_m);
    if l_c21 > l21 * (1.0 + SLACK) {
        return Err(GraspError::ProximalTooShort { l21_m: l21, contact_m: l_c21 });
    }
    let l_c22 = (l21 - l_c21).max(0.0);
    if l_c22 > t22 * (1.0 + SLACK) {
        return Err(GraspError::TipTooShort { t22_m: t22, contact_m: l_c22 });
    }
    let bend = 2.0 * atan2(l_c22, disc.radius_m + lengths.half_width_m);
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
