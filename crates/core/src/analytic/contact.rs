//! Contact geometry in closed form: a phalanx is a capsule, the object a shape (thesis (B.1)–(B.2), errata 5).

pub use crate::fivebar::capsule::{Capsule, ClosestPoints, closest_points};
use crate::fivebar::kinematics::{Directions, PassiveRates};
use crate::numeric::Real;
use crate::numeric::plane::{Vector, dot, perp, rotate, scale_by, sub};
use crate::shape::{PlacedShape, Support};

/// Geometry of one unilateral contact: the gap, and the rows that give gap rate and slip from q̇_a.
#[derive(Clone, Copy, Debug)]
pub struct Geometry<T> {
    /// Distance between the surfaces; −δ in penetration.
    pub gap: T,
    /// Rate of the gap = normal_row · q̇_a.
    pub normal_row: [T; 2],
    /// Slip velocity = tangent_row · q̇_a.
    pub tangent_row: [T; 2],
    /// Unit normal from the object to the phalanx.
    pub normal: Vector<T>,
    /// Contact point on the surface of the phalanx.
    pub point: Vector<T>,
    /// Support function of the object along the normal.
    pub support: Support<T>,
}

/// Contact of l21, a body that rotates about O at q̇21.
#[inline(always)]
pub fn proximal<T: Real>(pose: &Directions<T>, l21: f64, w: f64, object: &PlacedShape<T>) -> Geometry<T> {
    let capsule = Capsule { base: [T::zero(); 2], axis: pose.e2, length: l21, radius: w };
    let ClosestPoints { foot, normal, gap, support } = closest_points(&capsule, object);
    let point = sub(foot, scale_by(normal, w));
    let lever = |direction| dot(perp(point), direction);
    Geometry {
        gap,
        normal_row: [T::zero(), lever(normal)],
        tangent_row: [T::zero(), lever(perp(normal))],
        normal,
        point,
        support,
    }
}

/// Dimensions of the distal phalanx; φ22 is given as (cos, sin).
#[derive(Clone, Copy, Debug)]
pub struct DistalShape {
    pub l21: f64,
    pub t22: f64,
    pub w: f64,
    pub phi22: [f64; 2],
}

/// Contact geometry of t22. A22 moves with l21, and the distal body rotates about A22 at θ̇4.
#[inline(always)]
pub fn distal<T: Real>(
    pose: &Directions<T>,
    rates: &PassiveRates<T>,
    shape: &DistalShape,
    object: &PlacedShape<T>,
) -> Geometry<T> {
    let base = scale_by(pose.e2, shape.l21);
    let capsule = Capsule { base, axis: rotate(pose.e4, shape.phi22), length: shape.t22, radius: shape.w };
    let ClosestPoints { foot, normal, gap, support } = closest_points(&capsule, object);
    let point = sub(foot, scale_by(normal, shape.w));
    let arm = perp(sub(point, base));
    let row = |direction| {
        let lever = dot(arm, direction);
        [lever * rates.a4[0], lever * rates.a4[1] + dot(perp(base), direction)]
    };
    Geometry { gap, normal_row: row(normal), tangent_row: row(perp(normal)), normal, point, support }
}
