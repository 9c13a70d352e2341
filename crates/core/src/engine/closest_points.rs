//! Closest points of two surfaces whose shapes parry does not support, from their support functions.

use super::linkage::BodyPose;
use super::plan::{Capsule, ContactPartner, Plan, PlannedContact, Shape};
#[cfg(test)]
use super::world::{collider, polygon};
use crate::numeric::elementary::{atan2, cos, sin};
use crate::numeric::plane::{add, dot, perp, rotate, scale, sub};
use crate::shape::{PlacedShape, circle_radius, normal_between, normal_towards, support};

/// Gap, closest point on each surface, and normal from the other surface to the body's.
#[derive(Clone, Copy, Debug)]
pub struct ClosestPoints {
    pub gap: f64,
    pub point: [f64; 2],
    pub other_point: [f64; 2],
    pub normal: [f64; 2],
}

/// A surface and its frame.
#[derive(Clone, Copy, Debug)]
struct PlacedSurface {
    shape: Shape,
    origin: [f64; 2],
    /// Direction of the x axis.
    direction: [f64; 2],
    angle: f64,
}

/// Returns the closest points of a contact; `None` if both surfaces are round or flat, which parry handles.
pub(crate) fn closest_points_of_shapes(
    plan: &Plan,
    contact: &PlannedContact,
    poses: &[BodyPose],
) -> Option<ClosestPoints> {
    let shape_of = |partner: ContactPartner| match partner {
        ContactPartner::Body(body) => plan.bodies[body].shape,
        ContactPartner::Fixed(index) => Some(plan.fixed_surfaces[index].shape),
    };
    let is_non_round = |shape: &Shape| matches!(shape, Shape::Disc(shape) if circle_radius(shape).is_none());
    let [first, other] = [shape_of(ContactPartner::Body(contact.body))?, shape_of(contact.against)?];
    if !is_non_round(&first) && !is_non_round(&other) {
        return None;
    }
    let body = |index: usize, shape: Shape| {
        let BodyPose { com, direction, angle } = poses[index];
        PlacedSurface { shape, origin: sub(com, rotate(plan.bodies[index].body.com_m, direction)), direction, angle }
    };
    let other = match contact.against {
        ContactPartner::Body(index) => body(index, other),
        ContactPartner::Fixed(index) => {
            let (direction, origin) = (plan.fixed_surfaces[index].direction, plan.fixed_surfaces[index].origin_m);
            PlacedSurface { shape: other, origin, direction, angle: atan2(direction[1], direction[0]) }
        }
    };
    compute_closest_points(&body(contact.body, first), &other)
}

/// Returns the closest points of two convex surfaces. Their distance is the largest separation along any normal, so the
/// candidate normal with the largest separation is used.
fn compute_closest_points(first: &PlacedSurface, other: &PlacedSurface) -> Option<ClosestPoints> {
    let placed =
        |surface: &PlacedSurface, shape| PlacedShape { shape, centre_m: surface.origin, angle_rad: surface.angle };
    let (gap, normal, other_point) = match (first.shape, other.shape) {
        (Shape::Capsule(Capsule { length_m, angle_rad, radius_m }), Shape::Disc(shape)) => {
            let other = placed(other, shape);
            let axis = rotate([cos(angle_rad), sin(angle_rad)], first.direction);
            let (ends, across) = ([first.origin, add(first.origin, scale(axis, length_m))], perp(axis));
            let [from_first, from_last] = ends.map(|end| normal_towards(&other, end).0);
            let separation = |normal: [f64; 2]| {
                let [at_start, at_end] = ends.map(|end| dot(normal, sub(end, other.centre_m)));
                let support_point = support(&other, normal);
                (
                    at_start.min(at_end) - radius_m - support_point.distance,
                    normal,
                    add(other.centre_m, support_point.point(normal)),
                )
            };
            let separations = [across, scale(across, -1.0), from_first, from_last].map(separation);
            separations.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?
        }
        (Shape::Disc(shape), Shape::HalfPlane) => {
            let (first, normal) = (placed(first, shape), perp(other.direction));
            let support_point = support(&first, scale(normal, -1.0));
            let gap = dot(normal, sub(first.centre_m, other.origin)) - support_point.distance;
            let point = add(first.centre_m, support_point.point(scale(normal, -1.0)));
            (gap, normal, sub(point, scale(normal, gap)))
        }
        (Shape::Disc(shape), Shape::Disc(other_shape)) => {
            let (first, other) = (placed(first, shape), placed(other, other_shape));
            let (normal, distance) = normal_between([&first, &other]);
            let support_point = support(&other, normal);
            let gap = distance - (support(&first, scale(normal, -1.0)).distance + support_point.distance);
            (gap, normal, add(other.centre_m, support_point.point(normal)))
        }
        _ => return None,
    };
    Some(ClosestPoints { gap, point: add(other_point, scale(normal, gap)), other_point, normal })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::elementary::hypot;
    use crate::shape;
    use rapier2d_f64::parry::query::contact;
    use rapier2d_f64::prelude::{ColliderBuilder, Pose, Real, Vector};

    const CAPSULE: Shape = Shape::Capsule(Capsule { length_m: 0.024, angle_rad: 0.3, radius_m: 0.0025 });
    const DISCS: [Shape; 2] =
        [Shape::Disc(shape::Shape::Disc { radius_m: 0.02 }), Shape::Disc(shape::Shape::Disc { radius_m: 0.007 })];

    fn place_surface(shape: Shape, origin: [f64; 2], angle: f64) -> PlacedSurface {
        PlacedSurface { shape, origin, direction: [cos(angle), sin(angle)], angle }
    }

    /// Gap and normal that parry computes for both surfaces, represented by `colliders`.
    fn by_parry(colliders: [ColliderBuilder; 2], [first, other]: [&PlacedSurface; 2]) -> (f64, [f64; 2]) {
        let pose =
            |surface: &PlacedSurface| Pose::new(Vector::new(surface.origin[0], surface.origin[1]), surface.angle);
        let [own_collider, other_collider] = colliders.map(|builder| builder.build());
        let result = contact(&pose(other), other_collider.shape(), &pose(first), own_collider.shape(), Real::MAX)
            .expect("supported shapes");
        let result = result.expect("a result at any distance");
        (result.dist, [result.normal1.x, result.normal1.y])
    }

    /// The results equal parry's results for round shapes. For other shapes, which parry approximates by polygons, they
    /// agree except near corners.
    #[test]
    fn closest_points_agree_with_parry() {
        let mut compared = 0;
        for k in 0..400 {
            let (angle, distance) = (0.7 * f64::from(k), 0.006 + 1.3e-4 * f64::from(k));
            let position = [0.012 + distance * cos(0.37 * angle), 0.004 + distance * sin(0.37 * angle)];
            let (disc, other) =
                (place_surface(DISCS[k as usize % 2], position, angle), place_surface(DISCS[1], [0.0; 2], -angle));
            let plane =
                PlacedSurface { shape: Shape::HalfPlane, ..place_surface(Shape::HalfPlane, [0.01, -0.01], 0.2) };
            for (first, other) in [(place_surface(CAPSULE, [0.001, -0.002], angle), disc), (disc, other), (disc, plane)]
            {
                let points = compute_closest_points(&first, &other).expect("a supported pair of surfaces");
                // The closest points of deeply overlapping surfaces are not unique.
                if points.gap < -0.001 {
                    continue;
                }
                compared += 1;
                let (gap, normal) = by_parry([first.shape, other.shape].map(collider), [&first, &other]);
                let normal_error = hypot(normal[0] - points.normal[0], normal[1] - points.normal[1]);
                assert!(
                    (gap - points.gap).abs() < 1e-12 && normal_error < 1e-9,
                    "{first:?} {other:?}: {gap} {normal:?} {points:?}"
                );
                let between = sub(points.point, points.other_point);
                assert!((dot(between, points.normal) - gap).abs() < 1e-12, "{points:?}");
                let approximation = |shape: Shape| match shape {
                    Shape::Disc(shape) => polygon(&shape),
                    other => collider(other),
                };
                let (approximate, _) = by_parry([first.shape, other.shape].map(approximation), [&first, &other]);
                assert!((-1e-9..5e-5).contains(&(approximate - gap)), "{first:?} {other:?}: {approximate} {gap}");
            }
        }
        assert!(compared > 600, "{compared}");
    }
}
