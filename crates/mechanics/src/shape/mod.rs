//! What a shape is: all that anything asks of the outline of a body. Another shape is another arm of the functions here.
//!
//! A shape is convex, and its own mirror image about the x axis of its body: what a left finger sees in its mirror is the same shape,
//! turned the other way.
//!
//! | file | job |
//! |---|---|
//! | `placed` | a shape somewhere in the plane, its support function there, and a line that touches it |

mod placed;

use std::f64::consts::PI;

use crate::numeric::Real;
use crate::numeric::elementary::{asin, atan2, hypot};
use crate::numeric::plane::{Vector, dot, scale, sub};

pub use placed::{Placed, Support, Tangent};

/// An outline about the centre of its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    Disc { radius_m: f64 },
}

/// What says how large it is, one or two lengths: the name of each, and that in m. A study asks by the million, so it is no list.
pub fn sizes(shape: &Shape) -> impl Iterator<Item = (&'static str, f64)> + use<> {
    let sizes = match shape {
        Shape::Disc { radius_m } => [Some(("radius", *radius_m)), None],
    };
    sizes.into_iter().flatten()
}

/// The radius of one that is a circle about its centre, m: how it is turned shows nowhere.
#[inline(always)]
pub fn round(shape: &Shape) -> Option<f64> {
    match shape {
        Shape::Disc { radius_m } => Some(*radius_m),
    }
}

/// How far from its centre any of it is, m: the length by which the others of a scene are measured.
pub fn reach(shape: &Shape) -> f64 {
    match shape {
        Shape::Disc { radius_m } => *radius_m,
    }
}

/// Radius of curvature by which Hertz's law counts it, m.
pub fn curvature(shape: &Shape) -> f64 {
    match shape {
        Shape::Disc { radius_m } => *radius_m,
    }
}

/// Mass of one of a density (kg/m³), so deep out of the plane (m), kg.
pub fn mass(shape: &Shape, density_kg_m3: f64, depth_m: f64) -> f64 {
    match shape {
        Shape::Disc { radius_m } => density_kg_m3 * PI * radius_m * radius_m * depth_m,
    }
}

/// Moment of inertia of a homogeneous one about its centre, kg·m².
pub fn inertia(shape: &Shape, mass_kg: f64) -> f64 {
    match shape {
        Shape::Disc { radius_m } => mass_kg * radius_m * radius_m / 2.0,
    }
}

/// How far the surface is from the centre in a direction (a unit vector of the frame that the shape is placed in).
#[inline(always)]
pub fn support<T: Real>(placed: &Placed<T>, _direction: Vector<T>) -> Support<T> {
    match placed.shape {
        Shape::Disc { radius_m } => Support { distance: T::constant(radius_m), slope: T::zero() },
    }
}

/// The outward normal where the surface is nearest to a point beyond it, and how far along that the point is from the centre.
#[inline(always)]
pub fn seen_from<T: Real>(placed: &Placed<T>, point: Vector<T>) -> (Vector<T>, T) {
    let away = sub(point, placed.centre_m);
    match placed.shape {
        Shape::Disc { .. } => along(away),
    }
}

/// The normal where two surfaces are nearest to each other, from the second to the first, and how far apart the centres are along it.
#[inline(always)]
pub fn facing<T: Real>([first, second]: [&Placed<T>; 2]) -> (Vector<T>, T) {
    let away = sub(first.centre_m, second.centre_m);
    match (first.shape, second.shape) {
        (Shape::Disc { .. }, Shape::Disc { .. }) => along(away),
    }
}

/// Of round ones every normal goes through the centre.
#[inline(always)]
fn along<T: Real>(away: Vector<T>) -> (Vector<T>, T) {
    let distance = dot(away, away).sqrt();
    (scale(away, distance.recip()), distance)
}

/// The line from the origin that has a shape to its left, at this distance; how near the origin may be to the centre, m, where it is nearer.
///
/// With D² = x_c² + y_c² and R = r_c + w of a disc: q_c21 = atan2(y_c, x_c) − asin(R/D), l_c21 = √(D² − R²) (thesis (B.3)).
pub fn tangent(placed: &Placed, distance_m: f64) -> Result<Tangent, f64> {
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

/// The other line at that distance from a point of the first one, so far beyond where that touches; its angle counts from the first one's.
///
/// Of a disc both are equally long: t = l21 − l_c21 (errata 14), and the angle is 2β with tan β = t/R.
pub fn other_tangent(placed: &Placed, distance_m: f64, _first: &Tangent, beyond_m: f64) -> Tangent {
    match placed.shape {
        Shape::Disc { radius_m } => {
            Tangent { angle_rad: 2.0 * atan2(beyond_m, radius_m + distance_m), length_m: beyond_m }
        }
    }
}
