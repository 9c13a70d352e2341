//! Gap and contact normal between a phalanx (a capsule) and a shape (thesis (B.1)–(B.2)).

use crate::numeric::Real;
use crate::numeric::plane::{Vector, add, cross, dot, perp, scale, scale_by, sub};
use crate::shape::{PlacedShape, Support, normal_towards, support};

/// A phalanx: the segment from `base` along the unit vector `axis`, with a radius.
#[derive(Clone, Copy, Debug)]
pub struct Capsule<T> {
    pub base: Vector<T>,
    pub axis: Vector<T>,
    pub length: f64,
    pub radius: f64,
}

impl Capsule<f64> {
    /// Returns the capsule around the segment between two points.
    pub fn between(from: Vector<f64>, to: Vector<f64>, radius: f64) -> Self {
        let along = sub(to, from);
        let length = dot(along, along).sqrt();
        Capsule { base: from, axis: scale(along, 1.0 / length), length, radius }
    }
}

/// Closest points of a phalanx and a shape.
#[derive(Clone, Copy, Debug)]
pub struct ClosestPoints<T> {
    /// Point on the centre line of the phalanx.
    pub foot: Vector<T>,
    /// Unit normal from the shape to the phalanx.
    pub normal: Vector<T>,
    pub gap: T,
    /// Support value of the shape along the normal.
    pub support: Support<T>,
}

/// Finds the closest points. On the face the normal is ± the axis rotated by 90°; beyond an end it points from the
/// shape to that end (the slip to the tip of (2.29)).
#[inline(always)]
pub fn closest_points<T: Real>(capsule: &Capsule<T>, placed: &PlacedShape<T>) -> ClosestPoints<T> {
    let to_centre = sub(placed.centre_m, capsule.base);
    let offset = cross(capsule.axis, to_centre);
    let side = if offset.value() >= 0.0 { -1.0 } else { 1.0 };
    let normal = scale_by(perp(capsule.axis), side);
    let face_support = support(placed, normal);
    // The normal rotated by 90° is −side times the axis.
    let along = dot(to_centre, capsule.axis) - face_support.slope * side;
    let s = along.value();
    if s > 0.0 && s < capsule.length {
        let gap = offset * -side - (face_support.distance + capsule.radius);
        return ClosestPoints {
            foot: add(capsule.base, scale(capsule.axis, along)),
            normal,
            gap,
            support: face_support,
        };
    }
    let end = if s <= 0.0 { capsule.base } else { add(capsule.base, scale_by(capsule.axis, capsule.length)) };
    let (normal, distance) = normal_towards(placed, end);
    let support = support(placed, normal);
    ClosestPoints { foot: end, normal, gap: distance - (support.distance + capsule.radius), support }
}
