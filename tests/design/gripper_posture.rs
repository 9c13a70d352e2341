//! Loop closure, assembly mode, and postures in contact with a disc.

use crate::support::cli::assert_contains;
use crate::support::designs::{R_C, THIRDS, W, assert_near, design_95, sweep_designs};
use crate::support::statics::{Grasp, grasp};
use phalanx::gripper::{
    Assembly, Design, FinalPosture, GraspError, Lengths, Posture, PostureError, ProximalLength, close_loop,
    contact_angle_proximal, contact_proximal, disc, final_posture, gamma, joint_a13, joint_positions, lengths,
    posture_at, start_posture, straight_posture,
};
use phalanx::numeric::plane::{add, cross, rotate, scale, sub};
use phalanx::shape::PlacedShape;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

const SHORTEST: ProximalLength = ProximalLength::Fraction(0.0);

fn finger_95() -> Lengths {
    lengths(&design_95()).unwrap()
}

fn unit(angle: f64) -> [f64; 2] {
    [angle.cos(), angle.sin()]
}

/// Closure error of the loop at A13, relative to the sum of the link lengths.
fn gap(l: &Lengths, p: &Posture) -> f64 {
    let j = joint_positions(l, p);
    let [dx, dy] = sub(add(j.a12_m, scale(unit(p.q11_rad + p.q12_rad), l.l12_m)), j.a13_m);
    dx.hypot(dy) / (l.l11_m + l.l12_m + l.l21_m + l.l22_m)
}

/// Perpendicular distance of `point` from the line through `from` along `direction`, positive on its left.
fn offset(point: [f64; 2], from: [f64; 2], direction: f64) -> f64 {
    cross(unit(direction), sub(point, from))
}

#[test]
fn design_95_has_the_postures_of_the_thesis_and_of_its_simulation() {
    // Experiment 95 starts at q11 = −49.999°, q21 = 40.001° (1-model §1.8), q_0 = 25° open (thesis Table 3.2).
    let Grasp { finger, disc, end } = grasp(&design_95()).unwrap();
    let start = start_posture(&finger.lengths, disc, 25f64.to_radians()).unwrap();
    assert_near(start.q11_rad.to_degrees(), -49.999, 0.0005);
    assert_near(start.q21_rad.to_degrees(), 40.001, 0.0005);
    assert_near(start.q22_rad.to_degrees(), -120.0, 1e-12);
    assert!(gap(&finger.lengths, &start) < 1e-14);
    // An independent simulation gives q11 = 2.088778°, q21 = 65.019991° after 20 ms (1-model §1.8). The tolerances cover its
    // penetration (4 µm at the proximal contact correspond to 0.02°), which the geometry does not include.
    assert_near(end.posture.q21_rad.to_degrees(), 65.0007, 0.00005); // 40.001° + 25°
    assert_near(end.posture.q21_rad.to_degrees(), 65.019991, 0.03);
    assert_near(end.posture.q11_rad.to_degrees(), 2.088778, 0.01);
    assert_near(end.l_c22_m, finger.lengths.t22_m, 1e-15); // at l21,max the contact is at the tip
}

#[test]
fn straight_posture_has_perpendicular_ground_links() {
    // (B.7) ensures this for every design and every q21.
    for design in sweep_designs(THIRDS) {
        let l = lengths(&design).unwrap();
        for q21 in [-3.0, 0.0, 0.7, FRAC_PI_2, 2.0, 7.0] {
            let p = straight_posture(&l, q21).unwrap();
            assert_near(p.q11_rad, q21 - FRAC_PI_2, 1e-14);
            assert_eq!((p.q21_rad, p.q22_rad), (q21, -l.phi22_rad));
            assert!(gap(&l, &p) < 1e-14);
        }
    }
}

#[test]
fn straight_posture_with_another_coupler_uses_the_q11_nearest_to_a_right_angle() {
    for l12_m in [0.016, 0.020, 0.025, 0.034] {
        let l = Lengths { l12_m, ..finger_95() };
        let p = straight_posture(&l, 1.0).unwrap();
        assert!(gap(&l, &p) < 1e-14);
        // The other root is the mirror image of A12 about O–A13.
        let a13 = joint_positions(&l, &p).a13_m;
        let mirrored = 2.0 * a13[1].atan2(a13[0]) - p.q11_rad;
        let deviation = |q: f64| ((q - (1.0 - FRAC_PI_2) + PI).rem_euclid(2.0 * PI) - PI).abs();
        assert!(deviation(p.q11_rad) < deviation(mirrored), "l12 = {l12_m}: {} or {mirrored}", p.q11_rad);
    }
}

#[test]
fn assembly_modes_mirror_a13_about_the_line_a12_a22() {
    let l = finger_95();
    let sign = gamma(&l, Assembly::Reference).unwrap();
    assert_eq!(sign, -1.0); // A13 = (6.5, 20.7) mm lies to the right of the line from (15, 0) to (0, 24.4) mm
    assert_eq!(gamma(&l, Assembly::Other).unwrap(), 1.0);
    let (q11, q21) = (-0.5, 1.1);
    let joints = |assembly| joint_positions(&l, &close_loop(&l, assembly, q11, q21).unwrap());
    let (reference, mirrored) = (joints(Assembly::Reference), joints(Assembly::Other));
    let [dx, dy] = sub(reference.a22_m, reference.a12_m);
    let offset_of = |a13_m: [f64; 2]| offset(a13_m, reference.a12_m, dy.atan2(dx));
    assert_near(offset_of(reference.a13_m), -offset_of(mirrored.a13_m), 1e-16);
    assert!(offset_of(reference.a13_m) * sign > 0.0);
    assert_near(joint_a13(&l, 1.0, q11, q21).unwrap()[0], mirrored.a13_m[0], 1e-16);
}

#[test]
fn both_phalanges_are_tangent_to_the_virtual_circle_in_the_final_posture() {
    for design in sweep_designs(THIRDS) {
        let Grasp { finger, disc, end } = grasp(&design).unwrap();
        let FinalPosture { posture: p, l_c21_m, l_c22_m, phi_c_rad } = end;
        let (l, c, r) = (finger.lengths, disc.centre_m, R_C + W);
        let j = joint_positions(&l, &p);
        assert!(gap(&l, &p) < 1e-14);
        assert_near(offset(c, [0.0, 0.0], p.q21_rad), r, 1e-16);
        let tip = p.q21_rad + p.q22_rad + l.phi22_rad;
        assert_near(offset(c, j.a22_m, tip), r, 1e-16);
        assert_near(tip, phi_c_rad + FRAC_PI_2, 1e-14);
        // The distal contact is along the tip phalanx and at φ_c on the circle.
        let contact = add(j.a22_m, scale(unit(tip), l_c22_m));
        let on_circle = add(c, scale(unit(phi_c_rad), r));
        (0..2).for_each(|i| assert_near(contact[i], on_circle[i], 1e-16));
        assert_near(l_c22_m, l.l21_m - l_c21_m, 1e-16); // equal tangents, errata 14
        // 2-design §2.1: φ_c = angle(A22 − centre) + acos(R / |A22 − centre|); acos loses digits near the end of its domain.
        let [dx, dy] = sub(j.a22_m, c);
        assert_near(phi_c_rad, dy.atan2(dx) + (r / dx.hypot(dy)).acos(), 1e-12);
        // φ_c22,min at l21,min, larger beyond.
        let smallest = 5f64.to_radians();
        assert!(phi_c_rad >= smallest - 1e-12 && (design.l21 != SHORTEST || phi_c_rad <= smallest + 1.7e-14));
    }
}

#[test]
fn contact_rotates_with_the_disc() {
    // A rotation of the disc about O rotates the contact by the same angle and keeps its length.
    let original = contact_proximal(W, disc(&design_95())).unwrap();
    assert_near(original.angle_rad.to_degrees(), 65.0007, 0.00005);
    let rotated = PlacedShape::disc(R_C, rotate(disc(&design_95()).centre_m, unit(0.3)));
    let rotated_contact = contact_proximal(W, rotated).unwrap();
    assert_near(rotated_contact.angle_rad, original.angle_rad + 0.3, 1e-15);
    assert_near(rotated_contact.length_m, original.length_m, 1e-16);
    assert_eq!(contact_angle_proximal(W, rotated).unwrap(), rotated_contact.angle_rad);
}

#[test]
fn errors_of_closure_and_reach_contain_the_values() {
    let l = finger_95();
    let short_coupler = Lengths { l12_m: 0.002, ..l };
    assert!(matches!(gamma(&short_coupler, Assembly::Reference), Err(PostureError::CannotClose { .. })));
    // Stretched: l12 closes exactly the straight line O–A12–A13.
    let a13 = joint_positions(&l, &straight_posture(&l, FRAC_PI_2).unwrap()).a13_m;
    let stretched = Lengths { l12_m: (a13[0].hypot(a13[1]) - l.l11_m) * (1.0 + 1e-15), ..l };
    let error = straight_posture(&stretched, 1.0).unwrap_err();
    assert!(matches!(error, PostureError::Stretched { .. }), "{error}");
    // Opposite ground links have a distance of 39.4 mm, but l12 and l22 reach only 29.9 mm.
    let error = close_loop(&l, Assembly::Reference, 0.0, PI).unwrap_err();
    assert!(error.to_string().contains("must span 39.4324 mm, but can span only 14.8628 to 29.8628 mm"), "{error}");
    let error = straight_posture(&Lengths { l22_m: f64::NAN, ..l }, 1.0).unwrap_err();
    assert!(error.to_string().contains("l22_m is NaN, but must be a finite length above 0"), "{error}");
    assert!(close_loop(&l, Assembly::Reference, f64::INFINITY, 0.0).is_err());

    let error = |l: &Lengths, disc| final_posture(l, Assembly::Reference, disc).unwrap_err();
    let distant_disc = PlacedShape::disc(R_C, [-0.05, 0.02]);
    assert!(matches!(error(&l, distant_disc), GraspError::ProximalTooShort { .. }));
    let short_tip = Lengths { t22_m: 0.005, ..l };
    assert!(matches!(error(&short_tip, disc(&design_95())), GraspError::TipTooShort { .. }));
    let error = contact_proximal(W, PlacedShape::disc(R_C, [-0.01, 0.02])).unwrap_err();
    assert_contains(&error.to_string(), &["22.3607 mm from the ground joint, but must be more than 22.5000 mm"]);
    assert!(contact_proximal(W, PlacedShape::disc(f64::NAN, [-0.01, 0.02])).is_err());
}

fn finger() -> impl Strategy<Value = Lengths> {
    (0.0110f64..0.0235, 0.0f64..1.0, 1.2f64..2.2, 0.2f64..0.8)
        .prop_map(|(b, f, phi, r)| lengths(&Design::thesis(b, ProximalLength::Fraction(f), phi, r)).unwrap())
}

proptest! {
    #[test]
    fn closed_loops_have_no_gap(l in finger(), q11 in -4.0f64..4.0, q21 in -4.0f64..4.0, other in any::<bool>()) {
        let assembly = if other { Assembly::Other } else { Assembly::Reference };
        if let Ok(p) = close_loop(&l, assembly, q11, q21) {
            prop_assert!(gap(&l, &p) < 1e-14, "{p:?}: {:e}", gap(&l, &p));
            prop_assert!((p.q22_rad + l.phi22_rad).abs() <= PI + 1e-12 && p.q12_rad.abs() <= PI + 1e-12);
        }
    }

    #[test]
    fn closure_from_tip_angle_and_from_ground_links_agree(l in finger(), q21 in -3.0f64..3.0, bend in 0.0f64..1.2) {
        let Ok(p) = posture_at(&l, Assembly::Reference, q21, bend - l.phi22_rad) else { return Ok(()) };
        prop_assert!(gap(&l, &p) < 1e-14, "{p:?}: {:e}", gap(&l, &p));
        // The inverse is ill-conditioned near a dead point of the coupler; only there may digits be lost.
        let closed = close_loop(&l, Assembly::Reference, p.q11_rad, q21).unwrap();
        let angle_13 = (p.q11_rad + p.q12_rad - p.q21_rad - p.q22_rad).sin().abs();
        prop_assert!((closed.q22_rad - p.q22_rad).abs() < 1e-13 / angle_13, "{p:?} {closed:?}");
    }

    #[test]
    fn straight_posture_satisfies_loop_closure(l in finger(), q21 in -3.0f64..3.0) {
        let p = straight_posture(&l, q21).unwrap();
        let q = posture_at(&l, Assembly::Reference, q21, -l.phi22_rad).unwrap();
        prop_assert!((p.q11_rad - q.q11_rad).abs() < 1e-12 && (p.q12_rad - q.q12_rad).abs() < 1e-12, "{p:?} {q:?}");
    }
}
