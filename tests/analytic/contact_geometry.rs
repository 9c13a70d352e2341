//! Gap, gap rate and slip of a capsule against a disc, compared with dense sampling of the segment of the capsule and
//! with finite differences of material points.

use std::f64::consts::PI;

use crate::support::runs::{Random, assert_below};
use phalanx::analytic::{DistalShape, Geometry, distal, proximal};
use phalanx::fivebar::kinematics::{Capsule, ClosestPoints, closest_points};
use phalanx::fivebar::kinematics::{Directions, directions, passive_rates};
use phalanx::gripper::Lengths;
use phalanx::shape::PlacedShape;

/// Base, axis and length of a phalanx.
type Segment = ([f64; 2], [f64; 2], f64);

/// Smallest distance from `centre` to the segment, by dense sampling and refinement around the best sample.
fn sampled_distance((base, axis, length): Segment, centre: [f64; 2]) -> f64 {
    let distance = |s: f64| (base[0] + s * axis[0] - centre[0]).hypot(base[1] + s * axis[1] - centre[1]);
    let (mut low, mut high) = (0.0, length);
    for _ in 0..10 {
        let step = (high - low) / 50.0;
        let sample = |i: u32| low + f64::from(i) * step;
        let best = (0..=50).map(sample).min_by(|a, b| distance(*a).total_cmp(&distance(*b))).expect("samples");
        (low, high) = ((best - step).max(0.0), (best + step).min(length));
    }
    distance(0.5 * (low + high)).min(distance(low)).min(distance(high))
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Coordinates of a point along and across an axis through a base.
fn in_frame(base: [f64; 2], axis: [f64; 2], point: [f64; 2]) -> (f64, f64) {
    let arm = [point[0] - base[0], point[1] - base[1]];
    (dot(arm, axis), axis[0] * arm[1] - axis[1] * arm[0])
}

#[test]
fn gap_and_normal_match_a_densely_sampled_capsule() {
    let mut random = Random(3);
    let mut region_counts = [0; 4];
    for _ in 0..4000 {
        let angle = random.within(-PI, PI);
        let capsule = Capsule {
            base: [random.within(-0.03, 0.03), random.within(-0.03, 0.03)],
            axis: [angle.cos(), angle.sin()],
            length: random.within(0.005, 0.04),
            radius: random.within(0.001, 0.004),
        };
        let (centre, radius) = ([random.within(-0.06, 0.06), random.within(-0.06, 0.06)], random.within(0.01, 0.03));
        let ClosestPoints { foot, normal, gap, .. } = closest_points(&capsule, &PlacedShape::disc(radius, centre));
        let distance = sampled_distance((capsule.base, capsule.axis, capsule.length), centre);
        assert!((gap - (distance - capsule.radius - radius)).abs() < 1e-13, "{gap} {distance}");
        // The normal has length 1 and points from the centre of the disc to the foot point.
        assert!((normal[0].hypot(normal[1]) - 1.0).abs() < 1e-15);
        for i in 0..2 {
            assert!((centre[i] + distance * normal[i] - foot[i]).abs() < 1e-13);
        }
        let (along, across) = in_frame(capsule.base, capsule.axis, centre);
        let region = match (along < 0.0, along > capsule.length) {
            (true, _) => 0,
            (_, true) => 1,
            _ => 2 + usize::from(across > 0.0),
        };
        region_counts[region] += 1;
    }
    assert!(region_counts.iter().all(|n| *n > 300), "before, past, right, left: {region_counts:?}");
}

/// A random finger at a random state with a disc near it.
struct Case {
    lengths: Lengths,
    gamma: f64,
    q: [f64; 2],
    v: [f64; 2],
    centre: [f64; 2],
    radius: f64,
}

fn cases(count: usize) -> Vec<Case> {
    let mut random = Random(5);
    let mut cases = Vec::new();
    while cases.len() < count {
        let lengths = random.finger().lengths;
        let gamma = if random.within(0.0, 1.0) < 0.5 { 1.0 } else { -1.0 };
        let q = [random.within(-3.0, 3.0), random.within(-3.0, 3.0)];
        let pose = directions(&lengths, gamma, q);
        let sine = pose.e3[0] * pose.e4[1] - pose.e3[1] * pose.e4[0];
        if !(sine.is_finite() && sine.abs() > 0.2) {
            continue;
        }
        let rates = passive_rates(&lengths, &pose);
        let mut v = [random.within(-1.0, 1.0), random.within(-1.0, 1.0)];
        let largest_rate = (rates.a4[0] * v[0] + rates.a4[1] * v[1]).abs().max(1.0);
        v = v.map(|x| x / largest_rate);
        // The disc is near the joint of the distal phalanx, so that the cases cover sides and ends of both phalanges.
        let (distance_from_joint, direction) = (random.within(0.0, 0.05), random.within(-PI, PI));
        let centre = [
            lengths.l21_m * pose.e2[0] + distance_from_joint * direction.cos(),
            lengths.l21_m * pose.e2[1] + distance_from_joint * direction.sin(),
        ];
        cases.push(Case { lengths, gamma, q, v, centre, radius: random.within(0.005, 0.02) });
    }
    cases
}

fn pose_at(case: &Case, s: f64) -> Directions<f64> {
    directions(&case.lengths, case.gamma, [case.q[0] + s * case.v[0], case.q[1] + s * case.v[1]])
}

fn distal_shape(lengths: &Lengths) -> DistalShape {
    let (sin, cos) = lengths.phi22_rad.sin_cos();
    DistalShape { l21: lengths.l21_m, t22: lengths.t22_m, w: lengths.half_width_m, phi22: [cos, sin] }
}

fn segment(lengths: &Lengths, pose: &Directions<f64>, is_distal: bool) -> Segment {
    if !is_distal {
        return ([0.0; 2], pose.e2, lengths.l21_m);
    }
    let (sin, cos) = lengths.phi22_rad.sin_cos();
    let base = [lengths.l21_m * pose.e2[0], lengths.l21_m * pose.e2[1]];
    let axis = [cos * pose.e4[0] - sin * pose.e4[1], sin * pose.e4[0] + cos * pose.e4[1]];
    (base, axis, lengths.t22_m)
}

fn geometry(case: &Case, is_distal: bool) -> Geometry<f64> {
    let pose = pose_at(case, 0.0);
    let (lengths, object) = (&case.lengths, PlacedShape::disc(case.radius, case.centre));
    if is_distal {
        let rates = passive_rates(lengths, &pose);
        distal(&pose, &rates, &distal_shape(lengths), &object)
    } else {
        proximal(&pose, lengths.l21_m, lengths.half_width_m, &object)
    }
}

/// df/ds at s = 0, by central differences of sixth order.
fn derivative(f: impl Fn(f64) -> f64) -> f64 {
    let h = 1e-3;
    let antisymmetric_difference = |k: f64| f(k * h) - f(-k * h);
    (45.0 * antisymmetric_difference(1.0) - 9.0 * antisymmetric_difference(2.0) + antisymmetric_difference(3.0))
        / (60.0 * h)
}

#[test]
fn gap_rate_and_slip_match_finite_differences_of_material_points() {
    let mut max_errors = [0.0f64; 3];
    let mut region_counts = [0; 3];
    for case in cases(3000) {
        for is_distal in [false, true] {
            let contact = geometry(&case, is_distal);
            let (base, axis, length) = segment(&case.lengths, &pose_at(&case, 0.0), is_distal);
            let w = case.lengths.half_width_m;
            let (along, _) = in_frame(base, axis, case.centre);
            // The nearest point jumps between face and end and between sides; cases within reach of the differences are
            // skipped.
            let margin = 1.5e-3;
            let distance = contact.gap + w + case.radius;
            if along.abs() < margin || (along - length).abs() < margin || distance < margin {
                continue;
            }
            region_counts[if (0.0..=length).contains(&along) { 2 } else { usize::from(along > 0.0) }] += 1;
            let sampled_gap = |s: f64| {
                sampled_distance(segment(&case.lengths, &pose_at(&case, s), is_distal), case.centre) - w - case.radius
            };
            max_errors[0] = max_errors[0].max((contact.gap - sampled_gap(0.0)).abs());
            let gap_rate = dot(contact.normal_row, case.v);
            max_errors[1] = max_errors[1].max((gap_rate - derivative(sampled_gap)).abs());
            // The material point of the body at the contact point.
            let (x, y) = in_frame(base, axis, contact.point);
            let material = |s: f64, i: usize| {
                let (base, axis, _) = segment(&case.lengths, &pose_at(&case, s), is_distal);
                base[i] + x * axis[i] + y * [-axis[1], axis[0]][i]
            };
            let velocity = [derivative(|s| material(s, 0)), derivative(|s| material(s, 1))];
            let tangent = [-contact.normal[1], contact.normal[0]];
            max_errors[2] = max_errors[2].max((dot(contact.tangent_row, case.v) - dot(velocity, tangent)).abs());
            // The contact point is on the surface. The disc is fixed, so the normal velocity of the point is the gap
            // rate.
            max_errors[1] = max_errors[1].max((gap_rate - dot(velocity, contact.normal)).abs());
            let foot = [contact.point[0] + w * contact.normal[0], contact.point[1] + w * contact.normal[1]];
            assert!((sampled_distance((base, axis, length), foot)).abs() < 1e-14);
        }
    }
    assert!(region_counts.iter().all(|n| *n > 300), "{region_counts:?}");
    assert!(max_errors[0] < 1e-13 && max_errors[1] < 1e-9 && max_errors[2] < 1e-9, "{max_errors:?}");
}

/// Errata 5: on the face of the distal phalanx, slip is l21 q̇21 sin(q22 + φ22) − w (q̇21 + q̇22), which agrees with
/// finite differences of material points. Table B.1 prints l21 q̇21 + w (q̇21 + q̇22).
#[test]
fn errata_05_slip_of_the_distal_phalanx() {
    let (mut face_cases, mut printed_matches) = (0, 0);
    for case in cases(2000) {
        let contact = geometry(&case, true);
        let pose = pose_at(&case, 0.0);
        let (base, axis, length) = segment(&case.lengths, &pose, true);
        let (along, left) = in_frame(base, axis, case.centre);
        // Only cases with the object left of the phalanx, where a finger that closes counter-clockwise meets it.
        if along < 0.0 || along > length || left < 0.0 {
            continue;
        }
        face_cases += 1;
        let (l21, w) = (case.lengths.l21_m, case.lengths.half_width_m);
        let distal_rate = dot(passive_rates(&case.lengths, &pose).a4, case.v);
        let angle = (pose.e2[0] * axis[1] - pose.e2[1] * axis[0]).atan2(dot(pose.e2, axis));
        let slip = dot(contact.tangent_row, case.v);
        assert_below((slip - (l21 * case.v[1] * angle.sin() - w * distal_rate)).abs(), 1e-15, "corrected form");
        let printed = l21 * case.v[1] + w * distal_rate;
        printed_matches += usize::from((slip - printed).abs() < 1e-3 * slip.abs());
        // The normal is perpendicular to the phalanx.
        assert!((contact.normal[1] - -axis[0]).abs() < 1e-14 && (contact.normal[0] - axis[1]).abs() < 1e-14);
    }
    assert!(face_cases > 200);
    assert!(printed_matches * 50 < face_cases, "{printed_matches} of {face_cases}");
}
