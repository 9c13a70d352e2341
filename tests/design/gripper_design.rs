//! Lengths of designs: values of the thesis, errata 13 to 16, and rejected designs.

use crate::support::designs::{R_C, THIRDS, W, assert_near, design_95, sweep_designs};
use phalanx::gripper::{
    Assembly, Design, DesignError, ProximalLength, contact_proximal, disc, final_posture, lengths, proximal_range,
    start_posture,
};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// 0.05 µm: half a unit of the fourth decimal in mm.
const DIGITS_M: f64 = 0.5e-7;

#[test]
fn design_95_has_the_lengths_of_the_thesis() {
    // Lengths of design 95 in mm to four decimals: thesis §4.3, digits from 1-model §1.8 (t22: errata 16).
    let l = lengths(&design_95()).unwrap();
    assert_near(l.l11_m, 15e-3, 1e-18);
    assert_near(l.l21_m, 24.4324e-3, DIGITS_M);
    assert_near(l.l12_m, 22.3628e-3, DIGITS_M);
    assert_near(l.l22_m, 7.5e-3, 1e-18);
    assert_near(l.t22_m, 12.8566e-3, DIGITS_M);
}

#[test]
fn design_95_is_number_95_of_the_sweep() {
    assert_eq!(sweep_designs(THIRDS)[95 - 1], design_95());
}

/// Minimum l21 by (B.3) and Table B.2 as a line intersection. With `errata_13`, the numerator of x starts with c22; otherwise as printed.
fn l21_min_by_intersection(base: f64, errata_13: bool) -> f64 {
    let r = R_C + W;
    let phi = 5f64.to_radians();
    let l_c = (base * base + R_C * R_C - r * r).sqrt();
    // q_c21 by the half-angle formula of (B.3), with x_c = −base.
    let q = 2.0 * ((-r + (r * r + l_c * l_c - base * base).sqrt()) / (l_c - base)).atan();
    let q = if q < 0.0 { q + PI } else { q };
    let (a21, b21, c21) = (q.sin(), -q.cos(), 0.0);
    let m22 = (phi - FRAC_PI_2).tan();
    let c22 = R_C + r * phi.sin() - m22 * (-base + r * phi.cos());
    let first = if errata_13 { c22 } else { c21 };
    let x = (first + c21 / b21) / (-a21 / b21 - m22);
    let y = (-c22 / m22 + c21 / a21) / (-b21 / a21 - 1.0 / m22);
    x.hypot(y)
}

#[test]
fn errata_13_numerator_of_b3_starts_with_c22() {
    for base in [0.012, 0.0155, 0.019] {
        let design = Design { base_m: base, ..design_95() };
        let (min, _) = proximal_range(&design).unwrap();
        assert_near(min, l21_min_by_intersection(base, true), 1e-14);
        assert!((min - l21_min_by_intersection(base, false)).abs() > 1e-4, "the printed form differs");
    }
}

#[test]
fn errata_14_t22_min_is_the_tangent_length_with_plus_base() {
    for design in sweep_designs(THIRDS) {
        let l = lengths(&design).unwrap();
        let contact = contact_proximal(W, disc(&design)).unwrap();
        let (q, base) = (contact.angle_rad, design.base_m);
        // (B.6) with + base: distance from A22 to the centre (−base, r_c), hence the tangent length.
        let tangent =
            |base: f64| (l.l21_m * q.cos() + base).powi(2) + (R_C - l.l21_m * q.sin()).powi(2) - (R_C + W).powi(2);
        let t22_min = l.l21_m - contact.length_m;
        assert_near(tangent(base).sqrt(), t22_min, 1e-13);
        // The printed −base gives another length or none; the sign has no effect if the l21 line is vertical.
        if q.cos().abs() > 1e-9 {
            assert!((tangent(-base) - t22_min * t22_min).abs() > 1e-6);
        }
    }
}

#[test]
fn errata_14_bounds_of_t22_are_equal_at_l21_max() {
    for base in [0.012, 0.0155, 0.019, 0.0225] {
        let design = Design { base_m: base, ..design_95() };
        let (_, max) = proximal_range(&design).unwrap();
        let contact = contact_proximal(W, disc(&design)).unwrap();
        let t22 = 0.0375 - W - max * contact.angle_rad.sin(); // h = 37.5 mm: 0.9375 · 40 mm
        assert_near(t22, max - contact.length_m, 1e-16);
        // The system (B.4) with + base: A22, then the tip phalanx along its contact angle, ends at the contact.
        let bend = 2.0 * t22.atan2(R_C + W);
        let phi_c = contact.angle_rad - FRAC_PI_2 + bend;
        let (s, c) = phi_c.sin_cos();
        assert_near(max * contact.angle_rad.cos() - t22 * s - (R_C + W) * c + base, 0.0, 1e-16);
        assert_near(max * contact.angle_rad.sin() + t22 * c - (R_C + W) * s - R_C, 0.0, 1e-16);
    }
}

/// Shortest and longest trajectory q11,final − q11,start of the sweep, degrees, with a start opening of 25° (Table 3.2).
fn trajectory_span_deg(fractions: [f64; 4]) -> (f64, f64) {
    let all = sweep_designs(fractions).into_iter().map(|design| {
        let l = lengths(&design).unwrap();
        let start = start_posture(&l, disc(&design), 25f64.to_radians()).unwrap();
        let end = final_posture(&l, Assembly::Reference, disc(&design)).unwrap();
        (end.posture.q11_rad - start.q11_rad).to_degrees()
    });
    all.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), d| (lo.min(d), hi.max(d)))
}

#[test]
fn errata_15_trajectories_span_26_to_75_degrees_with_thirds_only() {
    // 2-design §2.6: 26.03° to 74.63° by an independent computation; the thesis prints 26° to 75°.
    let (lo, hi) = trajectory_span_deg(THIRDS);
    assert_near(lo, 26.03, 0.005);
    assert_near(hi, 74.63, 0.005);
    let (lo, hi) = trajectory_span_deg([0.0, 0.25, 0.5, 0.75]);
    assert!((lo - 26.03).abs() > 0.5 || (hi - 74.63).abs() > 0.5, "quarters as printed: {lo}° to {hi}°");
}

#[test]
fn errata_16_t22_of_design_95_is_12_857_mm() {
    let t22 = lengths(&design_95()).unwrap().t22_m;
    assert_near(t22, 12.857e-3, 0.5e-6);
    assert!((t22 - 12.6e-3).abs() > 0.2e-3, "t22 is close to the misprint of the thesis, 12.6 mm");
}

#[test]
fn a_length_within_the_range_gives_the_same_finger_as_its_fraction() {
    let (min, max) = proximal_range(&design_95()).unwrap();
    let by_length = Design { l21: ProximalLength::Length(max), ..design_95() };
    assert_eq!(lengths(&by_length), lengths(&design_95()));
    let half = Design { l21: ProximalLength::Fraction(0.5), ..design_95() };
    assert_near(lengths(&half).unwrap().l21_m, 0.5 * (min + max), 1e-17);
}

#[test]
fn errors_name_the_value_and_the_allowed_range() {
    let d = design_95();
    let cases = [
        (Design { base_m: 0.010, ..d }, "base is 10.0000 mm, but must be above 10.3078 mm"),
        (Design { base_m: 0.025, ..d }, "base is 25.0000 mm, but must be below 24.3357 mm"),
        (Design { l21: ProximalLength::Length(0.03), ..d }, "l21 is 30.000000 mm, but this base allows 17.604552"),
        (Design { l21: ProximalLength::Length(0.01), ..d }, "l21 is 10.000000 mm, but this base allows 17.604552"),
        (Design { l21: ProximalLength::Length(f64::NAN), ..d }, "l21 is NaN mm"),
        (Design { l21: ProximalLength::Fraction(1.2), ..d }, "fraction of l21 is 1.2, but must lie within 0 and 1"),
        (Design { phi22_rad: PI, ..d }, "phi22 is 180.0000 deg, but must lie between 0 and 180 deg"),
        (Design { phi22_rad: f64::NAN, ..d }, "phi22 is NaN deg"),
        (Design { arm_ratio: 0.0, ..d }, "arm_ratio is 0, but must be a finite number above 0"),
        (Design { l11_m: -0.015, ..d }, "l11_m is -0.015"),
        (Design { half_width_m: f64::INFINITY, ..d }, "half_width_m is inf"),
        (Design { base_m: f64::NAN, ..d }, "base_m is NaN"),
        (Design { height_ratio: 0.4, ..d }, "no l21 fits: it must be at least 17.6046 mm"),
        (Design { tip_contact_min_rad: FRAC_PI_2, ..d }, "tip_contact_min is 90.0000 deg"),
    ];
    for (design, expected) in cases {
        let message = lengths(&design).unwrap_err().to_string();
        assert!(message.contains(expected), "{message:?} does not contain {expected:?}");
    }
}

#[test]
fn rejects_designs_with_aligned_coupler_and_arm() {
    // l22 points from A22 at A12 = (l11, 0) when tan φ22 = −l11/l21.
    let d = design_95();
    let l21 = lengths(&d).unwrap().l21_m;
    let design = Design { phi22_rad: PI - (d.l11_m / l21).atan(), ..d };
    let error = lengths(&design).unwrap_err();
    assert!(matches!(error, DesignError::Loop(_)), "{error}");
    assert!(error.to_string().contains("l12 and l22 are in line"), "{error}");
}

proptest! {
    #[test]
    fn any_input_gives_finite_positive_lengths_or_an_error(
        base in -0.01f64..0.04, fraction in -0.2f64..1.2, phi in -0.5f64..3.5, ratio in -0.1f64..3.0,
        w in 0.0f64..0.01, scale in prop::sample::select(vec![1e-200, 1e-3, 1.0, 1e3, 1e200, f64::NAN, f64::INFINITY]),
    ) {
        let l21 = ProximalLength::Fraction(fraction);
        let mut design = Design::thesis(base * scale, l21, phi, ratio);
        design.half_width_m = w * scale;
        design.l11_m *= scale;
        design.object_radius_m *= scale;
        if let Ok(l) = lengths(&design) {
            for v in [l.l11_m, l.l12_m, l.l21_m, l.l22_m, l.t22_m] {
                prop_assert!(v.is_finite() && v > 0.0, "{l:?}");
            }
        }
    }

    #[test]
    fn tip_length_is_within_its_bounds(
        base in 0.0110f64..0.0235, fraction in 0.0f64..1.0, phi in 1.2f64..2.2, ratio in 0.2f64..0.8,
    ) {
        let design = Design::thesis(base, ProximalLength::Fraction(fraction), phi, ratio);
        let l = lengths(&design).unwrap();
        let contact = contact_proximal(W, disc(&design)).unwrap();
        let (lo, hi) = (l.l21_m - contact.length_m, 0.0375 - W - l.l21_m * contact.angle_rad.sin());
        prop_assert!(lo <= l.t22_m * (1.0 + 1e-12) && l.t22_m <= hi * (1.0 + 1e-12), "{lo} {} {hi}", l.t22_m);
    }
}
