//! Overlaps of outlines and excesses of limits in given poses: what a start must not have.

use std::f64::consts::TAU;

use super::{ContactPair, Limit, Mechanism, OutlineId, OutlineShape, Pose, coordinate_in};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::dot;

/// Number of directions in which outlines are compared.
const DIRECTIONS: usize = 240;
/// Rounding error of the depth of an overlap, m.
const ROUNDING_M: f64 = 1e-12;
/// Iterations of the golden section between two directions.
const REFINEMENTS: usize = 60;

impl Mechanism {
    /// Pairs of contacts whose outlines overlap by more than `limit_m` at these poses, each with the depth of the
    /// overlap, m. A pair that is listed in both directions appears once.
    pub fn deep_overlaps(&self, poses: &[Pose], limit_m: f64) -> Vec<(usize, f64)> {
        let outlines = |pair: &ContactPair| [pair.points, pair.face];
        let is_reversed = |index: usize| {
            let [points, face] = outlines(&self.contacts[index]);
            self.contacts[..index].iter().any(|other| outlines(other) == [face, points])
        };
        let overlap = |index: usize| {
            let [a, b] = outlines(&self.contacts[index]).map(|id| self.placed(id, poses));
            Some((index, overlap_beyond(&a, &b, limit_m + ROUNDING_M)?))
        };
        (0..self.contacts.len()).filter(|index| !is_reversed(*index)).filter_map(overlap).collect()
    }

    /// Limits that coordinates exceed at these poses, each with the coordinate and the excess. Smaller excesses
    /// than `slack_rad` (revolute) or `slack_m` (prismatic) are ignored.
    pub fn exceeded_limits(&self, poses: &[Pose], slack_rad: f64, slack_m: f64) -> Vec<(Limit, f64, f64)> {
        let excess = |limit: Limit| {
            let coordinate = self.limited(&limit).value(|joint| coordinate_in(&self.joints[joint], poses));
            let slack = if self.is_angular(&limit) { slack_rad } else { slack_m };
            Some((limit, coordinate, limit.side * (coordinate - limit.value))).filter(|(.., excess)| *excess > slack)
        };
        self.limits().into_iter().filter_map(excess).collect()
    }

    /// An outline in the world.
    fn placed(&self, id: OutlineId, poses: &[Pose]) -> OutlineShape {
        let [x, y, angle] = id.body.map_or([0.0; 3], |body| poses[body]);
        self.outline(id).shape.moved([x, y], angle)
    }
}

/// Smallest distance by which one of two outlines must move so that they only touch, if it exceeds a limit. It is the
/// minimum over all directions n of the extents of one outline along n and of the other along −n.
fn overlap_beyond(a: &OutlineShape, b: &OutlineShape, limit_m: f64) -> Option<f64> {
    for (plane, other) in [(a, b), (b, a)] {
        if let OutlineShape::HalfPlane { point_m, normal } = plane {
            let depth = dot(*point_m, *normal) + other.support_m(normal.map(|part| -part));
            return Some(depth).filter(|depth| *depth > limit_m);
        }
    }
    let depth_at = |angle: f64| {
        let (sin, cos) = sin_cos(angle);
        a.support_m([cos, sin]) + b.support_m([-cos, -sin])
    };
    let step = TAU / DIRECTIONS as f64;
    let mut least = (f64::INFINITY, 0.0);
    for angle in (0..DIRECTIONS).map(|k| k as f64 * step) {
        let depth = depth_at(angle);
        // One such direction suffices.
        if depth <= limit_m {
            return None;
        }
        least = if depth < least.0 { (depth, angle) } else { least };
    }
    let (mut low, mut high) = (least.1 - step, least.1 + step);
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..REFINEMENTS {
        let [left, right] = [high - golden * (high - low), low + golden * (high - low)];
        if depth_at(left) < depth_at(right) { high = right } else { low = left }
    }
    Some(depth_at(0.5 * (low + high)).min(least.0)).filter(|depth| *depth > limit_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(x: f64, radius_m: f64) -> OutlineShape {
        OutlineShape::Disc { center_m: [x, 0.0], radius_m }
    }

    fn bar(angle_rad: f64) -> OutlineShape {
        let half = [[-2.0, -0.5], [2.0, -0.5], [2.0, 0.5], [-2.0, 0.5]];
        OutlineShape::Polygon { vertices_m: half.to_vec(), radius_m: 0.25 }.moved([0.0; 2], angle_rad)
    }

    /// Closed forms: discs, a disc in a half plane, an ellipse, and crossed bars whose corners are outside each other.
    #[test]
    fn depths_are_those_of_closed_forms() {
        let ellipse = OutlineShape::Ellipse { center_m: [0.0; 2], semi_axes_m: [2.0, 1.0], angle_rad: 0.0 };
        let plane = OutlineShape::HalfPlane { point_m: [5.0, 1.0], normal: [0.0, 1.0] };
        for (a, b, expected) in [
            (disc(0.0, 1.0), disc(1.5, 1.0), Some(0.5)),
            (disc(0.0, 1.0), disc(0.1, 1.0), Some(1.9)),
            (disc(0.0, 1.0), disc(2.5, 1.0), None),
            (disc(0.0, 3.0), plane, Some(4.0)),
            (ellipse, disc(0.0, 0.5), Some(1.5)),
            (bar(0.0), bar(TAU / 4.0), Some(3.0)),
            (bar(0.3), disc(0.0, 0.1), Some(0.85)),
        ] {
            for (a, b) in [(&a, &b), (&b, &a)] {
                let found = overlap_beyond(a, b, 1e-3);
                let differs = found.zip(expected).map_or(found != expected, |(a, b)| (a - b).abs() > 1e-9);
                assert!(!differs, "{a:?} and {b:?}: {found:?}, not {expected:?}");
            }
        }
    }
}
