//! A shape at a position and angle in the plane.

use std::f64::consts::TAU;

use super::{Shape, support};
use crate::numeric::Real;
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{Vector, add, perp, scale};

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

/// A line tangent to a shape at a distance: the centre line of a phalanx, half a width from the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangent {
    pub angle_rad: f64,
    /// Distance from the start of the line to the contact.
    pub length_m: f64,
}

impl Shape {
    /// Returns the shape at a position, aligned with the frame.
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

    /// Returns the shape in the frame of a finger, whose ground joint is half a palm width from the centre; mirrored
    /// for a left finger (mirror −1).
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
    /// Zero support values, for contacts without a surface, such as a joint limit.
    pub fn none() -> Self {
        Self { distance: T::zero(), slope: T::zero() }
    }

    /// Vector from the centre to the surface point of this support value.
    #[inline(always)]
    pub fn point(&self, direction: Vector<T>) -> Vector<T> {
        add(scale(direction, self.distance), scale(perp(direction), self.slope))
    }
}
