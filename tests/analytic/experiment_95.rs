//! Experiment 95: design 95 of the thesis closing on its object.
//!
//! The reference values come from an independent integration of high accuracy, in another language and another
//! formulation of the same equations. They are printed to 1 ns, 1e-6 degrees and 1e-4 N, so they are exact only to half
//! of their last digit.

use crate::support::runs::{
    CollectSink, assert_near, engineering_settings, experiment_95, reference_settings, run_to_end,
};
use phalanx::scene::{Integrator, Method};
use phalanx::trace::{FingerContact, Outcome};

const FIRST_CONTACT_S: f64 = 4.501315e-3;
const SECOND_CONTACT_S: f64 = 6.883746e-3;
const Q11_DEG: f64 = 2.088778;
const Q21_DEG: f64 = 65.019991;
const PROXIMAL_N: f64 = 23.6092;
const DISTAL_N: f64 = 8.2573;

// Half of the last printed digit of times, angles and forces.
const HALF_LAST_DIGIT_S: f64 = 0.5e-9;
const HALF_LAST_DIGIT_DEG: f64 = 0.5e-6;
const HALF_LAST_DIGIT_N: f64 = 0.5e-4;

fn run_with_settings(settings: Integrator) -> (Outcome, CollectSink) {
    let mut scene = experiment_95();
    scene.integrator = settings;
    run_to_end(&scene)
}

/// Compares a run with the reference values. The tolerances are absolute for times (s) and angles (rad) and relative
/// for forces; `digits` times half of the last printed digit is added to each.
fn assert_reference_values(settings: Integrator, time: f64, angle: f64, force: f64, digits: f64) {
    let (outcome, log) = run_with_settings(settings);
    let contact = |phalanx| log.first_contact_s(phalanx as usize).expect("a first contact");
    let time = time + digits * HALF_LAST_DIGIT_S;
    assert_near(contact(FingerContact::Proximal), FIRST_CONTACT_S, time, "first contact");
    assert_near(contact(FingerContact::Distal), SECOND_CONTACT_S, time, "second contact");
    let last = outcome.last;
    assert_eq!(last.time_s, 20e-3);
    let angle = angle + digits * HALF_LAST_DIGIT_DEG.to_radians();
    assert_near(last.finger(0).q11_rad, Q11_DEG.to_radians(), angle, "q11");
    assert_near(last.finger(0).q21_rad, Q21_DEG.to_radians(), angle, "q21");
    let force = |f: f64| force * f + digits * HALF_LAST_DIGIT_N;
    assert_near(last.finger_contact(FingerContact::Proximal).normal_n, PROXIMAL_N, force(PROXIMAL_N), "proximal force");
    assert_near(last.finger_contact(FingerContact::Distal).normal_n, DISTAL_N, force(DISTAL_N), "distal force");
}

#[test]
fn engineering_settings_match_times_to_a_microsecond_and_forces_to_a_thousandth() {
    assert_reference_values(engineering_settings(), 1e-6, 1e-5, 1e-3, 0.0);
}

#[test]
fn reference_settings_match_all_printed_digits() {
    assert_reference_values(reference_settings(), 1e-9, 1e-8, 1e-5, 1.0);
}

/// Tighter than the reference settings, for a comparison of the two methods to their last digits.
fn tight_settings(method: Method) -> Integrator {
    Integrator { method, rtol: 1e-12, atol_angle_rad: 1e-14, atol_rate_rad_s: 1e-10, ..reference_settings() }
}

#[test]
fn both_methods_agree_along_the_trajectory() {
    let grid_s = 0.25e-3;
    let runs = [Method::Rodas5p, Method::RadauIIa5].map(|method| {
        let mut scene = experiment_95();
        scene.integrator = tight_settings(method);
        scene.log.numeric_hz = 1.0 / grid_s;
        run_to_end(&scene)
    });
    let [(rodas, rodas_log), (radau, radau_log)] = &runs;
    for i in 0..=80 {
        let t = f64::from(i) * grid_s;
        let (a, b) = (rodas_log.nearest_sample(t), radau_log.nearest_sample(t));
        assert!((a.time_s - t).abs() < 1e-15 && (b.time_s - t).abs() < 1e-15, "no sample at {t}");
        assert_near(a.finger(0).q11_rad, b.finger(0).q11_rad, 1e-9, &format!("q11 at {t}"));
        assert_near(a.finger(0).q21_rad, b.finger(0).q21_rad, 1e-9, &format!("q21 at {t}"));
    }
    for (a, b) in rodas.contacts.iter().zip(&radau.contacts) {
        assert_near(a.impulse_n_s, b.impulse_n_s, 1e-7 * b.impulse_n_s.abs(), "impulse");
        assert_near(a.first_s.unwrap_or(0.0), b.first_s.unwrap_or(0.0), 1e-12, "contact time");
    }
}

#[test]
fn runs_are_deterministic() {
    for settings in [engineering_settings(), reference_settings()] {
        let (first, first_log) = run_with_settings(settings);
        let (second, second_log) = run_with_settings(settings);
        assert_eq!(first, second);
        let bit_patterns = |log: &CollectSink| -> Vec<[u64; 5]> {
            let key = |s: &phalanx::trace::Sample| {
                [
                    s.time_s,
                    s.finger(0).q11_rad,
                    s.finger(0).qd21_rad_s,
                    s.finger_contact(FingerContact::Proximal).normal_n,
                    s.energy().balance_j,
                ]
                .map(f64::to_bits)
            };
            log.samples.iter().map(key).collect()
        };
        assert_eq!(bit_patterns(&first_log), bit_patterns(&second_log));
        assert_eq!(first_log, second_log);
    }
}
