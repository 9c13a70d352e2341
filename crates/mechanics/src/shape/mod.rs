//! Shapes: every query about the outline of a body. A new shape is a new arm of the functions in this module.
//!
//! A shape is convex and symmetric about the x axis of its body: in the mirrored frame of a left finger it is the same
//! shape with the opposite angle.

use crate::numeric::Real;
use crate::numeric::elementary::{asin, atan2, hypot, sin_cos};
use crate::numeric::plane::{Vector, add, dot, perp, scale, sub};
use std::f64::consts::{PI, TAU};

/// Outline of a body, relative to its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    Disc { radius_m: f64 },
}

/// Dimensions of a shape: one or two pairs of name and value in m. They are not allocated, because studies call this
/// function often.
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

/// Outward normal at the surface point nearest to an exterior point, and the distance of the exterior point from the
/// centre along this normal.
#[inline(always)]
pub fn normal_towards<T: Real>(placed: &PlacedShape<T>, point: Vector<T>) -> (Vector<T>, T) {
    let offset = sub(point, placed.centre_m);
    match placed.shape {
        // The normal passes through the centre.
        Shape::Disc { .. } => {
            let distance = dot(offset, offset).sqrt();
            (scale(offset, distance.recip()), distance)
        }
    }
}

/// Returns the line through the origin that has the distance `distance_m` from a shape and the shape on its left.
///
/// For a disc with D² = x_c² + y_c² and R = r_c + w: q_c21 = atan2(y_c, x_c) − asin(R/D), l_c21 = √(D² − R²) (thesis
/// (B.3)).
///
/// # Errors
/// If the centre is too near to the origin, returns the smallest allowed distance, m.
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

/// Returns the second line at that distance from the shape, through the point of the first line that lies `beyond_m`
/// beyond its contact. Its angle is relative to the first line.
///
/// For a disc both tangents have the same length t = l21 − l_c21 (errata 14), and the angle is 2β with tan β = t/R.
pub fn second_tangent(placed: &PlacedShape, distance_m: f64, _first: &Tangent, beyond_m: f64) -> Tangent {
    match placed.shape {
        Shape::Disc { radius_m } => {
            Tangent { angle_rad: 2.0 * atan2(beyond_m, radius_m + distance_m), length_m: beyond_m }
        }
    }
}

/// Corners of the polygon that approximates a shape: its error is at most 1 − cos(π/96), 0.05 %, of a disc's radius.
const CORNERS: usize = 96;

/// A shape with its position and angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedShape<T = f64> {
    pub shape: Shape,
    pub centre_m: Vector<T>,
    /// Angle of the x axis of the shape.
    pub angle_rad: T,
}

/// The support function h of a shape and its derivative with respect to the angle of the direction n. The tangent line
/// normal to n touches the surface at h n + h' n⊥ from the centre.
///
/// When the body turns counter-clockwise, the distance changes at the rate −h' per rad.
#[derive(Clone, Copy, Debug)]
pub struct Support<T> {
    pub distance: T,
    pub slope: T,
}

/// A line tangent to a shape at a distance, such as the centre line of a phalanx, which is half a width from the
/// surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangent {
    pub angle_rad: f64,
    /// Distance from the start of the line to the contact.
    pub length_m: f64,
}

impl Shape {
    /// Returns the shape at a position, with its axes along those of the frame.
    pub const fn at(self, centre_m: [f64; 2]) -> PlacedShape {
        PlacedShape { shape: self, centre_m, angle_rad: 0.0 }
    }
}

impl PlacedShape {
    /// Creates a disc; its angle has no effect.
    pub const fn disc(radius_m: f64, centre_m: [f64; 2]) -> Self {
        Shape::Disc { radius_m }.at(centre_m)
    }

    /// Returns the point furthest in a direction.
    pub fn furthest_point_m(&self, direction: [f64; 2]) -> [f64; 2] {
        add(self.centre_m, support(self, direction).point(direction))
    }

    /// Returns the point nearest to the palm.
    pub fn lowest_point_m(&self) -> [f64; 2] {
        self.furthest_point_m([0.0, -1.0])
    }

    /// Corners of the inscribed polygon, counter-clockwise.
    pub fn outline_m(&self) -> Vec<[f64; 2]> {
        let direction = |k: usize| sin_cos(self.angle_rad + TAU * k as f64 / CORNERS as f64);
        (0..CORNERS).map(direction).map(|(sin, cos)| self.furthest_point_m([cos, sin])).collect()
    }

    /// Returns the shape in the frame of a finger, whose origin is half a palm width from the centre. `mirror` is −1
    /// for a left finger, whose frame is mirrored.
    #[must_use]
    #[inline(always)]
    pub fn in_finger_frame(self, mirror: f64, half_palm_m: f64) -> Self {
        let Self { shape, centre_m: [x, y], angle_rad } = self;
        Self { shape, centre_m: [mirror * x - half_palm_m, y], angle_rad: mirror * angle_rad }
    }

    /// Returns the same shape at another position.
    #[must_use]
    pub const fn at(self, centre_m: [f64; 2]) -> Self {
        Self { centre_m, ..self }
    }
}

impl<T: Real> Support<T> {
    /// Returns zero support values, for contacts without a surface, such as a joint limit.
    pub fn none() -> Self {
        Self { distance: T::zero(), slope: T::zero() }
    }

    /// Vector from the centre to the surface point of this support value.
    #[inline(always)]
    pub fn point(&self, direction: Vector<T>) -> Vector<T> {
        add(scale(direction, self.distance), scale(perp(direction), self.slope))
    }
}
