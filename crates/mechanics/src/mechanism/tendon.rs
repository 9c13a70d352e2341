//! Geometry of the cable of a tendon: straight segments between eyelets and pulleys, and wraps around pulleys.

use super::joint::coordinate_in;
use super::{Mechanism, PathElement, Pose, Tendon, point_in};
use crate::numeric::Real;
use crate::numeric::plane::{Vector, dot, opening_angle, perp, scale, scale_by, sub};
use std::f64::consts::FRAC_PI_2;

/// Largest wrap angle of a pulley. Beyond it the strands may cross, and the directions alone do not determine the wrap.
pub const MAX_WRAP_RAD: f64 = 3.0 * FRAC_PI_2;

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

/// Returns the length of a cable, segments and wrapped arcs; `center` gives the centre of each path element.
pub fn path_length(path: &[PathElement], center: impl Fn(&PathElement) -> Vector<f64>) -> f64 {
    let (mut length, mut before) = (0.0, None);
    for pair in path.windows(2) {
        let segment = segment([&pair[0], &pair[1]], sub(center(&pair[1]), center(&pair[0])));
        let arc = before.map_or(0.0, |before| match pair[0].is_pulley() {
            true => pair[0].radius_m * wrap(&pair[0], [before, segment.direction]),
            false => 0.0,
        });
        length += arc + segment.length;
        before = Some(segment.direction);
    }
    length
}

/// Returns the wrap angle of each pulley of a cable, with the index of its path element.
pub fn wraps(path: &[PathElement], center: impl Fn(&PathElement) -> Vector<f64>) -> impl Iterator<Item = (usize, f64)> {
    let direction =
        move |pair: &[PathElement]| segment([&pair[0], &pair[1]], sub(center(&pair[1]), center(&pair[0]))).direction;
    let turns = path.windows(3).enumerate().filter(|(_, turn)| turn[1].is_pulley());
    turns.map(move |(index, turn)| (index + 1, wrap(&turn[1], [direction(&turn[..2]), direction(&turn[1..])])))
}

/// Returns the position of the centre of a path element at these poses.
pub fn center_in(element: &PathElement, poses: &[Pose]) -> Vector<f64> {
    point_in(element.body, element.point_m, poses)
}

/// Returns the length of a tendon at these poses, including its joint terms.
pub fn length_in(mechanism: &Mechanism, tendon: &Tendon, poses: &[Pose]) -> f64 {
    let joints = tendon.joints.iter().map(|(joint, factor)| factor * coordinate_in(&mechanism.joints[*joint], poses));
    path_length(&tendon.path, |element| center_in(element, poses)) + joints.sum::<f64>()
}

impl Mechanism {
    /// Explains that a cable has lifted off a pulley, and how to avoid this.
    pub fn describe_lifted(&self, tendon: &Tendon, element: usize) -> String {
        let pulley = &tendon.path[element];
        format!(
            "the cable of the tendon {} lifts off its pulley in place {} of the path ({}, radius {:.4} mm): swap the side of \
             the pulley, remove it, or change the path so that the cable stays on it",
            tendon.name,
            element + 1,
            self.body_name(pulley.body),
            pulley.radius_m * 1e3
        )
    }
}
