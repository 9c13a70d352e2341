//! The anchor: design 95 of the thesis closing on its object.
//!
//! The reference figures come from an independent integration to high accuracy, in another language and another
//! formulation of the same equations. They are printed to 1 ns, 1e-6 degrees and 1e-4 N, so nothing can be asked of them
//! beyond half of their last digit.

use crate::support::runs::{Collect, anchor, assert_near, complete, engineering, reference};
use phalanx::scene::{Integrator, Method};
use phalanx::trace::{Outcome, Site};

const FIRST_CONTACT_S: f64 = 4.501315e-3;
const SECOND_CONTACT_S: f64 = 6.883746e-3;
const Q11_DEG: f64 = 2.088778;
const Q21_DEG: f64 = 65.019991;
const PROXIMAL_N: f64 = 23.6092;
const DISTAL_N: f64 = 8.2573;

/// Half of the last printed digit of a time in ms, an angle in degrees, a force in N.
const HALF_DIGIT_S: f64 = 0.5e-9;
const HALF_DIGIT_DEG: f64 = 0.5e-6;
const HALF_DIGIT_N: f64 = 0.5e-4;

fn anchor_with(settings: Integrator) -> (Outcome, Collect) {
    let mut scene = anchor();
    scene.integrator = settings;
    complete(&scene)
}

/// Tolerances of times in s, angles in rad, forces relative, and whether half a printed digit is granted on top.
fn assert_is_the_anchor(settings: Integrator, time: f64, angle: f64, force: f64, digits: f64) {
    let (outcome, log) = anchor_with(settings);
    let contact = |site| log.first_touch(site as usize).expect("contact");
    let time = time + digits * HALF_DIGIT_S;
    assert_near(contact(Site::Proximal), FIRST_CONTACT_S, time, "first contact");
    assert_near(contact(Site::Distal), SECOND_CONTACT_S, time, "second contact");
    let last = outcome.last;
    assert_eq!(last.time_s, 20e-3);
    let angle = angle + digits * HALF_DIGIT_DEG.to_radians();
    assert_near(last.finger().q11_rad, Q11_DEG.to_radians(), angle, "q11");
    assert_near(last.finger().q21_rad, Q21_DEG.to_radians(), angle, "q21");
    let force = |f: f64| force * f + digits * HALF_DIGIT_N;
    assert_near(last.contact(Site::Proximal).normal_n, PROXIMAL_N, force(PROXIMAL_N), "proximal force");
    assert_near(last.contact(Site::Distal).normal_n, DISTAL_N, force(DISTAL_N), "distal force");
}

#[test]
fn engineering_settings_give_the_anchor_to_a_microsecond_and_a_thousandth_of_its_forces() {
    assert_is_the_anchor(engineering(), 1e-6, 1e-5, 1e-3, 0.0);
}

#[test]
fn reference_settings_give_the_anchor_to_its_printed_digits() {
    assert_is_the_anchor(reference(), 1e-9, 1e-8, 1e-5, 1.0);
}

/// Tighter than the reference settings: two methods are compared to the last digits here.
fn tight(method: Method) -> Integrator {
    Integrator { method, rtol: 1e-12, atol_angle_rad: 1e-14, atol_rate_rad_s: 1e-10, ..reference() }
}

#[test]
fn both_methods_agree_along_the_whole_trajectory() {
    let grid_s = 0.25e-3;
    let runs = [Method::Rodas5p, Method::RadauIIa5].map(|method| {
        let mut scene = anchor();
        scene.integrator = tight(method);
        scene.log.numeric_hz = 1.0 / grid_s;
        complete(&scene)
    });
    let [(rodas, rodas_log), (radau, radau_log)] = &runs;
    for i in 0..=80 {
        let t = f64::from(i) * grid_s;
        let (a, b) = (rodas_log.at(t), radau_log.at(t));
        assert!((a.time_s - t).abs() < 1e-15 && (b.time_s - t).abs() < 1e-15, "no sample at {t}");
        assert_near(a.finger().q11_rad, b.finger().q11_rad, 1e-9, &format!("q11 at {t}"));
        assert_near(a.finger().q21_rad, b.finger().q21_rad, 1e-9, &format!("q21 at {t}"));
    }
    for (a, b) in rodas.contacts.iter().zip(&radau.contacts) {
        assert_near(a.impulse_n_s, b.impulse_n_s, 1e-7 * b.impulse_n_s.abs(), "impulse");
        assert_near(a.first_s.unwrap_or(0.0), b.first_s.unwrap_or(0.0), 1e-12, "contact time");
    }
}

#[test]
fn the_same_scene_gives_the_same_bits() {
    for settings in [engineering(), reference()] {
        let (first, first_log) = anchor_with(settings);
        let (again, again_log) = anchor_with(settings);
        assert_eq!(first, again);
        let bits = |log: &Collect| -> Vec<[u64; 5]> {
            let key = |s: &phalanx::trace::Sample| {
                [
                    s.time_s,
                    s.finger().q11_rad,
                    s.finger().qd21_rad_s,
                    s.contact(Site::Proximal).normal_n,
                    s.energy.balance_j,
                ]
                .map(f64::to_bits)
            };
            log.samples.iter().map(key).collect()
        };
        assert_eq!(bits(&first_log), bits(&again_log));
        assert_eq!(first_log, again_log);
    }
}
