//! Designs used by several tests.

use phalanx::gripper::{Design, ProximalLength};

/// Half width w of the phalanges of the thesis (Table 3.2), m.
pub const W: f64 = 0.0025;
/// Disc radius r_c of the thesis (Table 3.2), m.
pub const R_C: f64 = 0.020;

/// Design 95, which the thesis selects (§4.3): base 15.5 mm, l21 = l21,max, φ22 = 120°, r_l = 1/2.
pub fn design_95() -> Design {
    Design::thesis(0.0155, ProximalLength::Fraction(1.0), 120f64.to_radians(), 0.5)
}

/// The 192 designs of the sweep (thesis §4.2 with the thirds of errata 15); the base varies slowest, r_l fastest. The
/// sweep simulates each design with two values of μ_s, 384 runs in all.
pub fn sweep_designs(fractions: [f64; 4]) -> Vec<Design> {
    let mut designs = Vec::with_capacity(192);
    for base_mm in [12.0, 15.5, 19.0, 22.5] {
        for fraction in fractions {
            for phi_deg in [90.0f64, 100.0, 110.0, 120.0] {
                for ratio in [1.0 / 3.0, 0.5, 2.0 / 3.0] {
                    let l21 = ProximalLength::Fraction(fraction);
                    designs.push(Design::thesis(base_mm * 1e-3, l21, phi_deg.to_radians(), ratio));
                }
            }
        }
    }
    designs
}

/// l21 fractions of the sweep (errata 15).
pub const THIRDS: [f64; 4] = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0];

#[track_caller]
pub fn assert_near(actual: f64, expected: f64, tolerance: f64) {
    assert!((actual - expected).abs() <= tolerance, "found {actual}, expected {expected} ± {tolerance:e}");
}
