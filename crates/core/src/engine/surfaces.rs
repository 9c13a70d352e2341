//! Two surfaces at given places: of shapes that parry does not know, by their support functions.

use super::linkage::Place;
use super::plan::{Against, Capsule, Plan, PlannedContact, Shape};
#[cfg(test)]
use super::world::{collider, polygon};
use crate::numeric::elementary::{atan2, cos, sin};
use crate::numeric::plane::{add, dot, perp, rotate, scale, sub};
use crate::shape::{Placed, facing, round, seen_from, support};

/// The gap, the nearest point of each, and the normal from the other surface to the body's.
#[derive(Clone, Copy, Debug)]
pub struct Surfaces {
    pub gap: f64,
    pub point: [f64; 2],
    pub other_point: [f64; 2],
    pub normal: [f64; 2],
}

/// A surface and its frame.
#[derive(Clone, Copy, Debug)]
struct At {
    shape: Shape,
    origin: [f64; 2],
    /// Of its x axis.
    direction: [f64; 2],
    angle: f64,
}

/// Those of a contact of which one is of a shape that is not round.
pub fn of_shapes(plan: &Plan, contact: &PlannedContact, places: &[Place]) -> Option<Surfaces> {
    let of = |against: Against| match against {
        Against::Body(body) => plan.bodies[body].shape,
        Against::Fixed(index) => Some(plan.fixed[index].shape),
    };
    let turns = |shape: &Shape| matches!(shape, Shape::Disc(shape) if round(shape).is_none());
    let [own, other] = [of(Against::Body(contact.body))?, of(contact.against)?];
    if !turns(&own) && !turns(&other) {
        return None;
    }
    let body = |index: usize, shape: Shape| {
        let Place { com, direction, angle } = places[index];
        At { shape, origin: sub(com, rotate(plan.bodies[index].body.com_m, direction)), direction, angle }
    };
    let other = match contact.against {
        Against::Body(index) => body(index, other),
        Against::Fixed(index) => {
            let (direction, origin) = (plan.fixed[index].direction, plan.fixed[index].origin_m);
            At { shape: other, origin, direction, angle: atan2(direction[1], direction[0]) }
        }
    };
    nearest(&body(contact.body, own), &other)
}

/// Two convex surfaces are as far apart as along that normal along which they are furthest: of those that may be it, the best one.
fn nearest(own: &At, other: &At) -> Option<Surfaces> {
    let placed = |at: &At, shape| Placed { shape, centre_m: at.origin, angle_rad: at.angle };
    let (gap, normal, other_point) = match (own.shape, other.shape) {
        (Shape::Capsule(Capsule { length_m, angle_rad, radius_m }), Shape::Disc(shape)) => {
            let other = placed(other, shape);
            let along = rotate([cos(angle_rad), sin(angle_rad)], own.direction);
            let (ends, across) = ([own.origin, add(own.origin, scale(along, length_m))], perp(along));
            let [from_first, from_last] = ends.map(|end| seen_from(&other, end).0);
            let apart = |normal: [f64; 2]| {
                let [first, last] = ends.map(|end| dot(normal, sub(end, other.centre_m)));
                let found = support(&other, normal);
                (first.min(last) - radius_m - found.distance, normal, add(other.centre_m, found.point(normal)))
            };
            let all = [across, scale(across, -1.0), from_first, from_last].map(apart);
            all.into_iter().max_by(|one, two| one.0.total_cmp(&two.0))?
        }
        (Shape::Disc(shape), Shape::HalfPlane) => {
            let (own, normal) = (placed(own, shape), perp(other.direction));
            let found = support(&own, scale(normal, -1.0));
            let gap = dot(normal, sub(own.centre_m, other.origin)) - found.distance;
            let point = add(own.centre_m, found.point(scale(normal, -1.0)));
            (gap, normal, sub(point, scale(normal, gap)))
        }
        (Shape::Disc(shape), Shape::Disc(others)) => {
            let (own, other) = (placed(own, shape), placed(other, others));
            let (normal, distance) = facing([&own, &other]);
            let found = support(&other, normal);
            let gap = distance - (support(&own, scale(normal, -1.0)).distance + found.distance);
            (gap, normal, add(other.centre_m, found.point(normal)))
        }
        _ => return None,
    };
    Some(Surfaces { gap, point: add(other_point, scale(normal, gap)), other_point, normal })
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

    fn at(shape: Shape, origin: [f64; 2], angle: f64) -> At {
        At { shape, origin, direction: [cos(angle), sin(angle)], angle }
    }

    /// The gap and the normal that parry finds for colliders in place of both surfaces.
    fn by_parry(colliders: [ColliderBuilder; 2], [own, other]: [&At; 2]) -> (f64, [f64; 2]) {
        let pose = |at: &At| Pose::new(Vector::new(at.origin[0], at.origin[1]), at.angle);
        let [one, two] = colliders.map(|builder| builder.build());
        let found = contact(&pose(other), two.shape(), &pose(own), one.shape(), Real::MAX).expect("known shapes");
        let found = found.expect("no distance is too far");
        (found.dist, [found.normal1.x, found.normal1.y])
    }

    /// Of round shapes parry says the same, and so it does, but for their corners, of the polygons that stand for shapes.
    #[test]
    fn surfaces_are_as_near_as_parry_finds_them() {
        let mut tried = 0;
        for k in 0..400 {
            let (turn, far) = (0.7 * f64::from(k), 0.006 + 1.3e-4 * f64::from(k));
            let place = [0.012 + far * cos(0.37 * turn), 0.004 + far * sin(0.37 * turn)];
            let (disc, other) = (at(DISCS[k as usize % 2], place, turn), at(DISCS[1], [0.0; 2], -turn));
            let plane = At { shape: Shape::HalfPlane, ..at(Shape::HalfPlane, [0.01, -0.01], 0.2) };
            for (own, other) in [(at(CAPSULE, [0.001, -0.002], turn), disc), (disc, other), (disc, plane)] {
                let found = nearest(&own, &other).expect("surfaces that can meet");
                // Deep inside of each other surfaces are nearest in more than one way.
                if found.gap < -0.001 {
                    continue;
                }
                tried += 1;
                let (gap, normal) = by_parry([own.shape, other.shape].map(collider), [&own, &other]);
                let turned = hypot(normal[0] - found.normal[0], normal[1] - found.normal[1]);
                assert!(
                    (gap - found.gap).abs() < 1e-12 && turned < 1e-9,
                    "{own:?} {other:?}: {gap} {normal:?} {found:?}"
                );
                let between = sub(found.point, found.other_point);
                assert!((dot(between, found.normal) - gap).abs() < 1e-12, "{found:?}");
                let standing = |shape: Shape| match shape {
                    Shape::Disc(shape) => polygon(&shape),
                    other => collider(other),
                };
                let (rough, _) = by_parry([own.shape, other.shape].map(standing), [&own, &other]);
                assert!((-1e-9..5e-5).contains(&(rough - gap)), "{own:?} {other:?}: {rough} {gap}");
            }
        }
        assert!(tried > 600, "{tried}");
    }
}
