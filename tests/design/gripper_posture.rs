//! Loop closure, assembly mode, and the postures against a disc.

use crate::support::gripper::{R_C, THIRDS, W, assert_near, design_95, sweep};
use phalanx::gripper::{
    Assembly, Design, GraspError, Lengths, Posture, PostureError, ProximalLength, close, contact_angle_proximal,
    contact_proximal, disc, final_posture, gamma, joint_a13, joints, lengths, posture_at, start_posture, straight,
};
use phalanx::shape::Placed;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

fn finger_95() -> Lengths {
    lengths(&design_95()).unwrap()
}

/// How far the loop is from closed at A13, over the sum of its links.
fn gap(l: &Lengths, p: &Posture) -> f64 {
    let j = joints(l, p);
    let (s, c) = (p.q11_rad + p.q12_rad).sin_cos();
    let (dx, dy) = (j.a12_m[0] + l.l12_m * c - j.a13_m[0], j.a12_m[1] + l.l12_m * s - j.a13_m[1]);
    dx.hypot(dy) / (l.l11_m + l.l12_m + l.l21_m + l.l22_m)
}

/// Perpendicular distance of `point` from the line through `from` along `direction`, positive on its left.
fn offset(point: [f64; 2], from: [f64; 2], direction: f64) -> f64 {
    let (s, c) = direction.sin_cos();
    c * (point[1] - from[1]) - s * (point[0] - from[0])
}

#[test]
fn design_95_starts_where_the_thesis_starts() {
    // Experiment 95 starts at q11 = −49.999°, q21 = 40.001° (1-model §1.8), q_0 = 25° open (thesis Table 3.2).
    let start = start_posture(&finger_95(), disc(&design_95()), 25f64.to_radians()).unwrap();
    assert_near(start.q11_rad.to_degrees(), -49.999, 0.0005);
    assert_near(start.q21_rad.to_degrees(), 40.001, 0.0005);
    assert_near(start.q22_rad.to_degrees(), -120.0, 1e-12);
    assert!(gap(&finger_95(), &start) < 1e-14);
}

#[test]
fn design_95_ends_where_its_simulation_settles() {
    // An independent simulation is at q11 = 2.088778°, q21 = 65.019991° after 20 ms (1-model §1.8). It has penetration
    // (4 µm at the proximal contact is 0.02°), which the geometry alone does not: hence the tolerances.
    let end = final_posture(&finger_95(), Assembly::Reference, disc(&design_95())).unwrap();
    assert_near(end.posture.q21_rad.to_degrees(), 65.0007, 0.00005); // 40.001° + 25°
    assert_near(end.posture.q21_rad.to_degrees(), 65.019991, 0.03);
    assert_near(end.posture.q11_rad.to_degrees(), 2.088778, 0.01);
    assert_near(end.l_c22_m, finger_95().t22_m, 1e-15); // l21,max: the contact is at the very tip
}

#[test]
fn straight_has_the_ground_links_at_right_angles() {
    // (B.7) is made for that, whatever the design and wherever l21 points.
    for design in sweep(THIRDS) {
        let l = lengths(&design).unwrap();
        for q21 in [-3.0, 0.0, 0.7, FRAC_PI_2, 2.0, 7.0] {
            let p = straight(&l, q21).unwrap();
            assert_near(p.q11_rad, q21 - FRAC_PI_2, 1e-14);
            assert_eq!((p.q21_rad, p.q22_rad), (q21, -l.phi22_rad));
            assert!(gap(&l, &p) < 1e-14);
        }
    }
}

#[test]
fn straight_with_another_coupler_takes_the_q11_nearest_to_the_right_angle() {
    for l12_m in [0.016, 0.020, 0.025, 0.034] {
        let l = Lengths { l12_m, ..finger_95() };
        let p = straight(&l, 1.0).unwrap();
        assert!(gap(&l, &p) < 1e-14);
        // The other root is the mirror image of A12 about O–A13.
        let a13 = joints(&l, &p).a13_m;
        let mirrored = 2.0 * a13[1].atan2(a13[0]) - p.q11_rad;
        let away = |q: f64| ((q - (1.0 - FRAC_PI_2) + PI).rem_euclid(2.0 * PI) - PI).abs();
        assert!(away(p.q11_rad) < away(mirrored), "l12 = {l12_m}: {} or {mirrored}", p.q11_rad);
    }
}

#[test]
fn assembly_modes_mirror_a13_about_the_line_a12_a22() {
    let l = finger_95();
    let sign = gamma(&l, Assembly::Reference).unwrap();
    assert_eq!(sign, -1.0); // A13 = (6.5, 20.7) mm lies to the right of the line from (15, 0) to (0, 24.4) mm
    assert_eq!(gamma(&l, Assembly::Other).unwrap(), 1.0);
    let (q11, q21) = (-0.5, 1.1);
    let here = joints(&l, &close(&l, Assembly::Reference, q11, q21).unwrap());
    let there = joints(&l, &close(&l, Assembly::Other, q11, q21).unwrap());
    let line = (here.a22_m[1] - here.a12_m[1]).atan2(here.a22_m[0] - here.a12_m[0]);
    assert_near(offset(here.a13_m, here.a12_m, line), -offset(there.a13_m, there.a12_m, line), 1e-16);
    assert!(offset(here.a13_m, here.a12_m, line) * sign > 0.0);
    assert_near(joint_a13(&l, 1.0, q11, q21).unwrap()[0], there.a13_m[0], 1e-16);
}

#[test]
fn both_phalanges_touch_the_virtual_circle_at_the_end() {
    for design in sweep(THIRDS) {
        let (l, circle) = (lengths(&design).unwrap(), disc(&design));
        let end = final_posture(&l, Assembly::Reference, circle).unwrap();
        let (j, p, r) = (joints(&l, &end.posture), end.posture, R_C + W);
        let c = circle.centre_m;
        assert!(gap(&l, &p) < 1e-14);
        assert_near(offset(c, [0.0, 0.0], p.q21_rad), r, 1e-16);
        let tip = p.q21_rad + p.q22_rad + l.phi22_rad;
        assert_near(offset(c, j.a22_m, tip), r, 1e-16);
        assert_near(tip, end.phi_c_rad + FRAC_PI_2, 1e-14);
        // Contacts: along each phalanx, and the tip's at φ_c on the circle.
        let at = [j.a22_m[0] + end.l_c22_m * tip.cos(), j.a22_m[1] + end.l_c22_m * tip.sin()];
        assert_near(at[0], c[0] + r * end.phi_c_rad.cos(), 1e-16);
        assert_near(at[1], c[1] + r * end.phi_c_rad.sin(), 1e-16);
        assert_near(end.l_c22_m, l.l21_m - end.l_c21_m, 1e-16); // equal tangents, errata 14
        // 2-design §2.1: φ_c = angle(A22 − centre) + acos(R / |A22 − centre|); acos loses digits near its edge.
        let (dx, dy) = (j.a22_m[0] - c[0], j.a22_m[1] - c[1]);
        assert_near(end.phi_c_rad, dy.atan2(dx) + (r / dx.hypot(dy)).acos(), 1e-12);
        assert!(end.phi_c_rad >= 5f64.to_radians() - 1e-12); // φ_c22,min at l21,min, more beyond
    }
}

#[test]
fn a_shortest_proximal_phalanx_meets_the_disc_at_the_smallest_contact_angle() {
    let design = Design { l21: ProximalLength::Fraction(0.0), ..design_95() };
    let end = final_posture(&lengths(&design).unwrap(), Assembly::Reference, disc(&design)).unwrap();
    assert_near(end.phi_c_rad.to_degrees(), 5.0, 1e-12);
}

#[test]
fn contact_turns_with_the_disc() {
    // Turning the disc about O turns the contact by the same angle, and leaves its length.
    let here = contact_proximal(W, disc(&design_95())).unwrap();
    assert_near(here.q21_rad.to_degrees(), 65.0007, 0.00005);
    let (s, c) = 0.3f64.sin_cos();
    let [x, y] = disc(&design_95()).centre_m;
    let turned = Placed::disc(R_C, [c * x - s * y, s * x + c * y]);
    let there = contact_proximal(W, turned).unwrap();
    assert_near(there.q21_rad, here.q21_rad + 0.3, 1e-15);
    assert_near(there.length_m, here.length_m, 1e-16);
    assert_eq!(contact_angle_proximal(W, turned).unwrap(), there.q21_rad);
}

#[test]
fn what_cannot_close_or_reach_is_refused_with_numbers() {
    let l = finger_95();
    let short = Lengths { l12_m: 0.002, ..l };
    assert!(matches!(gamma(&short, Assembly::Reference), Err(PostureError::CannotClose { .. })));
    // Stretched: l12 exactly closes the straight line O–A12–A13.
    let a13 = joints(&l, &straight(&l, FRAC_PI_2).unwrap()).a13_m;
    let stretched = Lengths { l12_m: (a13[0].hypot(a13[1]) - l.l11_m) * (1.0 + 1e-15), ..l };
    let error = straight(&stretched, 1.0).unwrap_err();
    assert!(matches!(error, PostureError::Stretched { .. }), "{error}");
    // Ground links opposite each other: 39.4 mm apart, while l12 and l22 reach 29.9 mm.
    let error = close(&l, Assembly::Reference, 0.0, PI).unwrap_err();
    assert!(error.to_string().contains("must span 39.4324 mm, but reach only 14.8628 to 29.8628 mm"), "{error}");
    let error = straight(&Lengths { l22_m: f64::NAN, ..l }, 1.0).unwrap_err();
    assert!(error.to_string().contains("l22_m is NaN, but must be a finite length above 0"), "{error}");
    assert!(close(&l, Assembly::Reference, f64::INFINITY, 0.0).is_err());

    let far = Placed::disc(R_C, [-0.05, 0.02]);
    let error = final_posture(&l, Assembly::Reference, far).unwrap_err();
    assert!(matches!(error, GraspError::ProximalTooShort { .. }), "{error}");
    let stub = Lengths { t22_m: 0.005, ..l };
    let error = final_posture(&stub, Assembly::Reference, disc(&design_95())).unwrap_err();
    assert!(matches!(error, GraspError::TipTooShort { .. }), "{error}");
    let error = contact_proximal(W, Placed::disc(R_C, [-0.01, 0.02])).unwrap_err();
    assert!(
        error.to_string().contains("22.3607 mm from the ground joint, but must be more than 22.5000 mm"),
        "{error}"
    );
    assert!(contact_proximal(W, Placed::disc(f64::NAN, [-0.01, 0.02])).is_err());
}

fn finger() -> impl Strategy<Value = Lengths> {
    (0.0110f64..0.0235, 0.0f64..1.0, 1.2f64..2.2, 0.2f64..0.8)
        .prop_map(|(b, f, phi, r)| lengths(&Design::thesis(b, ProximalLength::Fraction(f), phi, r)).unwrap())
}

proptest! {
    #[test]
    fn closed_loops_close(l in finger(), q11 in -4.0f64..4.0, q21 in -4.0f64..4.0, other in any::<bool>()) {
        let assembly = if other { Assembly::Other } else { Assembly::Reference };
        if let Ok(p) = close(&l, assembly, q11, q21) {
            prop_assert!(gap(&l, &p) < 1e-14, "{p:?}: {:e}", gap(&l, &p));
            prop_assert!((p.q22_rad + l.phi22_rad).abs() <= PI + 1e-12 && p.q12_rad.abs() <= PI + 1e-12);
        }
    }

    #[test]
    fn the_tip_angle_found_from_the_ground_links_leads_back_to_them(l in finger(), q21 in -3.0f64..3.0, bend in 0.0f64..1.2) {
        let Ok(p) = posture_at(&l, Assembly::Reference, q21, bend - l.phi22_rad) else { return Ok(()) };
        prop_assert!(gap(&l, &p) < 1e-14, "{p:?}: {:e}", gap(&l, &p));
        // Near a dead point of the coupler the way back is ill-conditioned: only then may digits be lost.
        let back = close(&l, Assembly::Reference, p.q11_rad, q21).unwrap();
        let angle_13 = (p.q11_rad + p.q12_rad - p.q21_rad - p.q22_rad).sin().abs();
        prop_assert!((back.q22_rad - p.q22_rad).abs() < 1e-13 / angle_13, "{p:?} {back:?}");
    }

    #[test]
    fn straight_is_its_own_closure(l in finger(), q21 in -3.0f64..3.0) {
        let p = straight(&l, q21).unwrap();
        let q = posture_at(&l, Assembly::Reference, q21, -l.phi22_rad).unwrap();
        prop_assert!((p.q11_rad - q.q11_rad).abs() < 1e-12 && (p.q12_rad - q.q12_rad).abs() < 1e-12, "{p:?} {q:?}");
    }
}
