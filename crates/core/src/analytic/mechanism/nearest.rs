//! The nearest points of a point outline and the core of a face. They lie on one feature of the core, a side or a
//! corner; on each feature they are smooth functions of the poses of both bodies.

use super::motion::{BodyMotion, rotated};
use crate::mechanism::{ForcePoint, OutlinePoint, OutlineShape};
use crate::numeric::plane::{Vector, add, dot, perp, scale, scale_by, sub};
use crate::numeric::{Dual, Real};
use std::cell::Cell;

/// Number of components of the relative pose of two bodies A and B: x and y of A against B, then both angles. Forces
/// between the bodies depend on nothing else, and the load on x and y of B is the opposite of that on A.
pub(super) const POSES: usize = 4;

/// Frame of a body of a pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<T> {
    pub origin: Vector<T>,
    pub direction: Vector<T>,
}

impl<T: Real> Frame<T> {
    #[inline(always)]
    pub fn rotated(&self, vector: [f64; 2]) -> Vector<T> {
        rotated(self.direction, vector)
    }

    #[inline(always)]
    pub fn position(&self, point: [f64; 2]) -> Vector<T> {
        add(self.origin, self.rotated(point))
    }
}

impl Frame<f64> {
    pub fn new(body: &BodyMotion<f64>) -> Self {
        Self { origin: body.origin, direction: body.direction }
    }
}

impl Frame<Dual<POSES>> {
    /// Frame of body `index` of a pair, with the relative pose as the variables. The angle of the ground is constant.
    #[inline(always)]
    pub fn variable(frame: &Frame<f64>, index: usize, is_ground: bool) -> Self {
        let ([x, y], [cos, sin]) = (frame.origin, frame.direction);
        let mut origin = [Dual::constant(x), Dual::constant(y)];
        if index == 0 {
            (origin[0].grad[0], origin[1].grad[1]) = (1.0, 1.0);
        }
        let mut direction = [Dual::constant(cos), Dual::constant(sin)];
        if !is_ground {
            (direction[0].grad[2 + index], direction[1].grad[2 + index]) = (-sin, cos);
        }
        Self { origin, direction }
    }
}

/// Distance from the end of a region above which rounding errors put a point into no other one, m.
const REGION_ROUNDING_M: f64 = 1e-9;

/// A side or a corner of the core of a face, by its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feature {
    Side(u8),
    Corner(u8),
}

/// Core of a face with its radius. Side k starts at corner k and goes counter-clockwise; a capsule has a side in each
/// direction. The only side of a half plane has no ends.
#[derive(Clone, Debug)]
pub(super) struct Face {
    corners_m: Vec<[f64; 2]>,
    /// Directions and lengths of the sides.
    sides: Vec<([f64; 2], f64)>,
    /// The feature of a half plane or a point.
    only_feature: Option<Feature>,
    pub radius_m: f64,
}

impl Face {
    pub fn new(shape: &OutlineShape) -> Self {
        if let OutlineShape::HalfPlane { point_m, normal } = *shape {
            let only_feature = Some(Feature::Side(0));
            let sides = vec![(perp(normal), f64::INFINITY)];
            return Self { corners_m: vec![point_m], sides, only_feature, radius_m: 0.0 };
        }
        let corners_m = shape.vertices_m();
        let side = |k: usize| {
            let along = sub(corners_m[(k + 1) % corners_m.len()], corners_m[k]);
            let length_m = dot(along, along).sqrt();
            (scale_by(along, 1.0 / length_m), length_m)
        };
        let is_point = corners_m.len() == 1;
        let sides = if is_point { Vec::new() } else { (0..corners_m.len()).map(side).collect() };
        let only_feature = is_point.then_some(Feature::Corner(0));
        Self { corners_m, sides, only_feature, radius_m: shape.radius_m() }
    }
}

/// A point outline of body A against a face of body B.
#[derive(Clone, Debug)]
pub(super) struct PointOnFace {
    pub bodies: [Option<usize>; 2],
    pub point: OutlinePoint,
    pub face: Face,
    pub force_point: ForcePoint,
    /// The feature that was nearest in the last evaluation, which is tried first. It does not affect results.
    pub nearest_before: Cell<Option<Feature>>,
}

/// Nearest point of a point outline, its distance from the core of the face, and the unit normal of the core towards it.
/// The point is the vertex itself, or on the ellipse.
pub(super) struct Nearest<T> {
    pub point: Vector<T>,
    pub distance: T,
    pub normal: Vector<T>,
}

impl PointOnFace {
    /// Radius about the nearest point.
    pub fn point_radius_m(&self) -> f64 {
        match self.point {
            OutlinePoint::Vertex { radius_m, .. } => radius_m,
            OutlinePoint::Ellipse { .. } => 0.0,
        }
    }

    /// Nearest points on one feature: on a corner, or on the line through a side.
    #[inline(always)]
    pub fn on_feature<T: Real>(&self, frames: &[Frame<T>; 2], feature: Feature) -> Nearest<T> {
        let [of_point, of_face] = frames;
        match feature {
            Feature::Side(index) => {
                let [x, y] = self.face.sides[usize::from(index)].0;
                let normal = of_face.rotated([y, -x]);
                let point = match self.point {
                    OutlinePoint::Vertex { point_m, .. } => of_point.position(point_m),
                    OutlinePoint::Ellipse { center_m, semi_axes_m: [a, b], axis } => {
                        let axes = [of_point.rotated(axis), of_point.rotated(perp(axis))];
                        let [along_a, along_b] = [dot(normal, axes[0]) * a, dot(normal, axes[1]) * b];
                        let support = (along_a.squared() + along_b.squared()).sqrt().recip();
                        let arm = [along_a * support * a, along_b * support * b];
                        let center = of_point.position(center_m);
                        sub(center, add(scale(axes[0], arm[0]), scale(axes[1], arm[1])))
                    }
                };
                let start = of_face.position(self.face.corners_m[usize::from(index)]);
                Nearest { point, distance: dot(normal, sub(point, start)), normal }
            }
            Feature::Corner(index) => {
                let corner = of_face.position(self.face.corners_m[usize::from(index)]);
                match self.point {
                    OutlinePoint::Vertex { point_m, .. } => {
                        let point = of_point.position(point_m);
                        let offset = sub(point, corner);
                        let distance = dot(offset, offset).sqrt();
                        Nearest { point, distance, normal: scale(offset, distance.recip()) }
                    }
                    OutlinePoint::Ellipse { center_m, semi_axes_m, axis } => {
                        let axes = [of_point.rotated(axis), of_point.rotated(perp(axis))];
                        let center = of_point.position(center_m);
                        let offset = sub(corner, center);
                        let (foot, normal) = foot_on_ellipse(semi_axes_m, [dot(axes[0], offset), dot(axes[1], offset)]);
                        let in_world = |[x, y]: Vector<T>| add(scale(axes[0], x), scale(axes[1], y));
                        let (point, normal) = (add(center, in_world(foot)), in_world(normal));
                        Nearest { point, distance: dot(normal, sub(point, corner)), normal }
                    }
                }
            }
        }
    }

    /// Sides, then corners.
    fn features(&self) -> impl Iterator<Item = Feature> {
        let Face { corners_m, sides, .. } = &self.face;
        let sides = (0..sides.len()).map(|k| Feature::Side(k as u8));
        sides.chain((0..corners_m.len()).map(|k| Feature::Corner(k as u8)))
    }

    /// Returns the nearest feature of the core, with its nearest points. If the core contains the point, it is the side
    /// with the smallest depth.
    pub fn nearest(&self, frames: &[Frame<f64>; 2]) -> (Feature, Nearest<f64>) {
        if let Some(only) = self.face.only_feature {
            return (only, self.on_feature(frames, only));
        }
        // Regions of a convex core do not overlap, so that no other one contains a point well inside this one.
        if let Some(feature) = self.nearest_before.get() {
            let nearest = self.on_feature(frames, feature);
            if self.region_margin(frames, feature, &nearest) > REGION_ROUNDING_M {
                return (feature, nearest);
            }
        }
        let mut shallowest = (f64::NEG_INFINITY, Feature::Corner(0));
        for feature in self.features() {
            let nearest = self.on_feature(frames, feature);
            if self.region_margin(frames, feature, &nearest) >= 0.0 {
                self.nearest_before.set(Some(feature));
                return (feature, nearest);
            }
            if matches!(feature, Feature::Side(_)) && nearest.distance > shallowest.0 {
                shallowest = (nearest.distance, feature);
            }
        }
        (shallowest.1, self.on_feature(frames, shallowest.1))
    }

    /// Nearest points on a given feature, or on the nearest one if there is none.
    #[inline(always)]
    pub fn nearest_on(&self, frames: &[Frame<f64>; 2], feature: Option<Feature>) -> Nearest<f64> {
        match feature {
            Some(feature) => self.on_feature(frames, feature),
            None => self.nearest(frames).1,
        }
    }

    /// Distance of the point from the end of the region of a feature, m; negative beyond it.
    pub fn margin(&self, frames: &[Frame<f64>; 2], feature: Feature) -> f64 {
        if self.face.only_feature.is_some() {
            return f64::INFINITY;
        }
        self.margin_of(frames, feature, &self.on_feature(frames, feature))
    }

    /// [`PointOnFace::margin`], which is also negative for a point on the inner side of the face.
    fn region_margin(&self, frames: &[Frame<f64>; 2], feature: Feature, nearest: &Nearest<f64>) -> f64 {
        let margin = self.margin_of(frames, feature, nearest);
        if matches!(feature, Feature::Side(_)) { margin.min(nearest.distance) } else { margin }
    }

    fn margin_of(&self, [_, of_face]: &[Frame<f64>; 2], feature: Feature, nearest: &Nearest<f64>) -> f64 {
        let Face { corners_m, sides, radius_m, .. } = &self.face;
        match feature {
            Feature::Side(index) => {
                let (direction, length_m) = sides[usize::from(index)];
                let arm = sub(nearest.point, of_face.position(corners_m[usize::from(index)]));
                let from_start = dot(of_face.rotated(direction), arm);
                from_start.min(length_m - from_start)
            }
            Feature::Corner(index) => {
                let index = usize::from(index);
                let along = |side: usize| dot(of_face.rotated(sides[side % sides.len()].0), nearest.normal);
                // An arc about the corner, at the surfaces.
                (radius_m + self.point_radius_m()) * along(index + sides.len() - 1).min(-along(index))
            }
        }
    }

    /// Returns the feature beyond the end of the region of the feature `old`.
    pub fn feature_beyond(&self, frames: &[Frame<f64>; 2], old: Feature) -> Feature {
        let (found, _) = self.nearest(frames);
        if found != old {
            return found;
        }
        // The end was located within its margin: the neighbour is the feature that is nearly as near.
        let margin = |feature: &Feature| self.region_margin(frames, *feature, &self.on_feature(frames, *feature));
        let others = self.features().filter(|other| *other != old);
        others.max_by(|a, b| margin(a).total_cmp(&margin(b))).unwrap_or(old)
    }
}

/// Largest number of Newton iterations for the foot of a point on an ellipse.
const MAX_ITERATIONS: u32 = 50;

/// Point of an ellipse that is nearest to a point outside it, and the inward unit normal there, in the axes of the
/// ellipse.
///
/// The foot is (a² x/(a² + λ), b² y/(b² + λ)) at the root of the convex function
/// F(λ) = (a x/(a² + λ))² + (b y/(b² + λ))² − 1, which Newton's method approaches from below. A last step with
/// derivatives gives those of the root.
#[inline(always)]
fn foot_on_ellipse<T: Real>([a, b]: [f64; 2], [x, y]: Vector<T>) -> (Vector<T>, Vector<T>) {
    let (ax, by) = (a * x.value(), b * y.value());
    let terms = |lambda: f64| [ax / (a * a + lambda), by / (b * b + lambda)];
    let slope = |[s, t]: [f64; 2], lambda: f64| -2.0 * (s * s / (a * a + lambda) + t * t / (b * b + lambda));
    // Bounds of the root; inside the ellipse it is kept away from the pole.
    let smallest = -0.9 * a.min(b) * a.min(b);
    let bounds = [ax.abs() - a * a, by.abs() - b * b, (ax * ax + by * by).sqrt() - a.max(b) * a.max(b)];
    let mut lambda = bounds.into_iter().fold(smallest, f64::max);
    for _ in 0..MAX_ITERATIONS {
        let [s, t] = terms(lambda);
        let next = lambda - (s * s + t * t - 1.0) / slope([s, t], lambda);
        // Rounding errors end the growth.
        if next <= lambda || next.is_nan() {
            break;
        }
        lambda = next;
    }
    let slope = slope(terms(lambda), lambda);
    let [p, q] = [x * (a / (a * a + lambda)), y * (b / (b * b + lambda))];
    let lambda = (p.squared() + q.squared() - 1.0) * (-1.0 / slope) + lambda;
    let foot = [x * (lambda + a * a).recip() * (a * a), y * (lambda + b * b).recip() * (b * b)];
    let outward = [foot[0] * (1.0 / (a * a)), foot[1] * (1.0 / (b * b))];
    let size = -(outward[0].squared() + outward[1].squared()).sqrt().recip();
    (foot, scale(outward, size))
}
