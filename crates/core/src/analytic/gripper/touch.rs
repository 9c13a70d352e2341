//! A phalanx or a plane against the object: gap, and the rows that give its rate and the slip.
//!
//! The contact point is on the surface of the phalanx or plane, so the object's lever arm is r − δ, and both sides feel opposite forces at
//! one point: momentum and angular momentum are exchanged exactly.

use super::model::Plane;
use crate::analytic::contact::Geometry;
use crate::analytic::mode::SiteState;
use crate::law::{FrictionLaw, NormalLaw, friction_force, normal_over_gap};
use crate::numeric::Real;
use crate::numeric::plane::{Vector, add, dot, perp, scale};

use super::branch;

/// One contact, on K coordinates: a finger's two and the object's three in its frame, the object's three, or a finger's two (limit).
#[derive(Clone, Copy, Debug)]
pub struct Touch<T, const K: usize> {
    pub gap: T,
    pub normal_row: [T; K],
    pub tangent_row: [T; K],
    /// From the second surface to the first: object to phalanx, plane to object.
    pub normal: Vector<T>,
    pub point: Vector<T>,
}

/// A phalanx against the object, which moves too: on (q11, q21, x, y, θ) as the finger's frame has them.
#[inline(always)]
pub fn phalanx<T: Real>(geometry: &Geometry<T>, radius: f64) -> Touch<T, 5> {
    let Geometry { gap, normal_row, tangent_row, normal, point } = *geometry;
    let tangent = perp(normal);
    Touch {
        gap,
        normal_row: [normal_row[0], normal_row[1], -normal[0], -normal[1], T::zero()],
        tangent_row: [tangent_row[0], tangent_row[1], -tangent[0], -tangent[1], -(gap + radius)],
        normal,
        point,
    }
}

/// The object on a plane: on (x, y, θ).
#[inline(always)]
pub fn plane<T: Real>(plane: &Plane, centre: Vector<T>, radius: f64) -> Touch<T, 3> {
    let normal: Vector<T> = plane.normal.map(T::constant);
    let tangent = perp(normal);
    let gap = dot(normal, centre) + (plane.offset - radius);
    let lever = gap + radius;
    Touch {
        gap,
        normal_row: [normal[0], normal[1], T::zero()],
        tangent_row: [tangent[0], tangent[1], -lever],
        normal,
        point: add(centre, scale(normal, -lever)),
    }
}

/// Of the joint limit.
#[inline(always)]
pub fn limit<T: Real>(geometry: &Geometry<T>) -> Touch<T, 2> {
    let Geometry { gap, normal_row, tangent_row, normal, point } = *geometry;
    Touch { gap, normal_row, tangent_row, normal, point }
}

/// What a contact that presses does.
#[derive(Clone, Copy, Debug)]
pub struct Press<T, const K: usize> {
    pub normal: T,
    /// Of both forces on both surfaces.
    pub power: T,
    pub load: [T; K],
}

/// Forces of a contact at these rates.
#[inline(always)]
pub fn press<T: Real, const K: usize>(
    touch: &Touch<T, K>,
    v: &[T; K],
    (law, friction): (&NormalLaw, Option<&FrictionLaw>),
    state: SiteState,
) -> Press<T, K> {
    let rate = |row: &[T; K]| (1..K).fold(row[0] * v[0], |sum, k| sum + row[k] * v[k]);
    let gap_rate = rate(&touch.normal_row);
    let normal = normal_over_gap(|depth, speed| branch(law, state, depth, speed), touch.gap, gap_rate);
    let mut power = normal * gap_rate;
    let mut load = touch.normal_row.map(|part| part * normal);
    if let Some(friction) = friction {
        let slip = rate(&touch.tangent_row);
        let tangential = friction_force(friction, slip, normal);
        power += tangential * slip;
        (0..K).for_each(|k| load[k] += touch.tangent_row[k] * tangential);
    }
    Press { normal, power, load }
}
