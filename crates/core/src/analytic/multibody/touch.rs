//! A phalanx, a plane or a disc against a disc of any shape: gap, and the rows that give its rate and the slip.
//!
//! The surface of a disc is at h n + h' n⊥ from its centre (its support function and the derivative of that, [`Support`]). Where there are
//! fingers, phalanges and planes are touched on their own surfaces, so the disc's lever arm is h − δ, and both sides feel
//! opposite forces at one point: momentum and angular momentum are exchanged exactly. Discs touch one another each on its own surface, and
//! so they do a plane where they are alone, as in the thesis.

use crate::analytic::contact::Geometry;
use crate::analytic::mode::along;
use crate::law::{friction_with_memory, normal_over_gap};
use crate::numeric::plane::{Vector, add, dot, perp, scale, sub};
use crate::numeric::{Dual, Real, each};
use crate::shape::{Placed, Support, facing, support};

use super::branch;
use super::laws::Laws;
use super::parts::Plane;

/// One contact, on K coordinates: a finger's two and a disc's three in its frame, one or two discs', or a finger's two (limit).
#[derive(Clone, Copy, Debug)]
pub struct Touch<T, const K: usize> {
    pub gap: T,
    pub normal_row: [T; K],
    pub tangent_row: [T; K],
    /// From the second surface to the first: disc to phalanx, plane or other disc to disc.
    pub normal: Vector<T>,
    pub point: Vector<T>,
}

/// A phalanx against a disc, which moves too: on (q11, q21, x, y, θ) as the finger's frame has them.
#[inline(always)]
pub fn phalanx<T: Real>(geometry: &Geometry<T>) -> Touch<T, 5> {
    let Geometry { gap, normal_row, tangent_row, normal, point, support } = *geometry;
    let tangent = perp(normal);
    Touch {
        gap,
        normal_row: [normal_row[0], normal_row[1], -normal[0], -normal[1], support.slope],
        tangent_row: [tangent_row[0], tangent_row[1], -tangent[0], -tangent[1], -(gap + support.distance)],
        normal,
        point,
    }
}

/// A disc on a plane: on (x, y, θ). `on_plane` is whether the plane's surface is where they meet.
#[inline(always)]
pub fn plane<T: Real>(plane: &Plane, placed: &Placed<T>, on_plane: bool) -> Touch<T, 3> {
    let normal: Vector<T> = [T::constant(plane.normal[0]), T::constant(plane.normal[1])];
    let tangent = perp(normal);
    let Support { distance, slope } = support(placed, [-normal[0], -normal[1]]);
    let gap = dot(normal, placed.centre_m) + (-distance + plane.offset);
    let lever = if on_plane { gap + distance } else { distance };
    Touch {
        gap,
        normal_row: [normal[0], normal[1], slope],
        tangent_row: [tangent[0], tangent[1], -lever],
        normal,
        point: sub(add(placed.centre_m, scale(normal, -lever)), scale(tangent, slope)),
    }
}

/// A disc against another one: on (x, y) of it and of the other, then the angles of both.
#[inline(always)]
pub fn discs<T: Real>([disc, other]: [&Placed<T>; 2]) -> Touch<T, 6> {
    let (normal, distance) = facing([disc, other]);
    let ([nx, ny], tangent) = (normal, perp(normal));
    let (own, others) = (support(disc, [-nx, -ny]), support(other, normal));
    let [tx, ty] = tangent;
    Touch {
        gap: distance - (own.distance + others.distance),
        normal_row: [nx, ny, -nx, -ny, own.slope, others.slope],
        // Either surface point lies so that friction turns its disc against its sense.
        tangent_row: [tx, ty, -tx, -ty, -own.distance, -others.distance],
        normal,
        point: sub(add(disc.centre_m, scale(normal, -own.distance)), scale(tangent, own.slope)),
    }
}

/// Of the joint limit.
#[inline(always)]
pub fn limit<T: Real>(geometry: &Geometry<T>) -> Touch<T, 2> {
    let Geometry { gap, normal_row, tangent_row, normal, point, .. } = *geometry;
    Touch { gap, normal_row, tangent_row, normal, point }
}

/// What a contact that presses does.
#[derive(Clone, Copy, Debug)]
pub struct Press<T, const K: usize> {
    pub normal: T,
    /// Of both forces on both surfaces.
    pub power: T,
    pub load: [T; K],
    /// What the memory of its bristle has of it: k T/c².
    pub driven: T,
}

/// A number with its derivatives by the P positions that a contact's place depends on, by its K rates, and by its memory.
#[derive(Clone, Copy, Debug)]
pub struct Slope<const P: usize, const K: usize> {
    pub value: f64,
    pub by_q: [f64; P],
    pub by_v: [f64; K],
    pub by_memory: f64,
}

impl<const P: usize, const K: usize> Default for Slope<P, K> {
    fn default() -> Self {
        Self { value: 0.0, by_q: [0.0; P], by_v: [0.0; K], by_memory: 0.0 }
    }
}

/// Normal force and friction of a contact, which know of nothing but its gap, the rate of that, its slip, and its memory; and what drives
/// that.
#[inline(always)]
fn forces<T: Real>([gap, gap_rate, slip]: [T; 3], memory: Option<T>, laws: Laws<'_>) -> [T; 3] {
    let normal = normal_over_gap(|depth, speed| branch(laws.normal, laws.state, depth, speed), gap, gap_rate);
    let Some(friction) = laws.friction else { return [normal, T::zero(), T::zero()] };
    let tangential = friction_with_memory(friction, slip, memory, normal);
    let driven = friction.bristle.map_or(T::zero(), |bristle| -tangential * bristle.driven());
    [normal, tangential, driven]
}

/// Forces of a contact at these rates; `memory` of where friction holds.
#[inline(always)]
pub fn press<const K: usize>(
    touch: &Touch<f64, K>,
    v: &[f64; K],
    memory: Option<f64>,
    laws: Laws<'_>,
) -> Press<f64, K> {
    let (gap_rate, slip) = (along(&touch.normal_row, v), along(&touch.tangent_row, v));
    let [normal, tangential, driven] = forces([touch.gap, gap_rate, slip], memory, laws);
    Press {
        normal,
        power: normal * gap_rate + tangential * slip,
        load: each(|k| touch.normal_row[k] * normal + touch.tangent_row[k] * tangential),
        driven,
    }
}

/// The same with its derivatives: the laws' own by their variables, of which the rows say how they depend on the rest.
#[inline(always)]
pub fn press_with_slopes<const P: usize, const K: usize>(
    touch: &Touch<Dual<P>, K>,
    v: &[f64; K],
    memory: Option<f64>,
    laws: Laws<'_>,
) -> Press<Slope<P, K>, K> {
    match memory {
        None => sloped::<P, K, 3>(touch, v, None, laws),
        Some(memory) => sloped::<P, K, 4>(touch, v, Some(memory), laws),
    }
}

/// By D variables of the laws: gap, its rate, slip, and with four of them the memory.
#[inline(always)]
fn sloped<const P: usize, const K: usize, const D: usize>(
    touch: &Touch<Dual<P>, K>,
    v: &[f64; K],
    memory: Option<f64>,
    laws: Laws<'_>,
) -> Press<Slope<P, K>, K> {
    let values = |row: &[Dual<P>; K]| each(|k| row[k].value);
    let (normal_row, tangent_row): ([f64; K], [f64; K]) = (values(&touch.normal_row), values(&touch.tangent_row));
    let rate = |row: &[Dual<P>; K]| (1..K).fold(row[0] * v[0], |sum, k| sum + row[k] * v[k]);
    let places = [touch.gap, rate(&touch.normal_row), rate(&touch.tangent_row)];
    let [gap, gap_rate, slip] = each(|i| Dual::<D>::variable(places[i].value, i));
    let [normal, tangential, driven] =
        forces([gap, gap_rate, slip], memory.map(|memory| Dual::variable(memory, D - 1)), laws);
    let slope = |of: Dual<D>| Slope {
        value: of.value,
        by_q: each(|j| (0..3).map(|i| of.grad[i] * places[i].grad[j]).sum()),
        by_v: each(|k| of.grad[1] * normal_row[k] + of.grad[2] * tangent_row[k]),
        by_memory: if D > 3 { of.grad[D - 1] } else { 0.0 },
    };
    let (along_normal, along_tangent) = (slope(normal), slope(tangential));
    let load = |k: usize| {
        let (n, t) = (touch.normal_row[k], touch.tangent_row[k]);
        Slope {
            value: n.value * normal.value + t.value * tangential.value,
            by_q: each(|j| {
                n.value * along_normal.by_q[j]
                    + t.value * along_tangent.by_q[j]
                    + (n.grad[j] * normal.value + t.grad[j] * tangential.value)
            }),
            by_v: each(|j| n.value * along_normal.by_v[j] + t.value * along_tangent.by_v[j]),
            by_memory: t.value * along_tangent.by_memory,
        }
    };
    Press {
        normal: along_normal,
        power: slope(normal * gap_rate + tangential * slip),
        load: each(load),
        driven: slope(driven),
    }
}
