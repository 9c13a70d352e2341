//! Loop closure: consistent joint angles in a given assembly mode.
//!
//! A12 = l11 e(q11), A22 = l21 e(q21), A13 = A12 + l12 e(q11 + q12) = A22 + l22 e(q21 + q22) (thesis (2.4)). The
//! assembly sign γ of thesis (2.1) is the side of the line A12 → A22 on which A13 lies: +1 left, −1 right.
//!
//! At an object, the half width w is added to it ("virtual width", thesis B.10): a phalanx becomes its centre line, and
//! a disc becomes a virtual circle of radius R = r_c + w.

use super::{Assembly, Lengths, NumberError, number};
use crate::numeric::decimals;
use crate::numeric::elementary::{atan2, hypot, sin_cos};
use crate::numeric::plane::{add, cross, sub, wrap_angle};
use crate::shape::{self, PlacedShape, Tangent, second_tangent, tangent};
use std::f64::consts::FRAC_PI_2;

/// Smallest |sin| of the angle between two links that are not in line: above √ε, the accuracy of a triangle height.
const MIN_SINE: f64 = 1e-7;

/// All joint angles of one posture.
///
/// `q11` and `q21` are absolute; `q12` is relative to l11 and within ±π; `q22` is relative to l21 and within −φ22 ± π.
/// The angle q22 + φ22 beyond the straight line is therefore continuous across the joint limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture {
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub q12_rad: f64,
    pub q22_rad: f64,
}

/// Joint positions of a posture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joints {
    pub a12_m: [f64; 2],
    pub a22_m: [f64; 2],
    pub a13_m: [f64; 2],
    /// End of the tip phalanx's centre line.
    pub tip_m: [f64; 2],
}

/// Error for link lengths without a valid posture.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PostureError {
    #[error(transparent)]
    Number(#[from] NumberError),
    #[error(
        "the loop cannot close: {links} ({:.4} and {:.4} mm) must span {:.5$} mm, but can span only {:.5$} to {:.5$} mm: \
         change their lengths, or the angles of the ground links",
        .lengths_m[0] * 1e3, .lengths_m[1] * 1e3, .span_m * 1e3,
        (.lengths_m[0] - .lengths_m[1]).abs() * 1e3, (.lengths_m[0] + .lengths_m[1]) * 1e3,
        decimals(&[.span_m * 1e3, (.lengths_m[0] - .lengths_m[1]).abs() * 1e3, (.lengths_m[0] + .lengths_m[1]) * 1e3], 4)
    )]
    CannotClose { links: &'static str, lengths_m: [f64; 2], span_m: f64 },
    #[error(
        "l11 and l12 ({:.4} and {:.4} mm) are fully stretched (or folded) in the straight configuration, a dead point \
         of the driven link: change l12 (thesis (B.7) gives a valid length)",
        .l11_m * 1e3, .l12_m * 1e3
    )]
    Stretched { l11_m: f64, l12_m: f64 },
    #[error(
        "l12 and l22 are in line at q11 = {:.4} deg, q21 = {:.4} deg, where the two assembly modes coincide: the sine of \
         their angle is {sine:e}, but must be at least 1e-7 in magnitude, so change phi22, l12 or l22, or the angles",
        .q11_rad.to_degrees(), .q21_rad.to_degrees()
    )]
    InLine { q11_rad: f64, q21_rad: f64, sine: f64 },
    #[error(
        "q21 = {:.4} deg with q22 = {:.4} deg is only reached in the other assembly mode: select that mode, or bend \
         the distal phalanx less",
        .q21_rad.to_degrees(), .q22_rad.to_degrees()
    )]
    WrongAssembly { q21_rad: f64, q22_rad: f64 },
}

/// Returns the assembly sign γ = ±1 of thesis (2.1).
///
/// `Reference` is the sign in the straight configuration at q21 = 90°, q22 = −φ22. `Other` is the opposite sign.
pub fn gamma(lengths: &Lengths, assembly: Assembly) -> Result<f64, PostureError> {
    let a22 = [0.0, lengths.l21_m];
    let (a12, a13) = reference(lengths)?;
    let sign = side(lengths, a12, a22, a13)?;
    Ok(match assembly {
        Assembly::Reference => sign,
        Assembly::Other => -sign,
    })
}

/// Returns the straight posture at `q21_rad`: q22 = −φ22, in the reference assembly mode.
///
/// With l12 from thesis (B.7), q11 = q21 − 90°. For any other l12, A12 lies on the palm's side of the line O–A13, so
/// that q11 is as close as possible to q21 − 90°.
pub fn straight_posture(lengths: &Lengths, q21_rad: f64) -> Result<Posture, PostureError> {
    finite("q21_rad", q21_rad)?;
    let (a12, a13) = reference(lengths)?;
    let q11_at_90 = angle(a12);
    Ok(Posture {
        q11_rad: (q21_rad - FRAC_PI_2) + q11_at_90,
        q21_rad,
        q12_rad: wrap_angle(angle(sub(a13, a12)) - q11_at_90),
        q22_rad: -lengths.phi22_rad,
    })
}

/// Returns the posture at given ground-link angles in the given assembly mode (thesis (2.1), (2.2)).
pub fn close_loop(lengths: &Lengths, assembly: Assembly, q11_rad: f64, q21_rad: f64) -> Result<Posture, PostureError> {
    let gamma = gamma(lengths, assembly)?;
    let a13 = joint_a13(lengths, gamma, q11_rad, q21_rad)?;
    let (a12, a22) = (polar(lengths.l11_m, q11_rad), polar(lengths.l21_m, q21_rad));
    side(lengths, a12, a22, a13)?;
    Ok(Posture {
        q11_rad,
        q21_rad,
        q12_rad: wrap_angle(angle(sub(a13, a12)) - q11_rad),
        q22_rad: wrap_angle(angle(sub(a13, a22)) - q21_rad + lengths.phi22_rad) - lengths.phi22_rad,
    })
}

/// Joint A13 at given ground-link angles, on the side γ = ±1 of the line A12 → A22 (thesis (2.1)).
pub fn joint_a13(lengths: &Lengths, gamma: f64, q11_rad: f64, q21_rad: f64) -> Result<[f64; 2], PostureError> {
    check(lengths)?;
    finite("q11_rad", q11_rad)?;
    finite("q21_rad", q21_rad)?;
    let (a12, a22) = (polar(lengths.l11_m, q11_rad), polar(lengths.l21_m, q21_rad));
    apex("l12 and l22", a12, a22, [lengths.l12_m, lengths.l22_m], gamma)
}

/// Returns the posture at given angles of the proximal and the distal body, in the given assembly mode.
///
/// Up to two values of q11 close the loop. If both belong to the given mode, the value is preferred that is reached
/// from the straight configuration without passing through a stretched l11–l12.
pub fn posture_at(lengths: &Lengths, assembly: Assembly, q21_rad: f64, q22_rad: f64) -> Result<Posture, PostureError> {
    finite("q21_rad", q21_rad)?;
    finite("q22_rad", q22_rad)?;
    let gamma = gamma(lengths, assembly)?;
    let elbow = elbow(reference_a13(lengths));
    let a22 = polar(lengths.l21_m, q21_rad);
    let a13 = add(a22, polar(lengths.l22_m, q21_rad + q22_rad));

    for sign in [elbow, -elbow] {
        let a12 = apex("l11 and l12", [0.0, 0.0], a13, [lengths.l11_m, lengths.l12_m], sign)?;
        if side(lengths, a12, a22, a13)? == gamma {
            let q11_rad = wrap_angle(angle(a12) - (q21_rad - FRAC_PI_2)) + (q21_rad - FRAC_PI_2);
            let q12_rad = wrap_angle(angle(sub(a13, a12)) - q11_rad);
            return Ok(Posture { q11_rad, q21_rad, q12_rad, q22_rad });
        }
    }
    Err(PostureError::WrongAssembly { q21_rad, q22_rad })
}

/// Returns the joint positions of a posture. A13 is computed along l21 and l22.
pub fn joint_positions(lengths: &Lengths, posture: &Posture) -> Joints {
    let a22_m = polar(lengths.l21_m, posture.q21_rad);
    let arm = posture.q21_rad + posture.q22_rad;
    let (l22, t22) = (polar(lengths.l22_m, arm), polar(lengths.t22_m, arm + lengths.phi22_rad));
    Joints { a12_m: polar(lengths.l11_m, posture.q11_rad), a22_m, a13_m: add(a22_m, l22), tip_m: add(a22_m, t22) }
}

/// A12 and A13 of the straight configuration at q21 = 90°.
fn reference(lengths: &Lengths) -> Result<([f64; 2], [f64; 2]), PostureError> {
    check(lengths)?;
    let (l11, l12) = (lengths.l11_m, lengths.l12_m);
    let a13 = reference_a13(lengths);
    let a12 = apex("l11 and l12", [0.0, 0.0], a13, [l11, l12], elbow(a13))?;
    if cross(a12, sub(a13, a12)).abs() < MIN_SINE * l11 * l12 {
        return Err(PostureError::Stretched { l11_m: l11, l12_m: l12 });
    }
    Ok((a12, a13))
}

fn reference_a13(lengths: &Lengths) -> [f64; 2] {
    let (s, c) = sin_cos(lengths.phi22_rad);
    [lengths.l22_m * s, lengths.l21_m + lengths.l22_m * c]
}

/// Side of the line O → A13 on which A12 lies in the straight configuration: the side of the palm.
fn elbow(reference_a13: [f64; 2]) -> f64 {
    if reference_a13[1] >= 0.0 { -1.0 } else { 1.0 }
}

/// Side of A12 → A22 on which A13 lies; an error if l12 and l22 are in line.
fn side(lengths: &Lengths, a12: [f64; 2], a22: [f64; 2], a13: [f64; 2]) -> Result<f64, PostureError> {
    let sine = cross(sub(a12, a13), sub(a22, a13)) / (lengths.l12_m * lengths.l22_m);
    if sine.abs() < MIN_SINE || sine.is_nan() {
        return Err(PostureError::InLine { q11_rad: angle(a12), q21_rad: angle(a22), sine });
    }
    Ok(sine.signum()) // the triangle A13, A12, A22 has the orientation of A12, A22, A13
}

/// Apex of the triangle over `from` → `to` with the given sides at `from` and `to`, on its left (+1) or right.
fn apex(
    links: &'static str,
    from: [f64; 2],
    to: [f64; 2],
    [a, b]: [f64; 2],
    sign: f64,
) -> Result<[f64; 2], PostureError> {
    let [dx, dy] = sub(to, from);
    let d = hypot(dx, dy);
    if !(d <= a + b && d >= (a - b).abs() && d > f64::EPSILON * (a + b)) {
        return Err(PostureError::CannotClose { links, lengths_m: [a, b], span_m: d });
    }
    let x = 0.5 * (d + (a - b) * (a + b) / d);
    let h = sign * ((a - x) * (a + x)).max(0.0).sqrt();
    Ok([from[0] + (x * dx - h * dy) / d, from[1] + (x * dy + h * dx) / d])
}

fn check(lengths: &Lengths) -> Result<(), NumberError> {
    let Lengths { l11_m, l12_m, l21_m, l22_m, t22_m, phi22_rad, half_width_m: w } = *lengths;
    for (name, value) in [("l11_m", l11_m), ("l12_m", l12_m), ("l21_m", l21_m), ("l22_m", l22_m), ("t22_m", t22_m)] {
        number(name, value, value > 0.0, "must be a finite length above 0")?;
    }
    number("half_width_m", w, w >= 0.0, "must be a finite length, 0 or more")?;
    finite("phi22_rad", phi22_rad)
}

fn finite(name: &'static str, value: f64) -> Result<(), NumberError> {
    number(name, value, true, "must be a finite angle")
}

fn polar(r: f64, angle: f64) -> [f64; 2] {
    let (s, c) = sin_cos(angle);
    [r * c, r * s]
}

fn angle(v: [f64; 2]) -> f64 {
    atan2(v[1], v[0])
}

/// Relative tolerance for a contact at the very end of a phalanx (as for l21 = l21,max).
const SLACK: f64 = 1e-9;

/// Final posture: both phalanges are tangent to the object.
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
    #[error(transparent)]
    Number(#[from] NumberError),
    #[error(
        "the object's centre is {:.2$} mm from the ground joint, but must be more than {:.2$} mm (its radius and the half \
         width) away: move it, or make it smaller",
        .distance_m * 1e3, .min_m * 1e3, decimals(&[.distance_m * 1e3, .min_m * 1e3], 4)
    )]
    TooNear { distance_m: f64, min_m: f64 },
    #[error(
        "the proximal phalanx misses the object: it is {:.2$} mm long, but the contact is {:.2$} mm from its joint, so \
         make l21 longer or move the object closer",
        .l21_m * 1e3, .contact_m * 1e3, decimals(&[.l21_m * 1e3, .contact_m * 1e3], 4)
    )]
    ProximalTooShort { l21_m: f64, contact_m: f64 },
    #[error(
        "the distal phalanx does not reach its contact: it is {:.2$} mm long, but the contact is {:.2$} mm from its joint, \
         so make t22 longer or l21 shorter",
        .t22_m * 1e3, .contact_m * 1e3, decimals(&[.t22_m * 1e3, .contact_m * 1e3], 4)
    )]
    TipTooShort { t22_m: f64, contact_m: f64 },
    #[error(transparent)]
    Loop(#[from] PostureError),
}

/// Contact of the proximal phalanx, which rotates counter-clockwise towards the object from its right (thesis (B.3)):
/// contact angle q_c21, and distance l_c21 from O along the phalanx. The disc of a design has (x_c, y_c) = (−base,
/// r_c).
pub fn contact_proximal(half_width_m: f64, object: PlacedShape) -> Result<Tangent, GraspError> {
    let [x, y] = object.centre_m;
    for (name, size_m) in shape::dimensions(&object.shape) {
        number(name, size_m, size_m > 0.0, "must be a finite length above 0")?;
    }
    number("half_width_m", half_width_m, half_width_m >= 0.0, "must be a finite length, 0 or more")?;
    number("centre_m x", x, true, "must be a finite length")?;
    number("centre_m y", y, true, "must be a finite length")?;
    tangent(&object, half_width_m).map_err(|min_m| GraspError::TooNear { distance_m: hypot(x, y), min_m })
}

/// q_c21 of [`contact_proximal`] alone.
pub fn contact_angle_proximal(half_width_m: f64, object: PlacedShape) -> Result<f64, GraspError> {
    Ok(contact_proximal(half_width_m, object)?.angle_rad)
}

/// Returns the start of the closing motion: a straight finger, `opening_rad` (q_0 of thesis Table 3.2) before the
/// proximal contact.
pub fn start_posture(lengths: &Lengths, object: PlacedShape, opening_rad: f64) -> Result<Posture, GraspError> {
    finite("opening_rad", opening_rad)?;
    Ok(straight_posture(lengths, contact_angle_proximal(lengths.half_width_m, object)? - opening_rad)?)
}

/// Returns the final posture: both phalanges tangent to the object.
///
/// q21 = q_c21. The tip lies on the second tangent from A22, and the angle of that tangent is the bend of the tip: φ_c
/// = q21 − 90° + bend, and the tip points along φ_c + 90°, i.e. q22 = bend − φ22. q11 follows from the loop.
pub fn final_posture(lengths: &Lengths, assembly: Assembly, object: PlacedShape) -> Result<FinalPosture, GraspError> {
    let contact = contact_proximal(lengths.half_width_m, object)?;
    let (l21, t22, l_c21, q21_rad) = (lengths.l21_m, lengths.t22_m, contact.length_m, contact.angle_rad);
    if l_c21 > l21 * (1.0 + SLACK) {
        return Err(GraspError::ProximalTooShort { l21_m: l21, contact_m: l_c21 });
    }
    let Tangent { angle_rad: bend, length_m: l_c22 } =
        second_tangent(&object, lengths.half_width_m, &contact, (l21 - l_c21).max(0.0));
    if l_c22 > t22 * (1.0 + SLACK) {
        return Err(GraspError::TipTooShort { t22_m: t22, contact_m: l_c22 });
    }
    // NaN lengths pass the comparisons above; `posture_at` rejects them.
    Ok(FinalPosture {
        posture: posture_at(lengths, assembly, q21_rad, bend - lengths.phi22_rad)?,
        l_c21_m: l_c21,
        l_c22_m: l_c22,
        phi_c_rad: q21_rad - FRAC_PI_2 + bend,
    })
}
