//! A phalanx is a capsule, the object a shape: how far apart they are, and along which normal (thesis (B.1)–(B.2)).

use crate::numeric::Real;
use crate::numeric::plane::{Vector, add, cross, dot, perp, scale, scale_by, sub};
use crate::shape::{Placed, Support, seen_from, support};

/// A phalanx in the world: segment from `base` along unit `axis`.
#[derive(Clone, Copy, Debug)]
pub struct Capsule<T> {
    pub base: Vector<T>,
    pub axis: Vector<T>,
    pub length: f64,
    pub radius: f64,
}

impl Capsule<f64> {
    /// Of the segment between two points.
    pub fn between(from: Vector<f64>, to: Vector<f64>, radius: f64) -> Self {
        let along = sub(to, from);
        let length = dot(along, along).sqrt();
        Capsule { base: from, axis: scale(along, 1.0 / length), length, radius }
    }
}

/// Where the surfaces of a phalanx and of a shape are nearest to each other.
#[derive(Clone, Copy, Debug)]
pub struct Nearest<T> {
    /// On the centre line.
    pub foot: Vector<T>,
    /// Shape → phalanx.
    pub normal: Vector<T>,
    pub gap: T,
    /// Of the shape along the normal.
    pub support: Support<T>,
}

/// On the face the normal is ± the axis turned by 90°; past an end it turns about that end (the slip to the tip of (2.29)).
#[inline(always)]
pub fn nearest<T: Real>(capsule: &Capsule<T>, placed: &Placed<T>) -> Nearest<T> {
    let to_centre = sub(placed.centre_m, capsule.base);
    let offset = cross(capsule.axis, to_centre);
    let side = if offset.value() >= 0.0 { -1.0 } else { 1.0 };
    let normal = scale_by(perp(capsule.axis), side);
    let of_face = support(placed, normal);
    // n⊥ is −side times the axis.
    let along = dot(to_centre, capsule.axis) - of_face.slope * side;
    let s = along.value();
    if s > 0.0 && s < capsule.length {
        let gap = offset * -side - (of_face.distance + capsule.radius);
        return Nearest { foot: add(capsule.base, scale(capsule.axis, along)), normal, gap, support: of_face };
    }
    let end = if s <= 0.0 { capsule.base } else { add(capsule.base, scale_by(capsule.axis, capsule.length)) };
    let (normal, distance) = seen_from(placed, end);
    let support = support(placed, normal);
    Nearest { foot: end, normal, gap: distance - (support.distance + capsule.radius), support }
}
