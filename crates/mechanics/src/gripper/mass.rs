//! Mass, centre of mass and inertia of each body: a homogeneous outline of constant depth.

use std::f64::consts::FRAC_PI_2;

use super::outline::{outlines, polygon_moments};
use super::{Bodies, Body, Lengths, MassError};

/// Mass properties of the four bodies: m = ρ d A, I = ρ d J about the centroid (1-model §1.3).
///
/// Density in kg/m³, depth in metres. Each body is in its own frame: origin at the preceding joint (O, O, A12, A22), x
/// along the link, along the arm A22 → A13 for the distal body.
pub fn bodies(lengths: &Lengths, density_kg_m3: f64, depth_m: f64) -> Result<Bodies, MassError> {
    let positive = [
        ("l11_m", lengths.l11_m),
        ("l12_m", lengths.l12_m),
        ("l21_m", lengths.l21_m),
        ("l22_m", lengths.l22_m),
        ("t22_m", lengths.t22_m),
        ("half_width_m", lengths.half_width_m),
        ("density_kg_m3", density_kg_m3),
        ("depth_m", depth_m),
    ];
    if let Some(&(name, value)) = positive.iter().find(|(_, v)| !(v.is_finite() && *v > 0.0)) {
        return Err(MassError::NotPositive { name, value });
    }
    let outlines = outlines(lengths)?;
    let areal = density_kg_m3 * depth_m;
    Ok(Bodies {
        l11: body("l11", &outlines.l11_m, areal)?,
        l12: body("l12", &outlines.l12_m, areal)?,
        l21: body("l21", &outlines.l21_m, areal)?,
        l22: body("l22", &outlines.l22_m, areal)?,
    })
}

/// Mass properties specified for one body, instead of those computed from its outline.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyOverride {
    pub mass_kg: Option<f64>,
    pub com_m: Option<[f64; 2]>,
    pub inertia_kg_m2: Option<f64>,
}

impl BodyOverride {
    pub fn is_complete(&self) -> bool {
        self.mass_kg.is_some() && self.com_m.is_some() && self.inertia_kg_m2.is_some()
    }

    /// Applies the override. A mass without an inertia preserves the radius of gyration of the outline.
    pub fn apply(&self, outline: Body) -> Body {
        let mass_kg = self.mass_kg.unwrap_or(outline.mass_kg);
        let scale = self.mass_kg.map_or(1.0, |m| m / outline.mass_kg);
        Body {
            mass_kg,
            com_m: self.com_m.unwrap_or(outline.com_m),
            inertia_kg_m2: self.inertia_kg_m2.unwrap_or(outline.inertia_kg_m2 * scale),
        }
    }
}

/// [`bodies`] with overrides for l11, l12, l21 and l22.
pub fn bodies_with_overrides(
    lengths: &Lengths,
    density_kg_m3: f64,
    depth_m: f64,
    overrides: &[BodyOverride; 4],
) -> Result<Bodies, MassError> {
    // The outline of a completely overridden distal body is irrelevant, even if it is degenerate.
    let phi22_rad = if overrides[3].is_complete() { FRAC_PI_2 } else { lengths.phi22_rad };
    let outline = bodies(&Lengths { phi22_rad, ..*lengths }, density_kg_m3, depth_m)?;
    let [l11, l12, l21, l22] = overrides;
    Ok(Bodies {
        l11: l11.apply(outline.l11),
        l12: l12.apply(outline.l12),
        l21: l21.apply(outline.l21),
        l22: l22.apply(outline.l22),
    })
}

/// Mass of all four bodies.
pub fn total_mass(bodies: &Bodies) -> f64 {
    bodies.l11.mass_kg + bodies.l12.mass_kg + bodies.l21.mass_kg + bodies.l22.mass_kg
}

fn body(name: &'static str, outline: &[[f64; 2]], areal_kg_m2: f64) -> Result<Body, MassError> {
    let moments = polygon_moments(outline);
    let (mass_kg, inertia_kg_m2) = (areal_kg_m2 * moments.area_m2, areal_kg_m2 * moments.second_moment_m4);
    let is_positive = |v: f64| v.is_finite() && v > 0.0;
    if !(is_positive(mass_kg) && is_positive(inertia_kg_m2)) {
        return Err(MassError::OutOfRange { name, mass_kg, inertia_kg_m2 });
    }
    Ok(Body { mass_kg, com_m: moments.centroid_m, inertia_kg_m2 })
}
