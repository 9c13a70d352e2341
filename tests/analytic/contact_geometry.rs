//! Gap, gap rate and slip of a capsule against a disc, checked by brute force: dense sampling of the capsule's segment, and
//! finite differences of material points that move with their body.

use std::f64::consts::PI;

use crate::support::runs::Random;
use phalanx::analytic::contact::{Capsule, Distal, Geometry, Nearest, distal, nearest, proximal};
use phalanx::fivebar::kinematics::{Directions, directions, passive_rates};
use phalanx::gripper::Lengths;
use phalanx::shape::Placed;

/// Smallest distance from `centre` to the segment, by sampling it densely and refining around the best sample.
fn sampled_distance(base: [f64; 2], axis: [f64; 2], length: f64, centre: [f64; 2]) -> f64 {
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

#[test]
fn gap_and_normal_are_those_of_a_densely_sampled_capsule_on_both_sides_and_past_both_ends() {
    let mut random = Random(3);
    let mut seen = [0; 4];
    for _ in 0..4000 {
        let angle = random.within(-PI, PI);
        let capsule = Capsule {
            base: [random.within(-0.03, 0.03), random.within(-0.03, 0.03)],
            axis: [angle.cos(), angle.sin()],
            length: random.within(0.005, 0.04),
            radius: random.within(0.001, 0.004),
        };
        let (centre, radius) = ([random.within(-0.06, 0.06), random.within(-0.06, 0.06)], random.within(0.01, 0.03));
        let Nearest { foot, normal, gap, .. } = nearest(&capsule, &Placed::disc(radius, centre));
        let distance = sampled_distance(capsule.base, capsule.axis, capsule.length, centre);
        assert!((gap - (distance - capsule.radius - radius)).abs() < 1e-13, "{gap} {distance}");
        // From the disc to the capsule, of length 1, and leading from the centre to the foot.
        assert!((normal[0].hypot(normal[1]) - 1.0).abs() < 1e-15);
        for i in 0..2 {
            assert!((centre[i] + distance * normal[i] - foot[i]).abs() < 1e-13);
        }
        let to = [centre[0] - capsule.base[0], centre[1] - capsule.base[1]];
        let along = to[0] * capsule.axis[0] + to[1] * capsule.axis[1];
        let across = capsule.axis[0] * to[1] - capsule.axis[1] * to[0];
        let region = match (along < 0.0, along > capsule.length) {
            (true, _) => 0,
            (_, true) => 1,
            _ => 2 + usize::from(across > 0.0),
        };
        seen[region] += 1;
    }
    assert!(seen.iter().all(|n| *n > 300), "before, past, right, left: {seen:?}");
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
        let fastest = (rates.a4[0] * v[0] + rates.a4[1] * v[1]).abs().max(1.0);
        v = v.map(|x| x / fastest);
        // Around the tip's joint, so that sides and ends of both phalanges get their share.
        let (away, direction) = (random.within(0.0, 0.05), random.within(-PI, PI));
        let centre =
            [lengths.l21_m * pose.e2[0] + away * direction.cos(), lengths.l21_m * pose.e2[1] + away * direction.sin()];
        cases.push(Case { lengths, gamma, q, v, centre, radius: random.within(0.005, 0.02) });
    }
    cases
}

fn pose_at(case: &Case, s: f64) -> Directions<f64> {
    directions(&case.lengths, case.gamma, [case.q[0] + s * case.v[0], case.q[1] + s * case.v[1]])
}

fn shape(lengths: &Lengths) -> Distal {
    let (sin, cos) = lengths.phi22_rad.sin_cos();
    Distal { l21: lengths.l21_m, t22: lengths.t22_m, w: lengths.half_width_m, phi22: [cos, sin] }
}

/// Base, axis and length of a phalanx.
type Segment = ([f64; 2], [f64; 2], f64);

fn segment(lengths: &Lengths, pose: &Directions<f64>, tip: bool) -> Segment {
    if !tip {
        return ([0.0; 2], pose.e2, lengths.l21_m);
    }
    let (sin, cos) = lengths.phi22_rad.sin_cos();
    let base = [lengths.l21_m * pose.e2[0], lengths.l21_m * pose.e2[1]];
    let axis = [cos * pose.e4[0] - sin * pose.e4[1], sin * pose.e4[0] + cos * pose.e4[1]];
    (base, axis, lengths.t22_m)
}

fn geometry(case: &Case, tip: bool) -> Geometry<f64> {
    let pose = pose_at(case, 0.0);
    let (lengths, object) = (&case.lengths, Placed::disc(case.radius, case.centre));
    if tip {
        let rates = passive_rates(lengths, &pose);
        distal(&pose, &rates, &shape(lengths), &object)
    } else {
        proximal(&pose, lengths.l21_m, lengths.half_width_m, &object)
    }
}

/// d/ds at 0, to sixth order.
fn rate(f: impl Fn(f64) -> f64) -> f64 {
    let h = 1e-3;
    let odd = |k: f64| f(k * h) - f(-k * h);
    (45.0 * odd(1.0) - 9.0 * odd(2.0) + odd(3.0)) / (60.0 * h)
}

#[test]
fn gap_rate_and_slip_are_those_of_the_material_points() {
    let mut worst = [0.0f64; 3];
    let mut seen = [0; 3];
    for case in cases(3000) {
        for tip in [false, true] {
            let found = geometry(&case, tip);
            let (base, axis, length) = segment(&case.lengths, &pose_at(&case, 0.0), tip);
            let w = case.lengths.half_width_m;
            let to = [case.centre[0] - base[0], case.centre[1] - base[1]];
            let along = to[0] * axis[0] + to[1] * axis[1];
            // The nearest point jumps from face to end, and from side to side: keep clear by more than the differences reach.
            let margin = 1.5e-3;
            let distance = found.gap + w + case.radius;
            if along.abs() < margin || (along - length).abs() < margin || distance < margin {
                continue;
            }
            seen[if along < 0.0 {
                0
            } else if along > length {
                1
            } else {
                2
            }] += 1;
            let brute = |s: f64| {
                let (base, axis, length) = segment(&case.lengths, &pose_at(&case, s), tip);
                sampled_distance(base, axis, length, case.centre) - w - case.radius
            };
            worst[0] = worst[0].max((found.gap - brute(0.0)).abs());
            let gap_rate = found.normal_row[0] * case.v[0] + found.normal_row[1] * case.v[1];
            worst[1] = worst[1].max((gap_rate - rate(brute)).abs());
            // The material point of the body that is at the contact now.
            let arm = [found.point[0] - base[0], found.point[1] - base[1]];
            let local = [arm[0] * axis[0] + arm[1] * axis[1], axis[0] * arm[1] - axis[1] * arm[0]];
            let material = |s: f64, i: usize| {
                let (base, axis, _) = segment(&case.lengths, &pose_at(&case, s), tip);
                let normal = [-axis[1], axis[0]];
                base[i] + local[0] * axis[i] + local[1] * normal[i]
            };
            let velocity = [rate(|s| material(s, 0)), rate(|s| material(s, 1))];
            let tangent = [-found.normal[1], found.normal[0]];
            let slip = found.tangent_row[0] * case.v[0] + found.tangent_row[1] * case.v[1];
            worst[2] = worst[2].max((slip - (velocity[0] * tangent[0] + velocity[1] * tangent[1])).abs());
            // The point lies on the surface, and its normal velocity is the rate of the gap: the disc is fixed.
            let normal_velocity = velocity[0] * found.normal[0] + velocity[1] * found.normal[1];
            worst[1] = worst[1].max((gap_rate - normal_velocity).abs());
            let foot = [found.point[0] + w * found.normal[0], found.point[1] + w * found.normal[1]];
            assert!((sampled_distance(base, axis, length, foot)).abs() < 1e-14);
        }
    }
    println!(
        "gap {:e} m, gap rate {:e} m/s, slip {:e} m/s at 1 rad/s; ends and face {seen:?}",
        worst[0], worst[1], worst[2]
    );
    assert!(seen.iter().all(|n| *n > 300), "{seen:?}");
    assert!(worst[0] < 1e-13 && worst[1] < 1e-9 && worst[2] < 1e-9, "{worst:?}");
}

/// Errata 5: on the face of the tip, slip is l21 q̇21 sin(q22 + φ22) − w (q̇21 + q̇22), as finite differences of the material
/// points confirm; Table B.1 prints l21 q̇21 + w (q̇21 + q̇22).
#[test]
fn errata_05_slip_of_the_tip() {
    let (mut faces, mut right_worst, mut printed_near) = (0, 0.0f64, 0);
    for case in cases(2000) {
        let found = geometry(&case, true);
        let pose = pose_at(&case, 0.0);
        let (base, axis, length) = segment(&case.lengths, &pose, true);
        let to = [case.centre[0] - base[0], case.centre[1] - base[1]];
        let (along, left) = (to[0] * axis[0] + to[1] * axis[1], axis[0] * to[1] - axis[1] * to[0]);
        // The object on the left of the tip, where a finger that closes counter-clockwise meets it.
        if along < 0.0 || along > length || left < 0.0 {
            continue;
        }
        faces += 1;
        let rates = passive_rates(&case.lengths, &pose);
        let (l21, w) = (case.lengths.l21_m, case.lengths.half_width_m);
        let turning = rates.a4[0] * case.v[0] + rates.a4[1] * case.v[1];
        let bend = (pose.e2[0] * axis[1] - pose.e2[1] * axis[0]).atan2(pose.e2[0] * axis[0] + pose.e2[1] * axis[1]);
        let slip = found.tangent_row[0] * case.v[0] + found.tangent_row[1] * case.v[1];
        let right = l21 * case.v[1] * bend.sin() - w * turning;
        let printed = l21 * case.v[1] + w * turning;
        right_worst = right_worst.max((slip - right).abs());
        printed_near += usize::from((slip - printed).abs() < 1e-3 * slip.abs());
        // Along the phalanx, towards its end.
        assert!((found.normal[1] - -axis[0]).abs() < 1e-14 && (found.normal[0] - axis[1]).abs() < 1e-14);
    }
    println!("faces {faces}, right form off by {right_worst:e} m/s, printed form near in {printed_near}");
    assert!(faces > 200);
    assert!(right_worst < 1e-15, "{right_worst:e}");
    assert!(printed_near * 50 < faces, "{printed_near} of {faces}");
}
