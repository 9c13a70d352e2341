//! Contact geometry in closed form: a phalanx is a capsule, the object a shape (thesis (B.1)–(B.2), errata 5).

pub use crate::fivebar::capsule::{Capsule, Nearest, nearest};
use crate::fivebar::kinematics::{Directions, PassiveRates};
use crate::numeric::Real;
use crate::numeric::plane::{Vector, dot, perp, rotate, scale_by, sub};
use crate::shape::{Placed, Support};

/// Geometry of one unilateral contact: gap, and the rows that give its rates from q̇_a.
#[derive(Clone, Copy, Debug)]
pub struct Geometry<T> {
    /// Distance between the surfaces; −δ in penetration.
    pub gap: T,
    /// Rate of the gap = normal_row · q̇_a.
    pub normal_row: [T; 2],
    /// Slip velocity = tangent_row · q̇_a.
    pub tangent_row: [T; 2],
    /// From the object to the phalanx.
    pub normal: Vector<T>,
    /// On the surface of the phalanx.
    pub point: Vector<T>,
    /// Of the object along the normal.
    pub support: Support<T>,
}

/// Contact of l21: a body turning about O at q̇21.
#[inline(always)]
pub fn proximal<T: Real>(pose: &Directions<T>, l21: f64, w: f64, object: &Placed<T>) -> Geometry<T> {
    let capsule = Capsule { base: [T::zero(); 2], axis: pose.e2, length: l21, radius: w };
    let Nearest { foot, normal, gap, support } = nearest(&capsule, object);
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

/// Shape of the distal phalanx: its lengths, and φ22 as (cos, sin).
#[derive(Clone, Copy, Debug)]
pub struct Distal {
    pub l21: f64,
    pub t22: f64,
    pub w: f64,
    pub phi22: [f64; 2],
}

/// Contact of t22: A22 moves with l21, and the body turns about it at θ̇4.
#[inline(always)]
pub fn distal<T: Real>(
    pose: &Directions<T>,
    rates: &PassiveRates<T>,
    shape: &Distal,
    object: &Placed<T>,
) -> Geometry<T> {
    let base = scale_by(pose.e2, shape.l21);
    let capsule = Capsule { base, axis: rotate(pose.e4, shape.phi22), length: shape.t22, radius: shape.w };
    let Nearest { foot, normal, gap, support } = nearest(&capsule, object);
    let point = sub(foot, scale_by(normal, shape.w));
    let arm = perp(sub(point, base));
    let row = |direction| {
        let turning = dot(arm, direction);
        [turning * rates.a4[0], turning * rates.a4[1] + dot(perp(base), direction)]
    };
    Geometry { gap, normal_row: row(normal), tangent_row: row(perp(normal)), normal, point, support }
}
