//! Actuators with gears, motors and feedback, and limits of sums: reference solutions, and closed forms.

use phalanx::integrator::{Method, SwitchedMethod, Tolerances};

use super::mechanism::{compare, first_touches};
use crate::support::mechanism_cases::drive_cases;

#[test]
fn drives_meet_the_reference_solutions() {
    let tolerances = Tolerances { atol_q: 1e-14, atol_v: 1e-9, rtol_v: 1e-11 };
    for case in drive_cases() {
        let found = compare(&case, Method::new, tolerances);
        let name = &case.name;
        assert!(found.position_m < 1e-8 && found.angle_rad < 1e-7, "{name}: {found:?}");
        for touch in first_touches(&case) {
            let nearest = found.touches_s.iter().map(|time| (time - touch).abs()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-9, "{name}: touch at {touch} s missed by {nearest:e} s");
        }
        println!("{name}: {found:?}");
        assert!(found.energy_j < 1e-9 && found.loss_j < 1e-9, "{name}: {found:?}");
        assert!(found.effort < 1e-5 && found.drives.iter().all(|difference| *difference < 1e-6), "{name}: {found:?}");
    }
}

#[test]
fn drives_are_accurate_to_1e_5_at_everyday_tolerances() {
    let tolerances = Tolerances { atol_q: 3e-11, atol_v: 3e-7, rtol_v: 3e-7 };
    for case in drive_cases() {
        let found = compare(&case, SwitchedMethod::rodas, tolerances);
        assert!(found.position_m < 1e-6 && found.angle_rad < 1e-5, "{}: {found:?}", case.name);
    }
}
