//! A shape somewhere in the plane.

use std::f64::consts::TAU;

use super::{Shape, support};
use crate::numeric::Real;
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{Vector, add, perp, scale};

/// Corners of a polygon that stands for a shape: of a disc's radius it leaves out 1 − cos(π/96), 0.05 %, at most.
const CORNERS: usize = 96;

/// A shape and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed<T = f64> {
    pub shape: Shape,
    pub centre_m: Vector<T>,
    /// Of its x axis.
    pub angle_rad: T,
}

/// The support function h of a shape, with its derivative by the angle of the direction: the surface's tangent across direction n
/// touches it at h n + h' n⊥ from the centre.
///
/// As the body turns counter-clockwise, the distance grows by −h'.
#[derive(Clone, Copy, Debug)]
pub struct Support<T> {
    pub distance: T,
    pub slope: T,
}

/// A line from a point that touches a shape: the centre line of a phalanx, as far from the surface as it is half wide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangent {
    pub angle_rad: f64,
    /// From the point to where it touches.
    pub length_m: f64,
}

impl Shape {
    /// Somewhere, its x axis along that of the frame.
    pub const fn at(self, centre_m: [f64; 2]) -> Placed {
        Placed { shape: self, centre_m, angle_rad: 0.0 }
    }
}

impl Placed {
    /// A disc, whose angle shows nowhere.
    pub const fn disc(radius_m: f64, centre_m: [f64; 2]) -> Self {
        Shape::Disc { radius_m }.at(centre_m)
    }

    /// Its point that is furthest in a direction.
    pub fn furthest_m(&self, direction: [f64; 2]) -> [f64; 2] {
        add(self.centre_m, support(self, direction).point(direction))
    }

    /// Its point nearest to a palm.
    pub fn lowest_m(&self) -> [f64; 2] {
        self.furthest_m([0.0, -1.0])
    }

    /// Corners of a polygon in it, counter-clockwise.
    pub fn outline_m(&self) -> Vec<[f64; 2]> {
        let direction = |k: usize| sin_cos(self.angle_rad + TAU * k as f64 / CORNERS as f64);
        (0..CORNERS).map(direction).map(|(sin, cos)| self.furthest_m([cos, sin])).collect()
    }

    /// As the frame of a finger has it, whose ground joint is half a palm from the middle: of a left one (mirror −1) in a mirror.
    #[must_use]
    #[inline(always)]
    pub fn in_finger(self, mirror: f64, half_palm_m: f64) -> Self {
        let Self { shape, centre_m: [x, y], angle_rad } = self;
        Self { shape, centre_m: [mirror * x - half_palm_m, y], angle_rad: mirror * angle_rad }
    }

    /// The same shape elsewhere.
    #[must_use]
    pub const fn at(self, centre_m: [f64; 2]) -> Self {
        Self { centre_m, ..self }
    }
}

impl<T: Real> Support<T> {
    /// Of what has no surface.
    pub fn none() -> Self {
        Self { distance: T::zero(), slope: T::zero() }
    }

    /// From the centre to the point of the surface that it is of.
    #[inline(always)]
    pub fn point(&self, direction: Vector<T>) -> Vector<T> {
        add(scale(direction, self.distance), scale(perp(direction), self.slope))
    }
}
