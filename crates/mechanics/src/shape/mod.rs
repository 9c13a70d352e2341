//! Shapes: every query about the outline of a body. A new shape is a new arm of the functions in this module.
//!
//! A shape is convex and symmetric about the x axis of its body: in the mirrored frame of a left finger it is the same
//! shape with the opposite angle.
//!
//! | file | job |
//! |---|---|
//! | `placed` | a shape at a position and angle, its support function, and tangent lines |

mod placed;

use std::f64::consts::PI;

use crate::numeric::Real;
use crate::numeric::elementary::{asin, atan2, hypot};
use crate::numeric::plane::{Vector, dot, scale, sub};

pub use placed::{PlacedShape, Support, Tangent};

/// Outline of a body, relative to its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    Disc { radius_m: f64 },
}

/// Dimensions of a shape, one or two lengths: name and value in m. Called millions of times in a study, hence no
/// allocation.
pub fn dimensions(shape: &Shape) -> impl Iterator<Item = (&'static str, f64)> + use<> {
    let sizes = match shape {
        Shape::Disc { radius_m } => [Some(("radius", *radius_m)), None],
    };
    sizes.into_iter().flatten()
}

/// Radius of a circular shape, m; its orientation has no effect.
#[inline(always)]
pub fn circle_radius(shape: &Shape) -> Option<f64> {
    match shape {
        Shape::Disc { radius_m } => Some(*radius_m),
    }
}

/// Largest distance of the outline from the centre, m: the reference length of a scene.
pub fn max_radius(shape: &Shape) -> f64 {
    match shape {
        Shape::Disc { radius_m } => *radius_m,
    }
}

/// Radius of curvature for Hertz's law, m.
pub fn curvature_radius(shape: &Shape) -> f64 {
    match shape {
        Shape::Disc { radius_m } => *radius_m,
    }
}

/// Mass of a homogeneous body of this density (kg/m³) and depth out of the plane (m), kg.
pub fn mass(shape: &Shape, density_kg_m3: f64, depth_m: f64) -> f64 {
    match shape {
        Shape::Disc { radius_m } => density_kg_m3 * PI * radius_m * radius_m * depth_m,
    }
}

/// Moment of inertia of a homogeneous body about its centre, kg·m².
pub fn inertia(shape: &Shape, mass_kg: f64) -> f64 {
    match shape {
        Shape::Disc { radius_m } => mass_kg * radius_m * radius_m / 2.0,
    }
}

/// Support function of a shape in a direction (a unit vector of the frame in which the shape is placed).
#[inline(always)]
pub fn support<T: Real>(placed: &PlacedShape<T>, _direction: Vector<T>) -> Support<T> {
    match placed.shape {
        Shape::Disc { radius_m } => Support { distance: T::constant(radius_m), slope: T::zero() },
    }
}

/// Outward normal at the surface point nearest to an exterior point, and the distance of that point from the centre
/// along the normal.
#[inline(always)]
pub fn normal_towards<T: Real>(placed: &PlacedShape<T>, point: Vector<T>) -> (Vector<T>, T) {
    let offset = sub(point, placed.centre_m);
    match placed.shape {
        Shape::Disc { .. } => unit_and_length(offset),
    }
}

/// Normal at the closest points of two surfaces, from the second to the first, and the distance of the centres along
/// it.
#[inline(always)]
pub fn normal_between<T: Real>([first, second]: [&PlacedShape<T>; 2]) -> (Vector<T>, T) {
    let offset = sub(first.centre_m, second.centre_m);
    match (first.shape, second.shape) {
        (Shape::Disc { .. }, Shape::Disc { .. }) => unit_and_length(offset),
    }
}

/// Direction and length of a vector. Every normal of a circular shape passes through its centre.
#[inline(always)]
fn unit_and_length<T: Real>(offset: Vector<T>) -> (Vector<T>, T) {
    let distance = dot(offset, offset).sqrt();
    (scale(offset, distance.recip()), distance)
}

/// Returns the line through the origin that passes a shape on its left at this distance.
///
/// For a disc with D² = x_c² + y_c² and R = r_c + w: q_c21 = atan2(y_c, x_c) − asin(R/D), l_c21 = √(D² − R²) (thesis
/// (B.3)).
///
/// # Errors
/// Returns the smallest allowed distance of the centre from the origin, m, if the centre is nearer.
pub fn tangent(placed: &PlacedShape, distance_m: f64) -> Result<Tangent, f64> {
    let [x, y] = placed.centre_m;
    match placed.shape {
        Shape::Disc { radius_m } => {
            let (r, d) = (radius_m + distance_m, hypot(x, y));
            if !(d > r && d.is_finite()) {
                return Err(r);
            }
            Ok(Tangent { angle_rad: atan2(y, x) - asin(r / d), length_m: ((d - r) * (d + r)).sqrt() })
        }
    }
}

/// Returns the second line at that distance, through the point of the first line `beyond_m` behind its contact. Its
/// angle is relative to the first line.
///
/// For a disc both tangents have the same length t = l21 − l_c21 (errata 14), and the angle is 2β with tan β = t/R.
pub fn second_tangent(placed: &PlacedShape, distance_m: f64, _first: &Tangent, beyond_m: f64) -> Tangent {
    match placed.shape {
        Shape::Disc { radius_m } => {
            Tangent { angle_rad: 2.0 * atan2(beyond_m, radius_m + distance_m), length_m: beyond_m }
        }
    }
}
