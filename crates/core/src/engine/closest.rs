//! Closest points of two surfaces: of round and flat shapes from parry, which handles them exactly; of polygons and
//! ellipses by projection onto segments.

use std::f64::consts::FRAC_PI_2;

use parry2d_f64::query;
use rapier2d_f64::prelude::*;

use super::coordinate::BodyPose;
use super::plan::{ContactPointConvention, Plan, Shape, SurfaceId};
use super::world::{World, surface_pose_in_frame};
use crate::numeric::elementary::{hypot, sin_cos};
use crate::numeric::plane::{add, cross, dot, perp, rotate, scale, sub};
use crate::shape::max_radius;

/// Gap, closest point on each surface, and normal from the other surface to the body's.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClosestPoints {
    pub gap: f64,
    pub point: [f64; 2],
    pub other_point: [f64; 2],
    pub normal: [f64; 2],
}

impl ClosestPoints {
    /// Returns the points on the body and on the other surface at which the contact forces act.
    pub fn at(&self, convention: ContactPointConvention) -> [[f64; 2]; 2] {
        match convention {
            ContactPointConvention::EachSurface => [self.point, self.other_point],
            ContactPointConvention::BodySurface => [self.point; 2],
            ContactPointConvention::PartnerSurface => [self.other_point; 2],
            ContactPointConvention::Middle => [scale(add(self.point, self.other_point), 0.5); 2],
        }
    }

    /// The same points, seen from the other surface.
    fn flipped(self) -> Self {
        let Self { gap, point, other_point, normal } = self;
        Self { gap, point: other_point, other_point: point, normal: scale(normal, -1.0) }
    }
}

/// Returns the closest points of a contact at given poses; `None` for a contact that is removed.
pub(super) fn closest_points(world: &World, plan: &Plan, index: usize, poses: &[BodyPose]) -> Option<ClosestPoints> {
    let contact = Some(&plan.contacts[index]).filter(|contact| !contact.is_removed)?;
    let own = SurfaceId { body: Some(contact.body), index: contact.surface };
    let [pose, other_pose] = [own, contact.against].map(|id| surface_pose(plan, id, poses));
    match [own, contact.against].map(|id| &plan.surface(id).shape) {
        [points, face @ Shape::Polygon { .. }] | [points @ Shape::Ellipse { .. }, face] => {
            from_face((points, &pose), (face, &other_pose))
        }
        [face @ Shape::Polygon { .. }, points] | [face, points @ Shape::Ellipse { .. }] => {
            from_face((points, &other_pose), (face, &pose)).map(ClosestPoints::flipped)
        }
        _ => {
            let [collider, other] = world.contacts[index].map(|handle| &world.physics.colliders[handle]);
            let result = query::contact(&other_pose, other.shape(), &pose, collider.shape(), Real::MAX).ok()??;
            let (point, other_point, normal) = (result.point2, result.point1, result.normal1);
            Some(ClosestPoints {
                gap: result.dist,
                point: [point.x, point.y],
                other_point: [other_point.x, other_point.y],
                normal: [normal.x, normal.y],
            })
        }
    }
}

/// Closest points of a disc or an ellipse and a face. `None` for two shapes that have only faces.
fn from_face((points, pose): (&Shape, &Pose), (face, face_pose): (&Shape, &Pose)) -> Option<ClosestPoints> {
    let world = |[x, y]: [f64; 2]| {
        let point = *face_pose * Vector::new(x, y);
        [point.x, point.y]
    };
    let center = [pose.translation.x, pose.translation.y];
    let axis = [pose.rotation.re, pose.rotation.im];
    let nearest_to = |ends: [[f64; 2]; 2]| match *points {
        Shape::Disc(_) => Some(segment_to_point(ends, center)),
        Shape::Ellipse { semi_axes_m } => Some(segment_to_ellipse(ends, semi_axes_m, center, axis)),
        Shape::Capsule(_) | Shape::HalfPlane | Shape::Polygon { .. } => None,
    };
    let (corners, face_radius): (Vec<[f64; 2]>, f64) = match face {
        Shape::HalfPlane => {
            let normal = perp([face_pose.rotation.re, face_pose.rotation.im]);
            let point = match *points {
                Shape::Ellipse { semi_axes_m } => ellipse_support(semi_axes_m, center, axis, scale(normal, -1.0)),
                _ => center,
            };
            return Some(surfaces(points, 0.0, point, dot(normal, sub(point, world([0.0; 2]))), normal));
        }
        Shape::Disc(shape) => (vec![world([0.0; 2])], max_radius(shape)),
        Shape::Capsule(capsule) => (vec![world([0.0; 2]), world(capsule.end_m)], capsule.radius_m),
        Shape::Polygon { vertices_m, radius_m } => {
            (vertices_m.iter().map(|vertex| world(*vertex)).collect(), *radius_m)
        }
        Shape::Ellipse { .. } => return None,
    };
    let segments = || (0..corners.len()).map(|k| [corners[k], corners[(k + 1) % corners.len()]]);
    let is_inside = corners.len() > 2
        && matches!(points, Shape::Disc(_))
        && segments().all(|[from, to]| cross(sub(to, from), sub(center, from)) > 0.0);
    let nearest = segments().filter_map(nearest_to).min_by(|a, b| a.1.total_cmp(&b.1))?;
    // Inside, the nearest side is that of the nearest point, and the distance is negative.
    let (point, distance, normal) = nearest;
    let (distance, normal) = if is_inside { (-distance, scale(normal, -1.0)) } else { (distance, normal) };
    Some(surfaces(points, face_radius, point, distance, normal))
}

/// Closest points on the surfaces from those on the core of the face and on the points' shape without its radius.
fn surfaces(points: &Shape, face_radius: f64, point: [f64; 2], distance: f64, normal: [f64; 2]) -> ClosestPoints {
    let radius = if let Shape::Disc(shape) = points { max_radius(shape) } else { 0.0 };
    ClosestPoints {
        gap: distance - radius - face_radius,
        point: sub(point, scale(normal, radius)),
        other_point: sub(point, scale(normal, distance - face_radius)),
        normal,
    }
}

/// Returns a point, its distance from a segment, and the unit vector from the nearest point of the segment to it.
fn segment_to_point([from, to]: [[f64; 2]; 2], point: [f64; 2]) -> ([f64; 2], f64, [f64; 2]) {
    let (along, arm) = (sub(to, from), sub(point, from));
    let squared = dot(along, along);
    let part = if squared > 0.0 { dot(along, arm) / squared } else { 0.0 };
    if part > 0.0 && part < 1.0 {
        let across = cross(along, arm) / squared.sqrt();
        let normal = scale(perp(along), across.signum() / squared.sqrt());
        return (point, across.abs(), normal);
    }
    let [x, y] = sub(point, if part >= 1.0 { to } else { from });
    let distance = hypot(x, y);
    (point, distance, [x / distance, y / distance])
}

/// Returns the point of an ellipse that is nearest to a segment outside it, with distance and unit vector as
/// [`segment_to_point`].
fn segment_to_ellipse(
    [from, to]: [[f64; 2]; 2],
    semi_axes: [f64; 2],
    center: [f64; 2],
    axis: [f64; 2],
) -> ([f64; 2], f64, [f64; 2]) {
    let along = sub(to, from);
    let length = hypot(along[0], along[1]);
    if length > 0.0 {
        let side = cross(along, sub(center, from)).signum() / length;
        let normal = scale(perp(along), side);
        let point = ellipse_support(semi_axes, center, axis, scale(normal, -1.0));
        let arm = sub(point, from);
        let part = dot(along, arm) / (length * length);
        if part > 0.0 && part < 1.0 {
            return (point, dot(normal, arm), normal);
        }
    }
    let from_end = |end: [f64; 2]| {
        let (point, normal) = ellipse_foot(semi_axes, center, axis, end);
        (point, dot(normal, sub(point, end)), normal)
    };
    let [start, end] = [from_end(from), from_end(to)];
    if start.1 <= end.1 { start } else { end }
}

/// Point of an ellipse that is furthest in a direction.
fn ellipse_support([a, b]: [f64; 2], center: [f64; 2], axis: [f64; 2], direction: [f64; 2]) -> [f64; 2] {
    let [cos, sin] = axis;
    let [x, y] = rotate(direction, [cos, -sin]);
    let size = hypot(a * x, b * y);
    add(center, rotate([a * a * x / size, b * b * y / size], axis))
}

/// Point of an ellipse that is nearest to a point outside it, and the inward unit normal there: the root of the
/// derivative of the distance by the eccentric angle, in the quadrant of the point.
fn ellipse_foot([a, b]: [f64; 2], center: [f64; 2], axis: [f64; 2], point: [f64; 2]) -> ([f64; 2], [f64; 2]) {
    let [cos, sin] = axis;
    let local = rotate(sub(point, center), [cos, -sin]);
    let [x, y] = local.map(f64::abs);
    let [mut low, mut high] = [0.0, FRAC_PI_2];
    let mut angle = 0.5 * FRAC_PI_2;
    let (mut s, mut c) = sin_cos(angle);
    for _ in 0..MAX_ITERATIONS {
        let slope = (b * b - a * a) * s * c + a * x * s - b * y * c;
        let curvature = (b * b - a * a) * (c * c - s * s) + a * x * c + b * y * s;
        if slope > 0.0 {
            high = angle
        } else {
            low = angle
        }
        let newton = angle - slope / curvature;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        let change = (next - angle).abs();
        angle = next;
        (s, c) = sin_cos(angle);
        if change < 1e-16 {
            break;
        }
    }
    let signed = |[u, v]: [f64; 2]| [u.copysign(local[0]), v.copysign(local[1])];
    let size = hypot(b * c, a * s);
    let normal = signed([b * c / size, a * s / size]);
    (add(center, rotate(signed([a * c, b * s]), axis)), scale(rotate(normal, axis), -1.0))
}

/// Largest number of iterations for the foot of a point on an ellipse; bisection alone needs 53.
const MAX_ITERATIONS: u32 = 60;

/// Returns the rapier pose of a surface.
fn surface_pose(plan: &Plan, id: SurfaceId, poses: &[BodyPose]) -> Pose {
    let surface = surface_pose_in_frame(plan.surface(id));
    id.body.map_or(surface, |body| frame_pose(plan, body, poses) * surface)
}

/// Returns the rapier pose of a body frame from the pose of its centre of mass.
fn frame_pose(plan: &Plan, body: usize, poses: &[BodyPose]) -> Pose {
    let pose = &poses[body];
    let origin = sub(pose.com, rotate(plan.bodies[body].body.com_m, pose.direction));
    let rotation = Rotation { re: pose.direction[0], im: pose.direction[1] };
    Pose::from_parts(Vector::new(origin[0], origin[1]), rotation)
}
