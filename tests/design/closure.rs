//! Closure measures: units of tests/anchors/grasp.json, and random sets of contacts against enumerations.

use crate::support::random::Random;
use phalanx::statics::{
    FrictionContact, GRIP_TOLERANCE, Row, Unilateral, Unknown, decide_form_closure, force_closure, hull_distance,
};
use serde_json::Value;

/// Edges of the friction cones about the origin, written out independently.
fn wrenches(contacts: &[FrictionContact], length: f64) -> Vec<[f64; 3]> {
    let edges = |contact: &FrictionContact| {
        let ([x, y], [nx, ny], mu) = (contact.point_m, contact.push, contact.mu);
        [1.0, -1.0].map(|sign| {
            let force = [nx - sign * mu * ny, ny + sign * mu * nx];
            [force[0], force[1], (x * force[1] - y * force[0]) / length]
        })
    };
    contacts.iter().flat_map(edges).collect()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The distance is the largest gap between the origin and a plane that has all points on its other side. The normal of that
/// plane is a point, a perpendicular to a side from the origin, or the normal of a face.
fn enumerated_distance(points: &[[f64; 3]]) -> f64 {
    let mut directions = points.to_vec();
    for (i, a) in points.iter().enumerate() {
        for b in &points[i + 1..] {
            let side = sub(*b, *a);
            let along = dot(*a, side) / dot(side, side);
            directions.push(std::array::from_fn(|k| a[k] - along * side[k]));
            for c in points {
                let normal = cross(side, sub(*c, *a));
                directions.extend([normal, normal.map(|part| -part)]);
            }
        }
    }
    let gap = |direction: &[f64; 3]| {
        let length = dot(*direction, *direction).sqrt();
        let least = points.iter().map(|point| dot(*point, *direction)).fold(f64::INFINITY, f64::min);
        if length > 1e-12 { least / length } else { 0.0 }
    };
    directions.iter().map(gap).fold(0.0, f64::max)
}

#[test]
fn closure_units_have_their_closed_forms() {
    let text = std::fs::read_to_string("tests/anchors/grasp.json").expect("the anchors");
    let anchors: Value = serde_json::from_str(&text).expect("valid JSON");
    let units = anchors["closure"].as_array().expect("a list");
    assert_eq!(units.len(), 6);
    for unit in units {
        let what = unit["what"].as_str().expect("a name");
        let contact = |numbers: &Value| {
            let [x, y, nx, ny, mu] = [0, 1, 2, 3, 4].map(|k: usize| numbers[k].as_f64().expect("a number"));
            FrictionContact { point_m: [x, y], push: [nx, ny], mu }
        };
        let contacts: Vec<_> = unit["contacts_x_y_nx_ny_mu"].as_array().expect("a list").iter().map(contact).collect();
        let length = unit["length"].as_f64().expect("a length");
        let distance = hull_distance(&contacts, [0.0; 2], length);
        assert!((distance - unit["distance"].as_f64().expect("a distance")).abs() < 1e-9, "{what}: {distance:e}");
        assert_eq!(distance < GRIP_TOLERANCE, unit["gripped"].as_bool().expect("a flag"), "{what}");
        let q1 = force_closure(&contacts, [0.0; 2], length).q1_l1;
        assert!((q1 - unit["q1"].as_f64().expect("Q1")).abs() < 1e-9, "{what}: {q1:e}");
        let unknowns = (0..3).map(|index| Unknown::Coordinate { index }).collect();
        let mut rates = Unilateral::new(unknowns, vec![1.0; 3]);
        for (index, contact) in contacts.iter().enumerate() {
            let ([x, y], [nx, ny]) = (contact.point_m, contact.push);
            rates.append(Row::Constraint { index }, &[nx, ny, (x * ny - y * nx) / length]);
        }
        let closed = decide_form_closure(&rates).expect("a decision").closed;
        assert_eq!(closed, unit["form_closed_fixed_hand"].as_bool().expect("a flag"), "{what}");
    }
}

#[test]
fn distances_of_random_contacts_are_those_of_an_enumeration() {
    let mut random = Random::for_seed(5901);
    let (mut gripped, mut close) = (0, 0);
    for case in 0..3000 {
        let count = 1 + case % 6;
        let mut contacts: Vec<FrictionContact> = (0..count)
            .map(|_| {
                let (angle, turn) = (random.within(-3.2, 3.2), random.within(-0.7, 0.7));
                let mu = if random.chance(0.3) { 0.0 } else { random.within(0.0, 1.0) };
                let radius = random.within(0.3, 1.0);
                FrictionContact {
                    point_m: [radius * angle.cos(), radius * angle.sin()],
                    push: [-(angle + turn).cos(), -(angle + turn).sin()],
                    mu,
                }
            })
            .collect();
        // Coincident and opposite contacts, with a misalignment about the tolerance.
        if random.chance(0.3) {
            // Without a moment.
            let [x, y] = contacts[0].point_m;
            contacts[0].push = [-x, -y].map(|part| part / x.hypot(y));
            let mut other = contacts[0];
            if random.chance(0.7) {
                let turn = std::f64::consts::PI + random.log_within(1e-12, 1e-3);
                let turned = |[x, y]: [f64; 2]| [turn.cos() * x - turn.sin() * y, turn.sin() * x + turn.cos() * y];
                (other.point_m, other.push) = (turned(other.point_m), turned(other.push));
            }
            contacts.push(other);
        }
        let expected = enumerated_distance(&wrenches(&contacts, 1.0));
        let found = hull_distance(&contacts, [0.0; 2], 1.0);
        // The normal of a plane near the origin is a difference of coordinates: its direction has the rounding error ε/d.
        let tolerance = (4e-16 / expected.max(1e-8)).max(1e-10);
        assert!((found - expected).abs() < tolerance, "{case}: {found:e}, not {expected:e}: {contacts:?}");
        gripped += usize::from(found < GRIP_TOLERANCE);
        close += usize::from(found < GRIP_TOLERANCE && found > 1e-8);
    }
    assert!(gripped > 300 && gripped < 2700 && close > 3, "{gripped} {close}");
}

#[test]
fn contacts_without_a_grip_have_their_distances() {
    let push = |angle: f64, mu: f64| {
        let (sin, cos) = angle.sin_cos();
        FrictionContact { point_m: [-cos, -sin], push: [cos, sin], mu }
    };
    assert_eq!(hull_distance(&[], [0.0; 2], 1.0), f64::INFINITY);
    // Opposite normals without friction, misaligned by an angle: the middle of both is sin(angle/2) away.
    for angle in [1e-8, 1e-5, 0.1f64] {
        let found = hull_distance(&[push(0.0, 0.0), push(std::f64::consts::PI - angle, 0.0)], [0.0; 2], 1.0);
        assert!((found - (0.5 * angle).sin()).abs() < 1e-15, "{angle}: {found:e}");
    }
    // Moments count over the radius: two parallel lines of action, 1 m apart, of opposite normals have the moment 1/2.
    let apart = [([-1.0, 0.5], 1.0), ([1.0, -0.5], -1.0)].map(|(point_m, nx)| FrictionContact {
        point_m,
        push: [nx, 0.0],
        mu: 0.0,
    });
    assert!((hull_distance(&apart, [0.0; 2], 2.0) - 0.25).abs() < 1e-15);
}
