//! Queries of shapes: comparison with the support function and the polygon of the surface.

use std::f64::consts::{PI, TAU};

use crate::support::designs::assert_near;
use phalanx::gripper::polygon_moments;
use phalanx::numeric::plane::{Vector, cross, dot, perp, scale, sub};
use phalanx::numeric::{Dual, Real};
use phalanx::shape::{
    PlacedShape, Shape, circle_radius, curvature_radius, dimensions, inertia, mass, max_radius, normal_towards,
    second_tangent, support, tangent,
};

/// All kinds of shapes.
const SHAPES: [Shape; 1] = [Shape::Disc { radius_m: 0.02 }];

/// Returns every shape, rotated and away from the origin.
fn placed_shapes() -> impl Iterator<Item = PlacedShape> {
    let rotated =
        |shape: Shape| [0.0, 0.4, -1.9].map(|angle_rad| PlacedShape { shape, centre_m: [-0.031, 0.024], angle_rad });
    SHAPES.into_iter().flat_map(rotated)
}

fn distance(a: Vector<f64>, b: Vector<f64>) -> f64 {
    dot(sub(a, b), sub(a, b)).sqrt()
}

fn directions(count: usize) -> impl Iterator<Item = (f64, Vector<f64>)> {
    (0..count).map(move |k| 0.1 + TAU * k as f64 / count as f64).map(|angle| (angle, [angle.cos(), angle.sin()]))
}

#[test]
fn slope_is_the_derivative_of_the_support_function() {
    let h = 1e-5;
    for placed in placed_shapes() {
        for (angle, direction) in directions(37) {
            let distance_at = |angle: f64| support(&placed, [angle.cos(), angle.sin()]).distance;
            let support_point = support(&placed, direction);
            assert_near(support_point.slope, (distance_at(angle + h) - distance_at(angle - h)) / (2.0 * h), 1e-9);
            // A rotation of the body alone changes the distance by −h'.
            let rotated = |angle_rad: f64| PlacedShape { angle_rad, ..placed };
            let by_angle = |increment: f64| support(&rotated(placed.angle_rad + increment), direction).distance;
            assert_near((by_angle(h) - by_angle(-h)) / (2.0 * h), -support_point.slope, 1e-9);
            let placed = PlacedShape {
                shape: placed.shape,
                centre_m: placed.centre_m.map(Dual::<1>::constant),
                angle_rad: Dual::variable(placed.angle_rad, 0),
            };
            let dual = support(&placed, direction.map(Dual::constant));
            assert_near(dual.distance.grad[0], -support_point.slope, 1e-12);
        }
    }
}

#[test]
fn support_line_touches_the_surface() {
    for placed in placed_shapes() {
        let outline = placed.outline_m();
        for (_, direction) in directions(37) {
            let along = |point: Vector<f64>| dot(direction, sub(point, placed.centre_m));
            let distance = support(&placed, direction).distance;
            assert_near(along(placed.furthest_point_m(direction)), distance, 1e-15);
            assert!(outline.iter().all(|point| along(*point) <= distance + 1e-15));
        }
        let lowest = outline.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
        assert_near(placed.lowest_point_m()[1], lowest, 5e-5);
        let distances = outline.iter().map(|point| distance(*point, placed.centre_m));
        assert_near(distances.fold(0.0, f64::max), max_radius(&placed.shape), 1e-5);
        assert!(circle_radius(&placed.shape).is_none_or(|radius_m| radius_m == max_radius(&placed.shape)));
    }
}

#[test]
fn nearest_points_lie_along_the_normal() {
    for placed in placed_shapes() {
        for (_, direction) in directions(29) {
            for height_m in [1e-4, 0.01, 0.2] {
                let surface = placed.furthest_point_m(direction);
                let point = [0, 1].map(|i| surface[i] + height_m * direction[i]);
                let (normal, distance) = normal_towards(&placed, point);
                (0..2).for_each(|i| assert_near(normal[i], direction[i], 1e-9));
                assert_near(distance - support(&placed, normal).distance, height_m, 1e-12);
            }
        }
    }
}

/// A tangent line at a distance `w` touches the shape at the tangent length.
#[test]
fn tangents_touch_the_surface() {
    let w = 0.0025;
    for placed in placed_shapes() {
        let first = tangent(&placed, w).expect("the origin is outside");
        let assert_tangent = |from: Vector<f64>, angle: f64, length_m: f64| {
            let along = [angle.cos(), angle.sin()];
            let right = scale(perp(along), -1.0);
            let point = placed.furthest_point_m(right);
            assert_near(cross(along, sub(point, from)), w, 1e-12);
            assert_near(dot(along, sub(point, from)), length_m, 1e-12);
        };
        assert_tangent([0.0; 2], first.angle_rad, first.length_m);
        for beyond_m in [1e-3, 0.012] {
            let length_m = first.length_m + beyond_m;
            let joint = [length_m * first.angle_rad.cos(), length_m * first.angle_rad.sin()];
            let second = second_tangent(&placed, w, &first, beyond_m);
            assert!((0.0..PI).contains(&second.angle_rad), "{second:?}");
            assert_tangent(joint, first.angle_rad + second.angle_rad, second.length_m);
        }
        let [x, y] = placed.centre_m;
        let too_close = placed.at([0.1 * x, 0.1 * y]);
        assert!(tangent(&too_close, w).is_err_and(|min_distance_m| min_distance_m >= 0.1 * x.hypot(y)));
    }
}

#[test]
fn mass_and_inertia_match_the_outline() {
    for shape in SHAPES {
        let moments = polygon_moments(&shape.at([0.0; 2]).outline_m());
        let mass_kg = mass(&shape, 1070.0, 0.04);
        // The polygon omits the segments beyond its edges: (2π/96)²/6 of the area, and twice that fraction of the second moment.
        assert_near(mass_kg, 1070.0 * 0.04 * moments.area_m2, 1e-3 * mass_kg);
        let inertia = inertia(&shape, mass_kg);
        assert_near(inertia, 1070.0 * 0.04 * moments.second_moment_m4, 2e-3 * inertia);
        assert!(dimensions(&shape).all(|(_, size_m)| size_m <= max_radius(&shape)));
        assert!(curvature_radius(&shape) > 0.0);
    }
}
