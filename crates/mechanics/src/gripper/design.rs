//! Link lengths from the free parameters of a design (thesis appendix B.2.2, (B.3)–(B.7)).
//!
//! A design fixes the distance of the finger from the disc (`base`), the length of the proximal phalanx within the
//! range that this base allows, the angle of the distal body, and its arm. All other lengths follow.

use super::posture::{GraspError, contact_proximal};
use super::posture::{PostureError, gamma};
use super::{Assembly, Lengths, NumberError, positive};
use crate::numeric::decimals;
use crate::numeric::elementary::{cos, hypot, sin, sin_cos, tan};
use crate::shape::PlacedShape;
use std::f64::consts::{FRAC_PI_2, PI};

/// Ratio of the height of the finger to the diameter of the disc: h = 0.9375 · 2 r_c (thesis Table 3.2).
pub const HEIGHT_RATIO: f64 = 0.9375;

/// Smallest contact angle φ_c22,min of the distal phalanx on the disc, 5°; it determines l21,min.
pub(crate) const TIP_CONTACT_MIN_RAD: f64 = PI / 36.0;

/// Relative tolerance when a rounded length is compared with a bound.
const SLACK: f64 = 1e-9;

/// Length of the proximal phalanx l21, absolute or as a fraction of the range that a base allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProximalLength {
    /// l21 in metres.
    Length(f64),
    /// Fraction 0 … 1 of [l21,min, l21,max].
    Fraction(f64),
}

/// The free parameters of a design.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Design {
    /// Distance along the palm from the ground joints to the centre of the disc, which lies at (−base, r_c).
    pub base_m: f64,
    pub l21: ProximalLength,
    /// Angle from the arm l22 to the distal phalanx, within (0, π).
    pub phi22_rad: f64,
    /// r_l = l22 / l11.
    pub arm_ratio: f64,
    pub l11_m: f64,
    /// Half width w of every link.
    pub half_width_m: f64,
    /// Radius r_c of the disc.
    pub object_radius_m: f64,
    /// h / (2 r_c), see [`HEIGHT_RATIO`].
    pub height_ratio: f64,
    /// φ_c22,min, see `TIP_CONTACT_MIN_RAD`.
    pub tip_contact_min_rad: f64,
}

impl Design {
    /// Returns a design of the thesis: l11 = 15 mm, w = 2.5 mm, r_c = 20 mm (Table 3.2). The arguments are the four
    /// parameters that vary (§4.2).
    pub const fn thesis(base_m: f64, l21: ProximalLength, phi22_rad: f64, arm_ratio: f64) -> Self {
        Self {
            base_m,
            l21,
            phi22_rad,
            arm_ratio,
            l11_m: 0.015,
            half_width_m: 0.0025,
            object_radius_m: 0.020,
            height_ratio: HEIGHT_RATIO,
            tip_contact_min_rad: TIP_CONTACT_MIN_RAD,
        }
    }
}

/// Error for a design without a valid finger.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DesignError {
    #[error(transparent)]
    Number(#[from] NumberError),
    #[error(
        "phi22 is {:.4} deg, but must lie between 0 and 180 deg (both excluded): the distal body is a triangle",
        .phi22_rad.to_degrees()
    )]
    Phi22 { phi22_rad: f64 },
    #[error("tip_contact_min is {:.4} deg, but must lie between -90 and 90 deg (both excluded)", .value_rad.to_degrees())]
    TipContactMin { value_rad: f64 },
    #[error("the fraction of l21 is {value}, but must lie within 0 and 1: or give l21 as a length")]
    Fraction { value: f64 },
    #[error(
        "base is {:.2$} mm, but must be above {:.2$} mm: below that the finger starts inside the object, so move it \
         away, or make the object or the links narrower",
        .base_m * 1e3, .min_m * 1e3, decimals(&[.base_m * 1e3, .min_m * 1e3], 4)
    )]
    BaseTooSmall { base_m: f64, min_m: f64 },
    #[error(
        "base is {:.2$} mm, but must be below {:.2$} mm: above that t22 touches the object at less than its \
         smallest contact angle, so move the finger nearer, or lower tip_contact_min",
        .base_m * 1e3, .max_m * 1e3, decimals(&[.base_m * 1e3, .max_m * 1e3], 4)
    )]
    BaseTooLarge { base_m: f64, max_m: f64 },
    #[error(
        "no l21 fits: it must be at least {:.4} mm to reach round the object and at most {:.4} mm to stay under the \
         height, so raise height_ratio, or lower tip_contact_min or base",
        .min_m * 1e3, .max_m * 1e3
    )]
    NoProximalRange { min_m: f64, max_m: f64 },
    #[error(
        "l21 is {:.6} mm, but this base allows {:.6} to {:.6} mm: choose within, or give a fraction of that range",
        .l21_m * 1e3, .min_m * 1e3, .max_m * 1e3
    )]
    ProximalOutOfRange { l21_m: f64, min_m: f64, max_m: f64 },
    #[error(
        "the length of the distal phalanx t22 is {:.4} mm, but must be above 0: raise height_ratio, or change l21",
        .t22_m * 1e3
    )]
    TipNotPositive { t22_m: f64 },
    #[error(transparent)]
    Contact(#[from] GraspError),
    #[error(transparent)]
    Loop(#[from] PostureError),
}

/// Returns the disc of a design: radius r_c, centre (−base, r_c).
pub fn disc(design: &Design) -> PlacedShape {
    PlacedShape::disc(design.object_radius_m, [-design.base_m, design.object_radius_m])
}

/// Returns (l21,min, l21,max) in metres, thesis (B.3) and (B.4) in closed form.
///
/// With R = r_c + w and tangent length l_c21 at angle q_c21 of the proximal phalanx:
/// * l21,min is where the l21 line meets the line tangent to the virtual circle at contact angle φ_c22,min. Both are
///   tangents of one circle, so l21,min = l_c21 + R tan(½(φ_c22,min − (q_c21 − 90°))): the line intersection (B.3)
///   with the numerator of errata 13.
/// * l21,max is where t22,min = t22,max: l21,max = (h − w + l_c21)/(1 + sin q_c21) (errata 14 in (B.4)).
pub fn proximal_range(design: &Design) -> Result<(f64, f64), DesignError> {
    check(design)?;
    let (base, w, r_c) = (design.base_m, design.half_width_m, design.object_radius_m);
    let (r, phi_min) = (r_c + w, design.tip_contact_min_rad);

    let base_min = (w * (r_c + r)).sqrt(); // D > R
    if base <= base_min {
        return Err(DesignError::BaseTooSmall { base_m: base, min_m: base_min });
    }
    let base_max = (r + r_c * sin(phi_min)) / cos(phi_min); // q_c21 < 90° + φ_min
    if base >= base_max {
        return Err(DesignError::BaseTooLarge { base_m: base, max_m: base_max });
    }

    let contact = contact_proximal(w, disc(design))?;
    let bend = phi_min - (contact.angle_rad - FRAC_PI_2);
    let min_m = contact.length_m + r * tan(0.5 * bend);
    let max_m = (height(design) - w + contact.length_m) / (1.0 + sin(contact.angle_rad));
    if !(min_m > contact.length_m && min_m <= max_m && max_m.is_finite()) {
        return Err(DesignError::NoProximalRange { min_m, max_m });
    }
    Ok((min_m, max_m))
}

/// Link lengths of a design.
///
/// t22 = ½ (t22,min + t22,max), t22,min = l21 − l_c21, t22,max = h − w − l21 sin q_c21 (thesis (B.5), (B.6), errata 14
/// and 16); l22 = r_l l11; l12² = (l11 − l22 sin φ22)² + (l21 + l22 cos φ22)² (B.7).
pub fn lengths(design: &Design) -> Result<Lengths, DesignError> {
    let (min_m, max_m) = proximal_range(design)?;
    let l21 = match design.l21 {
        ProximalLength::Fraction(f) if (0.0..=1.0).contains(&f) => (1.0 - f) * min_m + f * max_m,
        ProximalLength::Fraction(value) => return Err(DesignError::Fraction { value }),
        ProximalLength::Length(l) if l >= min_m * (1.0 - SLACK) && l <= max_m * (1.0 + SLACK) => l,
        ProximalLength::Length(l21_m) => return Err(DesignError::ProximalOutOfRange { l21_m, min_m, max_m }),
    };

    let contact = contact_proximal(design.half_width_m, disc(design))?;
    let t22_min = l21 - contact.length_m;
    let t22_max = height(design) - design.half_width_m - l21 * sin(contact.angle_rad);
    let t22 = 0.5 * (t22_min + t22_max);
    if t22.is_nan() || t22 <= 0.0 {
        return Err(DesignError::TipNotPositive { t22_m: t22 });
    }

    let (l11, l22) = (design.l11_m, design.arm_ratio * design.l11_m);
    let (s, c) = sin_cos(design.phi22_rad);
    let lengths = Lengths {
        l11_m: l11,
        l12_m: hypot(l11 - l22 * s, l21 + l22 * c),
        l21_m: l21,
        l22_m: l22,
        t22_m: t22,
        phi22_rad: design.phi22_rad,
        half_width_m: design.half_width_m,
    };
    gamma(&lengths, Assembly::Reference)?; // the loop closes, and not in a singular posture
    Ok(lengths)
}

fn height(design: &Design) -> f64 {
    design.height_ratio * 2.0 * design.object_radius_m
}

fn check(design: &Design) -> Result<(), DesignError> {
    positive(&[
        ("base_m", design.base_m),
        ("arm_ratio", design.arm_ratio),
        ("l11_m", design.l11_m),
        ("half_width_m", design.half_width_m),
        ("object_radius_m", design.object_radius_m),
        ("height_ratio", design.height_ratio),
    ])?;
    if !(design.phi22_rad > 0.0 && design.phi22_rad < PI) {
        return Err(DesignError::Phi22 { phi22_rad: design.phi22_rad });
    }
    let value_rad = design.tip_contact_min_rad;
    if value_rad.is_nan() || value_rad.abs() >= FRAC_PI_2 {
        return Err(DesignError::TipContactMin { value_rad });
    }
    Ok(())
}
