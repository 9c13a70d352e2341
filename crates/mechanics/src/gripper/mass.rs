//! Mass, centre of mass and inertia of each body: a homogeneous outline of constant depth, a polygon in the body's
//! frame.
//!
//! Frames: origin at the preceding joint (O for l11 and l21, A12 for l12, A22 for the distal body), x along the link
//! (along the arm A22 → A13 for the distal body). Corners are counter-clockwise.

use std::f64::consts::FRAC_PI_2;

use super::{Bodies, Body, Lengths, NumberError, positive};
use crate::numeric::elementary::{hypot, sin_cos};
use crate::numeric::plane::{cross, dot, sub};

/// Returns the mass properties of the four bodies: m = ρ d A, I = ρ d J about the centroid.
///
/// The density ρ is in kg/m³, the depth d in metres. Each body has its own frame. Its origin is at the preceding joint
/// (O, O, A12, A22). Its x axis is along the link; for the distal body, along the arm A22 → A13.
pub fn bodies(lengths: &Lengths, density_kg_m3: f64, depth_m: f64) -> Result<Bodies, MassError> {
    positive(&[
        ("l11_m", lengths.l11_m),
        ("l12_m", lengths.l12_m),
        ("l21_m", lengths.l21_m),
        ("l22_m", lengths.l22_m),
        ("t22_m", lengths.t22_m),
        ("half_width_m", lengths.half_width_m),
        ("density_kg_m3", density_kg_m3),
        ("depth_m", depth_m),
    ])?;
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

    /// Applies the override. If a mass is given without an inertia, the radius of gyration of the outline is kept.
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

/// Like [`bodies`], with overrides for l11, l12, l21 and l22.
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

/// Smallest ratio of the inradius of the distal triangle to its longest side; below it the triangle is degenerate.
const MIN_INRADIUS_RATIO: f64 = 1e-6;

/// Error for link lengths without valid mass properties.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MassError {
    #[error(transparent)]
    Number(#[from] NumberError),
    #[error(
        "the distal body is not a triangle: l22 = {:.4} mm and t22 = {:.4} mm at phi22 = {:.4} deg are collinear, but phi22 \
         must differ from 0 and 180 deg, or the scene must give mass, centre and inertia of the body",
        .l22_m * 1e3, .t22_m * 1e3, .phi22_rad.to_degrees()
    )]
    DegenerateTriangle { phi22_rad: f64, l22_m: f64, t22_m: f64 },
    #[error(
        "body {name} has mass {mass_kg} kg and inertia {inertia_kg_m2} kg m², but both must be finite and \
         above 0: check lengths, density and depth"
    )]
    OutOfRange { name: &'static str, mass_kg: f64, inertia_kg_m2: f64 },
}

/// The outlines of the four moving bodies, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outlines {
    pub l11_m: [[f64; 2]; 4],
    pub l12_m: [[f64; 2]; 4],
    pub l21_m: [[f64; 2]; 4],
    /// The distal body: corners beyond A22, A13 and the end of the tip, in counter-clockwise order.
    pub l22_m: [[f64; 2]; 3],
}

/// Area moments of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolygonMoments {
    /// Positive for counter-clockwise corners.
    pub area_m2: f64,
    pub centroid_m: [f64; 2],
    /// ∫ r² dA about the centroid (polar second moment).
    pub second_moment_m4: f64,
}

/// Rectangle (L + 2w) × 2w centred on a link of length L that runs from the origin along x.
pub fn link_outline(length_m: f64, half_width_m: f64) -> [[f64; 2]; 4] {
    let (x0, x1, w) = (-half_width_m, length_m + half_width_m, half_width_m);
    [[x0, -w], [x1, -w], [x1, w], [x0, w]]
}

/// Returns the triangle A22–A13–tip end, every side moved outwards by w, with sharp (mitred) corners.
///
/// The result is similar to the inner triangle about their common incentre, with ratio (r_in + w)/r_in, where the
/// inradius is r_in = 2 area / perimeter. The flatter the triangle, the longer the mitred corners grow.
pub fn tip_outline(lengths: &Lengths) -> Result<[[f64; 2]; 3], MassError> {
    let (l22, t22, phi, w) = (lengths.l22_m, lengths.t22_m, lengths.phi22_rad, lengths.half_width_m);
    let (s, c) = sin_cos(phi);
    let inner = [[0.0, 0.0], [l22, 0.0], [t22 * c, t22 * s]];

    // The incentre is the mean of the corners weighted by the lengths of their opposite sides.
    let (a, b) = (t22, l22);
    let opposite = [hypot(l22 - t22 * c, t22 * s), a, b];
    let perimeter: f64 = opposite.iter().sum();
    let r_in = (l22 * t22 * s).abs() / perimeter;
    let longest = opposite.iter().copied().fold(0.0, f64::max);
    if r_in.is_nan() || r_in <= MIN_INRADIUS_RATIO * longest {
        return Err(MassError::DegenerateTriangle { phi22_rad: phi, l22_m: l22, t22_m: t22 });
    }
    let incentre = [0, 1].map(|k| (0..3).map(|i| opposite[i] * inner[i][k]).sum::<f64>() / perimeter);
    let ratio = (r_in + w) / r_in;
    let mut outline = inner.map(|p| [0, 1].map(|k| incentre[k] + ratio * (p[k] - incentre[k])));
    if s < 0.0 {
        outline.swap(1, 2); // keep it counter-clockwise
    }
    Ok(outline)
}

/// Outlines of all four bodies.
pub fn outlines(lengths: &Lengths) -> Result<Outlines, MassError> {
    let w = lengths.half_width_m;
    Ok(Outlines {
        l11_m: link_outline(lengths.l11_m, w),
        l12_m: link_outline(lengths.l12_m, w),
        l21_m: link_outline(lengths.l21_m, w),
        l22_m: tip_outline(lengths)?,
    })
}

/// Area, centroid and polar second moment about the centroid of a simple polygon (shoelace sums).
///
/// With c_i = x_i y_{i+1} − x_{i+1} y_i: A = ½ Σ c_i, centroid = Σ c_i (p_i + p_{i+1}) / (6 A), and with corners taken
/// from the centroid J = (1/12) Σ c_i (p_i·p_i + p_i·p_{i+1} + p_{i+1}·p_{i+1}). The sums start from the first corner
/// and from the centroid, so a polygon far from the origin loses no accuracy. Fewer than three corners, or collinear
/// corners, have area 0, the first corner (or the origin) as centroid, and no second moment.
pub fn polygon_moments(corners: &[[f64; 2]]) -> PolygonMoments {
    let first = corners.first().copied().unwrap_or([0.0, 0.0]);
    let (mut twice_area, mut sum) = (0.0, [0.0, 0.0]);
    for (p, q, c) in edges(corners, first) {
        twice_area += c;
        sum[0] += c * (p[0] + q[0]);
        sum[1] += c * (p[1] + q[1]);
    }
    if twice_area == 0.0 {
        return PolygonMoments { area_m2: 0.0, centroid_m: first, second_moment_m4: 0.0 };
    }
    let centroid_m = [0, 1].map(|k| first[k] + sum[k] / (3.0 * twice_area));
    let j: f64 = edges(corners, centroid_m).map(|(p, q, c)| c * (dot(p, p) + dot(p, q) + dot(q, q))).sum::<f64>();
    PolygonMoments { area_m2: 0.5 * twice_area, centroid_m, second_moment_m4: j / 12.0 * twice_area.signum() }
}

/// Edges of the polygon with corners taken from `origin`, each with its cross product.
fn edges(corners: &[[f64; 2]], origin: [f64; 2]) -> impl Iterator<Item = ([f64; 2], [f64; 2], f64)> + '_ {
    corners.iter().zip(corners.iter().cycle().skip(1)).map(move |(p, q)| {
        let [p, q] = [*p, *q].map(|corner| sub(corner, origin));
        (p, q, cross(p, q))
    })
}
