//! Measured differences between synthetic runs whose differences are known.

use crate::support::synthetic::{lift_off, sample, touch_down};
use phalanx::scene::Bounds;
use phalanx::scene::keywords::SceneKind;
use phalanx::trace::{ContactSample, ContactSummary, FingerContact, FingerState, Outcome, Sample, Sink};
use phalanx::validate::{CoordinateError, IMPACT_S, Recording, check_bounds, compare};

const END_S: f64 = 10e-3;
/// Force that remains after the impact.
const HOLD_N: f64 = 20.0;
/// Impulse of the impact.
const IMPACT_N_S: f64 = 0.1;
const TOUCH_S: f64 = 4.000_5e-3;

/// Returns a synthetic closing with smooth angles and one contact of the proximal phalanx. `shift_rad` is added to q11
/// from 5 ms on.
fn run(shift_rad: f64, touch_s: f64, impulse_n_s: f64, force_n: f64, steps: u32) -> Recording {
    let mut run = Recording::default();
    let mut last = Sample::default();
    let mut touched = false;
    for k in 0..=steps {
        let time_s = END_S * f64::from(k) / f64::from(steps);
        if !touched && time_s > touch_s {
            touched = true;
            run.event(&touch_down(touch_s, FingerContact::Proximal, 1.0)).expect("never fails");
        }
        let contact = touched.then_some(ContactSample {
            gap_m: -1e-6,
            normal_n: force_n,
            impulse_n_s: impulse_n_s + force_n * (time_s - touch_s),
            ..ContactSample::default()
        });
        last = sample(time_s);
        last.finger(0) = FingerState {
            q11_rad: (1e3 * time_s).sin() + if time_s >= 5e-3 { shift_rad } else { 0.0 },
            qd11_rad_s: 1e3 * (1e3 * time_s).cos(),
            q21_rad: 1.0,
            q22_rad: -2.0,
            qd21_rad_s: 0.0,
            qd22_rad_s: 0.0,
            ..last.finger(0)
        };
        (last.contact(0), last.contact(1)) = (contact.unwrap_or_default(), ContactSample::NONE);
        run.sample(&last).expect("never fails");
    }
    let proximal = ContactSummary { first_s: Some(touch_s), touchdowns: 1, ..ContactSummary::default() };
    run.outcome = Outcome {
        last,
        contacts: vec![proximal, ContactSummary::default(), ContactSummary::default()],
        ..Outcome::default()
    };
    run
}

fn base_run(steps: u32) -> Recording {
    run(0.0, TOUCH_S, IMPACT_N_S, HOLD_N, steps)
}

fn assert_near(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} is not {expected}");
}

#[test]
fn a_run_does_not_differ_from_itself() {
    let run = base_run(1000);
    let comparison = compare(&run, &run, END_S);
    assert_eq!((&comparison.path, &comparison.rate_rms_rad_s), (&vec![CoordinateError::default(); 3], &vec![0.0; 3]));
    assert_eq!(comparison.final_force, [Some(0.0), None], "the distal phalanx has no contact");
    assert_eq!(comparison.contact_time_s, [Some(0.0), None]);
    assert_eq!(comparison.impulse, [Some(0.0), None]);
    assert!(check_bounds(&comparison, &Bounds::defaults_for_run(SceneKind::Finger, END_S)).passed());
}

#[test]
fn coarse_samples_are_compared_with_interpolated_fine_samples() {
    // 300 does not divide 10,000: the coarse times lie between the fine ones.
    let comparison = compare(&base_run(300), &base_run(10_000), END_S);
    assert!(comparison.path_max() < 1e-13, "{}", comparison.path_max());
}

#[test]
fn an_angle_shift_is_measured_with_its_time() {
    let shifted = run(3e-4, TOUCH_S, IMPACT_N_S, HOLD_N, 1000);
    let comparison = compare(&shifted, &base_run(10_000), END_S);
    assert_near(comparison.path[0].max, 3e-4, 1e-12);
    assert!(comparison.path[0].max_at_s >= 5e-3);
    assert_near(comparison.path[0].end, 3e-4, 1e-12);
    assert_near(comparison.path[0].rms, 3e-4 / 2f64.sqrt(), 3e-7);
    assert_eq!((comparison.path[1].max, comparison.path[2].max), (0.0, 0.0));
    // Differences after the end of the comparison do not count.
    let comparison = compare(&shifted, &base_run(10_000), 4.9e-3);
    assert!(comparison.path_max() < 1e-12);
}

#[test]
fn a_whole_turn_is_no_difference() {
    let mut rotated = base_run(1000);
    rotated.samples.iter_mut().for_each(|sample| sample.finger_mut().q22_rad += std::f64::consts::TAU);
    assert!(compare(&rotated, &base_run(1000), END_S).path_max() < 1e-15);
}

#[test]
fn contacts_are_compared_from_their_own_touch_down() {
    let delay_s = 0.3e-6;
    let comparison =
        compare(&run(0.0, TOUCH_S + delay_s, 1.02 * IMPACT_N_S, 1.001 * HOLD_N, 1000), &base_run(10_000), END_S);
    assert_near(comparison.contact_time_s[0].expect("both touch"), delay_s, 1e-15);
    assert_near(comparison.final_force[0].expect("both have a final force"), 1e-3, 1e-9);
    let base_impulse = IMPACT_N_S + HOLD_N * IMPACT_S;
    let late_impulse = 1.02 * IMPACT_N_S + 1.001 * HOLD_N * IMPACT_S;
    assert_near(comparison.impulse[0].expect("both touch"), late_impulse / base_impulse - 1.0, 1e-9);
}

#[test]
fn a_step_longer_than_the_impact_causes_no_impulse_difference() {
    // Steps of 100 µs: the impact is inside one.
    let comparison = compare(&base_run(100), &base_run(10_000), END_S);
    assert!(comparison.impulse[0].expect("both touch") < 1e-9, "{:?}", comparison.impulse);
}

#[test]
fn a_missing_touch_down_gives_infinite_differences() {
    let mut without_touchdown = base_run(1000);
    without_touchdown.outcome.contacts[0] = ContactSummary::default();
    without_touchdown.impacts = Default::default();
    let comparison = compare(&without_touchdown, &base_run(1000), END_S);
    assert_eq!(comparison.contact_time_s[0], Some(f64::INFINITY));
    assert_eq!(comparison.impulse[0], Some(f64::INFINITY));
    assert!(!check_bounds(&comparison, &Bounds::defaults_for_run(SceneKind::Finger, END_S)).passed());
    // There is nothing to compare before the touch-down.
    let comparison = compare(&without_touchdown, &base_run(1000), 2e-3);
    assert_eq!((comparison.contact_time_s[0], comparison.impulse[0]), (None, None));
}

#[test]
fn nan_values_violate_their_bounds() {
    let mut with_nan = base_run(1000);
    with_nan.samples[500].finger_mut().q21_rad = f64::NAN;
    with_nan.outcome.last.contact_mut(FingerContact::Proximal).normal_n = f64::NAN;
    let comparison = compare(&with_nan, &base_run(1000), END_S);
    assert_eq!((comparison.path_max(), comparison.final_force[0]), (f64::INFINITY, Some(f64::INFINITY)));
    assert!(!check_bounds(&comparison, &Bounds::defaults_for_run(SceneKind::Finger, END_S)).passed());
}

#[test]
fn impulses_of_small_rebounds_are_not_compared() {
    let mut bouncing = base_run(1000);
    let rebound_s = 8e-3;
    let lift_s = rebound_s - 1e-4;
    let impulse_at_lift_off_n_s = IMPACT_N_S + HOLD_N * (lift_s - TOUCH_S);
    bouncing.event(&lift_off(lift_s, FingerContact::Proximal, impulse_at_lift_off_n_s)).expect("never fails");
    let mut with_larger_rebound = bouncing.clone();
    // The second impulses differ, but by a small fraction of the first.
    for (run, rebound) in [(&mut bouncing, 1e-6), (&mut with_larger_rebound, 2e-6)] {
        run.event(&touch_down(rebound_s, FingerContact::Proximal, 1e-3)).expect("never fails");
        let sample_at = |time_s: f64, impulse_n_s: f64| Sample {
            time_s,
            contacts: vec![ContactSample { impulse_n_s, ..ContactSample::default() }],
            ..Sample::default()
        };
        let before = run.outcome.last.finger_contact(FingerContact::Proximal).impulse_n_s;
        run.impacts.sample(&sample_at(rebound_s + 1e-6, before + rebound)).expect("never fails");
        run.impacts.sample(&sample_at(rebound_s + 1e-4, before + rebound)).expect("never fails");
    }
    let comparison = compare(&with_larger_rebound, &bouncing, END_S);
    assert_eq!(comparison.impulse[0], Some(0.0));
}
