//! What is asked of a shape, held to its support function and to the polygon of its surface.

use std::f64::consts::{PI, TAU};

use phalanx::gripper::polygon_moments;
use phalanx::numeric::plane::{Vector, cross, dot, perp, scale, sub};
use phalanx::numeric::{Dual, Real};
use phalanx::shape::{
    Placed, Shape, curvature, facing, inertia, mass, other_tangent, reach, round, seen_from, sizes, support, tangent,
};

/// All shapes there are.
const SHAPES: [Shape; 1] = [Shape::Disc { radius_m: 0.02 }];

/// Every shape, turned and out of the origin.
fn placed() -> impl Iterator<Item = Placed> {
    let turned =
        |shape: Shape| [0.0, 0.4, -1.9].map(|angle_rad| Placed { shape, centre_m: [-0.031, 0.024], angle_rad });
    SHAPES.into_iter().flat_map(turned)
}

fn directions(count: usize) -> impl Iterator<Item = (f64, Vector<f64>)> {
    (0..count).map(move |k| 0.1 + TAU * k as f64 / count as f64).map(|angle| (angle, [angle.cos(), angle.sin()]))
}

fn is_near(found: f64, expected: f64, within: f64) {
    assert!((found - expected).abs() <= within, "{found} is not {expected}");
}

#[test]
fn a_support_function_has_its_slope() {
    let h = 1e-5;
    for placed in placed() {
        for (angle, direction) in directions(37) {
            let at = |angle: f64| support(&placed, [angle.cos(), angle.sin()]).distance;
            let found = support(&placed, direction);
            is_near(found.slope, (at(angle + h) - at(angle - h)) / (2.0 * h), 1e-9);
            // Turned with the body, nothing changes; by its angle alone, the distance grows by −h'.
            let turned = |angle_rad: f64| Placed { angle_rad, ..placed };
            let by_angle = |by: f64| support(&turned(placed.angle_rad + by), direction).distance;
            is_near((by_angle(h) - by_angle(-h)) / (2.0 * h), -found.slope, 1e-9);
            let placed = Placed {
                shape: placed.shape,
                centre_m: placed.centre_m.map(Dual::<1>::constant),
                angle_rad: Dual::variable(placed.angle_rad, 0),
            };
            let dual = support(&placed, direction.map(Dual::constant));
            is_near(dual.distance.grad[0], -found.slope, 1e-12);
        }
    }
}

#[test]
fn no_point_of_the_surface_is_beyond_a_tangent_and_one_is_on_it() {
    for placed in placed() {
        let outline = placed.outline_m();
        for (_, direction) in directions(37) {
            let along = |point: Vector<f64>| dot(direction, sub(point, placed.centre_m));
            let distance = support(&placed, direction).distance;
            is_near(along(placed.furthest_m(direction)), distance, 1e-15);
            assert!(outline.iter().all(|point| along(*point) <= distance + 1e-15));
        }
        is_near(placed.lowest_m()[1], outline.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min), 5e-5);
        let far = outline.iter().map(|point| dot(sub(*point, placed.centre_m), sub(*point, placed.centre_m)).sqrt());
        is_near(far.fold(0.0, f64::max), reach(&placed.shape), 1e-5);
        assert!(round(&placed.shape).is_none_or(|radius_m| radius_m == reach(&placed.shape)));
    }
}

#[test]
fn what_is_nearest_lies_along_the_normal() {
    for placed in placed() {
        let outline = placed.outline_m();
        for (_, direction) in directions(29) {
            for far in [1e-4, 0.01, 0.2] {
                let surface = placed.furthest_m(direction);
                let point = [0, 1].map(|i| surface[i] + far * direction[i]);
                let (normal, distance) = seen_from(&placed, point);
                (0..2).for_each(|i| is_near(normal[i], direction[i], 1e-9));
                is_near(distance - support(&placed, normal).distance, far, 1e-12);
            }
        }
        for (_, direction) in directions(11) {
            for other in SHAPES {
                let apart = reach(&placed.shape) + reach(&other) + 0.003;
                let centre_m = [0, 1].map(|i| placed.centre_m[i] + apart * direction[i]);
                let other = Placed { shape: other, centre_m, angle_rad: 0.7 };
                let (normal, distance) = facing([&other, &placed]);
                let gap = distance - support(&other, scale(normal, -1.0)).distance - support(&placed, normal).distance;
                let of = |one: &Vector<f64>| {
                    let away = |two: Vector<f64>| dot(sub(two, *one), sub(two, *one)).sqrt();
                    other.outline_m().into_iter().map(away).fold(f64::INFINITY, f64::min)
                };
                // Corners of both outlines are apart along their surfaces too.
                is_near(outline.iter().map(of).fold(f64::INFINITY, f64::min), gap, 2e-4);
            }
        }
    }
}

/// A line at a distance to the right of a shape touches it at its length.
#[test]
fn tangents_touch() {
    let w = 0.0025;
    for placed in placed() {
        let first = tangent(&placed, w).expect("the origin is outside");
        let touches = |from: Vector<f64>, angle: f64, length_m: f64| {
            let along = [angle.cos(), angle.sin()];
            let right = scale(perp(along), -1.0);
            let point = placed.furthest_m(right);
            is_near(cross(along, sub(point, from)), w, 1e-12);
            is_near(dot(along, sub(point, from)), length_m, 1e-12);
        };
        touches([0.0; 2], first.angle_rad, first.length_m);
        for beyond_m in [1e-3, 0.012] {
            let length_m = first.length_m + beyond_m;
            let joint = [length_m * first.angle_rad.cos(), length_m * first.angle_rad.sin()];
            let second = other_tangent(&placed, w, &first, beyond_m);
            assert!((0.0..PI).contains(&second.angle_rad), "{second:?}");
            touches(joint, first.angle_rad + second.angle_rad, second.length_m);
        }
        let [x, y] = placed.centre_m;
        let near = placed.at([0.1 * x, 0.1 * y]);
        assert!(tangent(&near, w).is_err_and(|least_m| least_m >= 0.1 * x.hypot(y)));
    }
}

#[test]
fn mass_and_inertia_are_those_of_the_outline() {
    for shape in SHAPES {
        let found = polygon_moments(&shape.at([0.0; 2]).outline_m());
        let mass_kg = mass(&shape, 1070.0, 0.04);
        // The polygon lacks what is beyond its edges: (2π/96)²/6 of the area, twice that of the second moment.
        is_near(mass_kg, 1070.0 * 0.04 * found.area_m2, 1e-3 * mass_kg);
        is_near(inertia(&shape, mass_kg), 1070.0 * 0.04 * found.second_moment_m4, 2e-3 * inertia(&shape, mass_kg));
        assert!(sizes(&shape).all(|(_, size_m)| size_m <= reach(&shape)));
        assert!(curvature(&shape) > 0.0);
    }
}
