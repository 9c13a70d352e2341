//! Kinematics of one contact between the object, of any shape, and a phalanx or a plane: the gap, and the rows that give gap
//! rate and slip.
//!
//! The surface of the object is at h n + h' n⊥ from its centre, with its support function h and the derivative h'
//! ([`Support`]). The contact point is on the surface of the phalanx or plane, so the object's lever arm is h − δ. Both
//! bodies then receive opposite forces at the same point, and momentum and angular momentum are exchanged exactly.

use crate::analytic::contact::{ContactKinematics, Geometry};
use crate::numeric::Real;
use crate::numeric::plane::{Vector, add, dot, perp, scale, sub};
use crate::shape::{PlacedShape, Support, support};

use super::components::Plane;

/// Returns the contact kinematics of a phalanx against a moving object, on (q11, q21, x, y, θ) in the finger's frame.
#[inline(always)]
pub fn phalanx<T: Real>(geometry: &Geometry<T>) -> ContactKinematics<T, 5> {
    let Geometry { gap, normal_row, tangent_row, normal, point, support } = *geometry;
    let tangent = perp(normal);
    ContactKinematics {
        gap,
        normal_row: [normal_row[0], normal_row[1], -normal[0], -normal[1], support.slope],
        tangent_row: [tangent_row[0], tangent_row[1], -tangent[0], -tangent[1], -(gap + support.distance)],
        normal,
        point,
    }
}

/// Contact kinematics of the object on a plane, on (x, y, θ).
#[inline(always)]
pub fn plane<T: Real>(plane: &Plane, placed: &PlacedShape<T>) -> ContactKinematics<T, 3> {
    let normal: Vector<T> = [T::constant(plane.normal[0]), T::constant(plane.normal[1])];
    let tangent = perp(normal);
    let Support { distance, slope } = support(placed, [-normal[0], -normal[1]]);
    let gap = dot(normal, placed.centre_m) + (-distance + plane.offset);
    let lever = gap + distance;
    ContactKinematics {
        gap,
        normal_row: [normal[0], normal[1], slope],
        tangent_row: [tangent[0], tangent[1], -lever],
        normal,
        point: sub(add(placed.centre_m, scale(normal, -lever)), scale(tangent, slope)),
    }
}

/// Returns the kinematics of the joint limit, on a finger's coordinates.
#[inline(always)]
pub fn limit<T: Real>(geometry: &Geometry<T>) -> ContactKinematics<T, 2> {
    let Geometry { gap, normal_row, tangent_row, normal, point, .. } = *geometry;
    ContactKinematics { gap, normal_row, tangent_row, normal, point }
}
