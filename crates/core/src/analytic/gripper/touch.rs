//! A phalanx or a plane against the object: gap, and the rows that give its rate and the slip.
//!
//! The contact point is on the surface of the phalanx or plane, so the object's lever arm is r − δ, and both sides feel opposite forces at
//! one point: momentum and angular momentum are exchanged exactly.

use super::model::Plane;
use crate::analytic::contact::Geometry;
use crate::analytic::mode::{SiteState, along};
use crate::law::{FrictionLaw, NormalLaw, friction_force, normal_over_gap};
use crate::numeric::plane::{Vector, add, dot, perp, scale};
use crate::numeric::{Dual, Real};

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

/// A number with its derivatives by the P positions that a contact's place depends on, and by its K rates.
#[derive(Clone, Copy, Debug)]
pub struct Slope<const P: usize, const K: usize> {
    pub value: f64,
    pub by_q: [f64; P],
    pub by_v: [f64; K],
}

/// Normal force and friction of a contact, which know of nothing but its gap, the rate of that, and its slip.
#[inline(always)]
fn forces<T: Real>(
    [gap, gap_rate, slip]: [T; 3],
    (law, friction): (&NormalLaw, Option<&FrictionLaw>),
    state: SiteState,
) -> [T; 2] {
    let normal = normal_over_gap(|depth, speed| branch(law, state, depth, speed), gap, gap_rate);
    [normal, friction.map_or(T::zero(), |friction| friction_force(friction, slip, normal))]
}

/// Forces of a contact at these rates.
#[inline(always)]
pub fn press<const K: usize>(
    touch: &Touch<f64, K>,
    v: &[f64; K],
    laws: (&NormalLaw, Option<&FrictionLaw>),
    state: SiteState,
) -> Press<f64, K> {
    let (gap_rate, slip) = (along(&touch.normal_row, v), along(&touch.tangent_row, v));
    let [normal, tangential] = forces([touch.gap, gap_rate, slip], laws, state);
    Press {
        normal,
        power: normal * gap_rate + tangential * slip,
        load: std::array::from_fn(|k| touch.normal_row[k] * normal + touch.tangent_row[k] * tangential),
    }
}

/// The same with its derivatives: the laws' own by their three variables, of which the rows say how they depend on the rest.
#[inline(always)]
pub fn press_with_slopes<const P: usize, const K: usize>(
    touch: &Touch<Dual<P>, K>,
    v: &[f64; K],
    laws: (&NormalLaw, Option<&FrictionLaw>),
    state: SiteState,
) -> Press<Slope<P, K>, K> {
    let (normal_row, tangent_row) = (touch.normal_row.map(|part| part.value), touch.tangent_row.map(|part| part.value));
    let rate = |row: &[Dual<P>; K]| (1..K).fold(row[0] * v[0], |sum, k| sum + row[k] * v[k]);
    let places = [touch.gap, rate(&touch.normal_row), rate(&touch.tangent_row)];
    let [gap, gap_rate, slip] = std::array::from_fn(|i| Dual::<3>::variable(places[i].value, i));
    let [normal, tangential] = forces([gap, gap_rate, slip], laws, state);
    let slope = |of: Dual<3>| Slope {
        value: of.value,
        by_q: std::array::from_fn(|j| (0..3).map(|i| of.grad[i] * places[i].grad[j]).sum()),
        by_v: std::array::from_fn(|k| of.grad[1] * normal_row[k] + of.grad[2] * tangent_row[k]),
    };
    let (along_normal, along_tangent) = (slope(normal), slope(tangential));
    let load = |k: usize| {
        let (n, t) = (touch.normal_row[k], touch.tangent_row[k]);
        Slope {
            value: n.value * normal.value + t.value * tangential.value,
            by_q: std::array::from_fn(|j| {
                n.value * along_normal.by_q[j]
                    + t.value * along_tangent.by_q[j]
                    + (n.grad[j] * normal.value + t.grad[j] * tangential.value)
            }),
            by_v: std::array::from_fn(|j| n.value * along_normal.by_v[j] + t.value * along_tangent.by_v[j]),
        }
    };
    Press { normal: along_normal, power: slope(normal * gap_rate + tangential * slip), load: std::array::from_fn(load) }
}
