//! Geometry of the cable of a tendon: straight segments between eyelets and pulleys, wraps around pulleys, and the pulleys
//! from which the cable has lifted off.

use super::joint::coordinate_in;
use super::{Mechanism, PathElement, Pose, Tendon, point_in};
use crate::numeric::Real;
use crate::numeric::elementary::hypot;
use crate::numeric::plane::{Vector, angle_between, dot, opening_angle, perp, scale, scale_by, sub};
use std::f64::consts::FRAC_PI_2;

/// Largest wrap angle of a pulley. Beyond it the strands may cross, and the directions alone do not determine the wrap.
pub const MAX_WRAP_RAD: f64 = 3.0 * FRAC_PI_2;

/// A cable lifts off a pulley at a wrap angle of −`BAND`, and returns at a gap of −`BAND` radii. Without the band, a pulley
/// that is tangent to the line of its neighbours on the same body would lift off and return for ever.
pub const BAND: f64 = 1e-10;

/// How a cable passes an element of its path: it is off a pulley, or bends to the left (counter-clockwise) or to the right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bend {
    Off,
    Left,
    Right,
}

impl Bend {
    fn of(sign: f64) -> Self {
        if sign < 0.0 { Bend::Right } else { Bend::Left }
    }

    #[inline(always)]
    pub fn is_on(self) -> bool {
        self != Bend::Off
    }

    /// +1 for a bend to the left, −1 for one to the right.
    pub fn sign(self) -> f64 {
        if self == Bend::Right { -1.0 } else { 1.0 }
    }
}

/// Why a cable cannot go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CableFault {
    /// It came round the back of a pulley.
    Behind(usize),
    /// No straight line leads from one path element to another.
    NoSegment([usize; 2]),
    /// It wraps a pulley by [`MAX_WRAP_RAD`].
    TooFar(usize),
}

/// Distance from [`MAX_WRAP_RAD`] below which a wrap counts as too far in a description: the end is not located exactly.
const WRAP_ROUNDING: f64 = 1e-6;

/// A straight segment of a cable between two path elements.
#[derive(Clone, Copy, Debug)]
pub struct Segment<T> {
    pub length: T,
    /// Unit vector along the segment, from the first to the second element.
    pub direction: Vector<T>,
}

impl PathElement {
    /// Radius, m; negative for a pulley that the cable passes clockwise.
    pub fn signed_radius_m(&self) -> f64 {
        self.side * self.radius_m
    }

    pub fn is_pulley(&self) -> bool {
        self.radius_m > 0.0
    }
}

/// Returns the segment between two path elements; `between` is the vector from the centre of the first element to that
/// of the second. Its numbers are NaN if no straight line touches both elements on their sides.
#[inline(always)]
pub fn segment<T: Real>([first, second]: [&PathElement; 2], between: Vector<T>) -> Segment<T> {
    let offset = second.signed_radius_m() - first.signed_radius_m();
    let squared = dot(between, between);
    let length = (squared - offset * offset).sqrt();
    let direction = scale(sub(scale(between, length), scale_by(perp(between), offset)), squared.recip());
    Segment { length, direction }
}

/// Returns the angle over which a cable wraps a pulley, from −π/2 to [`MAX_WRAP_RAD`]; negative if the cable lifts off.
pub fn wrap(pulley: &PathElement, [before, after]: [Vector<f64>; 2]) -> f64 {
    if pulley.side > 0.0 { opening_angle(before, after) } else { opening_angle(after, before) }
}

/// Returns the angle by which a cable turns about an element: the wrap of a pulley; at an eyelet the angle between both
/// directions, which is negative if it is against the bend.
pub fn turn(element: &PathElement, bend: Bend, directions: [Vector<f64>; 2]) -> f64 {
    match element.is_pulley() {
        true => wrap(element, directions),
        false => bend.sign() * angle_between(directions[0], directions[1]),
    }
}

/// Pairs of path elements between which a cable is straight, by their indices.
#[derive(Clone, Debug)]
pub struct Strands<'a> {
    bends: &'a [Bend],
    from: usize,
    next: usize,
}

/// Returns the [`Strands`] of a cable, from its first element; the ends of its path are always on it.
#[inline(always)]
pub fn strands(bends: &[Bend]) -> Strands<'_> {
    Strands { bends, from: 0, next: 1 }
}

impl Iterator for Strands<'_> {
    type Item = [usize; 2];

    #[inline(always)]
    fn next(&mut self) -> Option<[usize; 2]> {
        while let Some(bend) = self.bends.get(self.next) {
            let to = self.next;
            self.next += 1;
            if bend.is_on() {
                return Some([std::mem::replace(&mut self.from, to), to]);
            }
        }
        None
    }
}

/// Returns the path elements on the path before and after an element.
pub fn neighbours(bends: &[Bend], element: usize) -> Option<[usize; 2]> {
    let before = bends[..element].iter().rposition(|bend| bend.is_on());
    let after = bends[element + 1..].iter().position(|bend| bend.is_on());
    Some([before?, element + 1 + after?])
}

/// Returns the length of a cable, segments and wrapped arcs; `center` gives the centre of each path element.
pub fn path_length(path: &[PathElement], bends: &[Bend], center: impl Fn(&PathElement) -> Vector<f64>) -> f64 {
    let (mut length, mut before) = (0.0, None);
    for [from, to] in strands(bends).map(|pair| pair.map(|element| &path[element])) {
        let segment = segment([from, to], sub(center(to), center(from)));
        let arc = before.map_or(0.0, |before| match from.is_pulley() {
            true => from.radius_m * wrap(from, [before, segment.direction]),
            false => 0.0,
        });
        length += arc + segment.length;
        before = Some(segment.direction);
    }
    length
}

/// Returns the wrap angle of each pulley on a path, with the index of its path element.
pub fn wraps(
    path: &[PathElement],
    bends: &[Bend],
    center: impl Fn(&PathElement) -> Vector<f64>,
) -> impl Iterator<Item = (usize, f64)> {
    let mut before = None;
    strands(bends).filter_map(move |[from, to]| {
        let next = segment([&path[from], &path[to]], sub(center(&path[to]), center(&path[from]))).direction;
        let directions = before.replace(next).map(|before| [before, next]);
        Some((from, wrap(&path[from], directions?))).filter(|_| path[from].is_pulley())
    })
}

/// Returns the gap between a pulley that is off the path and the segment of its neighbours on the path. It is negative where
/// the cable would pass through the pulley, and not a number if the neighbours have no segment.
pub fn gap(
    path: &[PathElement],
    [before, element, after]: [usize; 3],
    center: impl Fn(&PathElement) -> Vector<f64>,
) -> f64 {
    let [before, element, after] = [before, element, after].map(|element| &path[element]);
    let segment = segment([before, after], sub(center(after), center(before)));
    let left = perp(segment.direction);
    let touch = |of: &PathElement| sub(center(of), scale(left, of.signed_radius_m()));
    let [from, to] = [touch(before), touch(after)].map(|end| sub(center(element), end));
    let along = dot(segment.direction, from);
    let distance = match along {
        _ if along < 0.0 => hypot(from[0], from[1]),
        _ if along > segment.length => hypot(to[0], to[1]),
        _ => element.side * dot(left, from),
    };
    distance - element.radius_m
}

/// Largest number of changes of one path element in [`settle_path`]. A path settles after fewer; the value only ends the search.
const MAX_CHANGES: usize = 100;

/// Takes a cable off the pulley with the most negative wrap and, if there is none, puts it on the pulley with the most
/// negative gap, until there is neither. The result is the shortest cable that passes all pulleys on their sides.
pub fn settle_path(path: &[PathElement], bends: &mut [Bend], center: impl Fn(&PathElement) -> Vector<f64>) {
    let least = |(index, value): (usize, f64), found: &mut Option<(usize, f64)>| {
        if value < -BAND && found.is_none_or(|(_, least)| value < least) {
            *found = Some((index, value));
        }
    };
    for _ in 0..MAX_CHANGES * path.len() {
        let (mut lifted, mut crossed) = (None, None);
        wraps(path, bends, &center).for_each(|of| least(of, &mut lifted));
        if let Some((index, _)) = lifted {
            bends[index] = Bend::Off;
            continue;
        }
        for index in (0..path.len()).filter(|index| !bends[*index].is_on()) {
            let Some([before, after]) = neighbours(bends, index) else { continue };
            least((index, gap(path, [before, index, after], &center) / path[index].radius_m), &mut crossed);
        }
        let Some((index, _)) = crossed else { break };
        bends[index] = Bend::of(path[index].side);
    }
    let mut before = None;
    let turns: Vec<_> = strands(bends)
        .filter_map(|[from, to]| {
            let next = segment([&path[from], &path[to]], sub(center(&path[to]), center(&path[from]))).direction;
            Some((from, angle_between(before.replace(next)?, next)))
        })
        .collect();
    for (index, angle) in turns.into_iter().filter(|(index, _)| !path[*index].is_pulley()) {
        bends[index] = Bend::of(angle);
    }
}

/// Returns how a cable passes its path at rest: the shortest cable, see [`settle_path`].
pub fn settled_path(path: &[PathElement], center: impl Fn(&PathElement) -> Vector<f64>) -> Vec<Bend> {
    let mut bends: Vec<Bend> = path.iter().map(|element| Bend::of(element.side)).collect();
    settle_path(path, &mut bends, center);
    bends
}

/// Returns the position of the centre of a path element at these poses.
pub fn center_in(element: &PathElement, poses: &[Pose]) -> Vector<f64> {
    point_in(element.body, element.point_m, poses)
}

/// Returns the length of a tendon at these poses, including its joint terms.
pub fn length_in(mechanism: &Mechanism, tendon: &Tendon, poses: &[Pose]) -> f64 {
    let joints = tendon.spools().map(|(joint, factor)| factor * coordinate_in(&mechanism.joints[*joint], poses));
    let center = |element: &PathElement| center_in(element, poses);
    path_length(&tendon.path, &settled_path(&tendon.path, center), center) + joints.sum::<f64>()
}

/// Finds a pair of path elements without a straight line between them, or a pulley that the cable wraps too far.
pub fn find_fault(
    path: &[PathElement],
    bends: &[Bend],
    center: impl Fn(&PathElement) -> Vector<f64>,
) -> Option<CableFault> {
    let is_open = |[from, to]: &[usize; 2]| {
        let length = segment([&path[*from], &path[*to]], sub(center(&path[*to]), center(&path[*from]))).length;
        length.is_nan() || length <= 0.0
    };
    let open = strands(bends).find(is_open).map(CableFault::NoSegment);
    open.or_else(|| {
        let too_far = wraps(path, bends, &center).find(|(_, wrap)| *wrap > MAX_WRAP_RAD - WRAP_ROUNDING);
        too_far.map(|(element, _)| CableFault::TooFar(element))
    })
}

impl Tendon {
    /// Whether any path element has friction.
    pub fn has_friction(&self) -> bool {
        self.path.iter().any(|element| element.friction.is_some())
    }

    /// Place of a path element in the scene, from 0.
    pub fn place(&self, element: usize) -> usize {
        if self.is_reversed { self.path.len() - 1 - element } else { element }
    }
}

impl Mechanism {
    /// Path elements that samples report, by tendon and element: all between the ends of a cable with friction, otherwise its
    /// pulleys.
    pub fn reported_elements(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.tendons.iter().enumerate().flat_map(|(index, tendon)| {
            let inner = 1..tendon.path.len().saturating_sub(1);
            let is_reported = |element: &usize| tendon.has_friction() || tendon.path[*element].is_pulley();
            inner.filter(is_reported).map(move |element| [index, element])
        })
    }

    /// Name of a path element, such as `flexor[2]` for the third place of the path in the scene.
    pub fn element_name(&self, tendon: usize, element: usize) -> String {
        let tendon = &self.tendons[tendon];
        format!("{}[{}]", tendon.name, tendon.place(element))
    }

    /// Describes a path element of a tendon, such as "place 3 of its path (distal, radius 4.0000 mm)".
    fn describe_element(&self, tendon: &Tendon, element: usize) -> String {
        let (PathElement { body, radius_m, .. }, place) = (&tendon.path[element], tendon.place(element) + 1);
        let body = self.body_name(*body);
        match *radius_m > 0.0 {
            true => format!("place {place} of its path ({body}, radius {:.4} mm)", radius_m * 1e3),
            false => format!("place {place} of its path ({body})"),
        }
    }

    /// Explains why the cable of a tendon cannot go on, and how to avoid this.
    pub fn describe_cable(&self, tendon: &Tendon, fault: CableFault) -> String {
        let (name, place) = (&tendon.name, |element| self.describe_element(tendon, element));
        match fault {
            CableFault::Behind(element) => format!(
                "the cable of the tendon {name} came round the back of the pulley in {}: add an eyelet or a pulley that keeps \
                 the cable on its side, or shorten the motion",
                place(element)
            ),
            CableFault::NoSegment([from, to]) => format!(
                "the cable of the tendon {name} cannot pass from {} to {}: the places coincide or overlap; move them apart, \
                 or shorten the motion",
                place(from),
                place(to)
            ),
            CableFault::TooFar(element) => format!(
                "the cable of the tendon {name} wraps the pulley in {} by 270 degrees, beyond which its strands may cross: use \
                 a spool for more, or shorten the motion",
                place(element)
            ),
        }
    }
}
