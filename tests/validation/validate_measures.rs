//! Measured differences between synthetic runs whose differences are known.

use crate::support::designs::assert_near;
use crate::support::synthetic::{lift_off, sample, touch_down};
use phalanx::scene::Bounds;
use phalanx::scene::keywords::SceneKind;
use phalanx::trace::{ContactSample, ContactSummary, FingerContact, FingerState, Sample, Sink};
use phalanx::validate::{CoordinateError, Differences, IMPACT_S, Recording, check_bounds, compare};

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
    for k in 0..=steps {
        let time_s = END_S * f64::from(k) / f64::from(steps);
        let touched = time_s > touch_s;
        if touched && run.events.is_empty() {
            run.event(&touch_down(touch_s, FingerContact::Proximal, 1.0)).expect("never fails");
        }
        let contact = ContactSample {
            gap_m: -1e-6,
            normal_n: force_n,
            impulse_n_s: impulse_n_s + force_n * (time_s - touch_s),
            ..ContactSample::default()
        };
        let mut sample = sample(time_s);
        let finger = FingerState {
            q11_rad: (1e3 * time_s).sin() + if time_s >= 5e-3 { shift_rad } else { 0.0 },
            qd11_rad_s: 1e3 * (1e3 * time_s).cos(),
            q21_rad: 1.0,
            q22_rad: -2.0,
            qd21_rad_s: 0.0,
            qd22_rad_s: 0.0,
            ..sample.finger(0)
        };
        sample.set_finger(0, &finger);
        sample.set_contact(0, &if touched { contact } else { ContactSample::default() });
        sample.set_contact(1, &ContactSample::NONE);
        run.sample(&sample).expect("never fails");
    }
    run.outcome.last = run.samples.last().expect("samples").clone();
    run.outcome.contacts = vec![ContactSummary::default(); 3];
    run.outcome.contacts[0] = ContactSummary { first_s: Some(touch_s), touchdowns: 1, ..ContactSummary::default() };
    run
}

fn base_run(steps: u32) -> Recording {
    run(0.0, TOUCH_S, IMPACT_N_S, HOLD_N, steps)
}

fn is_within_default_bounds(comparison: &Differences) -> bool {
    check_bounds(comparison, &Bounds::defaults_for_run(SceneKind::Finger, END_S)).passed()
}

#[test]
fn a_run_does_not_differ_from_itself() {
    let run = base_run(1000);
    let comparison = compare(&run, &run, END_S);
    assert_eq!((&comparison.path, &comparison.rate_rms_rad_s), (&vec![CoordinateError::default(); 3], &vec![0.0; 3]));
    // The distal phalanx has no contact.
    let Differences { final_force, contact_time_s, impulse, .. } = &comparison;
    for differences in [contact_time_s, impulse] {
        assert_eq!(differences[..], [Some(0.0), None]);
    }
    assert_eq!(final_force[..], [Some(0.0); 2]);
    assert!(is_within_default_bounds(&comparison));
    // A whole turn is a difference.
    let mut rotated = base_run(1000);
    for sample in &mut rotated.samples {
        let finger = sample.finger(0);
        sample.set_finger(0, &FingerState { q22_rad: finger.q22_rad + std::f64::consts::TAU, ..finger });
    }
    assert_near(compare(&rotated, &run, END_S).path_max(), std::f64::consts::TAU, 1e-15);
}

#[test]
fn coarse_samples_are_compared_with_interpolated_fine_samples() {
    // 300 does not divide 10,000: the coarse times lie between the fine ones.
    let comparison = compare(&base_run(300), &base_run(10_000), END_S);
    assert!(comparison.path_max() < 1e-13, "{}", comparison.path_max());
    // Steps of 100 µs: the impact is inside one, which causes no difference of the impulse.
    let comparison = compare(&base_run(100), &base_run(10_000), END_S);
    assert!(comparison.impulse[0].expect("both touch") < 1e-9, "{:?}", comparison.impulse);
}

#[test]
fn an_angle_shift_is_measured_with_its_time() {
    let (shifted, base) = (run(3e-4, TOUCH_S, IMPACT_N_S, HOLD_N, 1000), base_run(10_000));
    let [shift, q21, q22] = compare(&shifted, &base, END_S).path[..] else { panic!("three angles") };
    assert_near(shift.max, 3e-4, 1e-12);
    assert_near(shift.end, 3e-4, 1e-12);
    assert_near(shift.rms, 3e-4 / 2f64.sqrt(), 3e-7);
    assert!(shift.max_at_s >= 5e-3 && q21.max == 0.0 && q22.max == 0.0);
    // Differences after the end of the comparison do not count.
    assert!(compare(&shifted, &base, 4.9e-3).path_max() < 1e-12);
}

#[test]
fn contacts_are_compared_from_their_own_touch_down() {
    let delay_s = 0.3e-6;
    let late = run(0.0, TOUCH_S + delay_s, 1.02 * IMPACT_N_S, 1.001 * HOLD_N, 1000);
    let comparison = compare(&late, &base_run(10_000), END_S);
    assert_near(comparison.contact_time_s[0].expect("both touch"), delay_s, 1e-15);
    assert_near(comparison.final_force[0].expect("both have a final force"), 1e-3, 1e-9);
    let base_impulse = IMPACT_N_S + HOLD_N * IMPACT_S;
    let late_impulse = 1.02 * IMPACT_N_S + 1.001 * HOLD_N * IMPACT_S;
    assert_near(comparison.impulse[0].expect("both touch"), late_impulse / base_impulse - 1.0, 1e-9);
}

#[test]
fn missing_touch_downs_and_nan_violate_their_bounds() {
    let mut without_touchdown = base_run(1000);
    without_touchdown.outcome.contacts[0] = ContactSummary::default();
    without_touchdown.impacts = Default::default();
    let infinite = Some(f64::INFINITY);
    let comparison = compare(&without_touchdown, &base_run(1000), END_S);
    assert_eq!((comparison.contact_time_s[0], comparison.impulse[0]), (infinite, infinite));
    assert!(!is_within_default_bounds(&comparison));
    // There is nothing to compare before the touch-down.
    let comparison = compare(&without_touchdown, &base_run(1000), 2e-3);
    assert_eq!((comparison.contact_time_s[0], comparison.impulse[0]), (None, None));

    let mut with_nan = base_run(1000);
    let finger = with_nan.samples[500].finger(0);
    with_nan.samples[500].set_finger(0, &FingerState { q21_rad: f64::NAN, ..finger });
    let contact = with_nan.outcome.last.finger_contact(FingerContact::Proximal);
    let index = FingerContact::Proximal as usize;
    with_nan.outcome.last.set_contact(index, &ContactSample { normal_n: f64::NAN, ..contact });
    let comparison = compare(&with_nan, &base_run(1000), END_S);
    assert_eq!((Some(comparison.path_max()), comparison.final_force[0]), (infinite, infinite));
    assert!(!is_within_default_bounds(&comparison));
}

#[test]
fn impulses_of_small_rebounds_are_not_compared() {
    let mut bouncing = base_run(1000);
    let rebound_s = 8e-3;
    let lift_s = rebound_s - 1e-4;
    let impulse_at_lift_off_n_s = IMPACT_N_S + HOLD_N * (lift_s - TOUCH_S);
    bouncing.event(&lift_off(lift_s, FingerContact::Proximal, impulse_at_lift_off_n_s)).expect("never fails");
    // The second impulses differ, but by a small fraction of the first.
    let with_rebound = |rebound_n_s: f64| {
        let mut run = bouncing.clone();
        run.event(&touch_down(rebound_s, FingerContact::Proximal, 1e-3)).expect("never fails");
        let impulse_n_s = run.outcome.last.finger_contact(FingerContact::Proximal).impulse_n_s + rebound_n_s;
        for time_s in [rebound_s + 1e-6, rebound_s + 1e-4] {
            let contacts = vec![ContactSample { impulse_n_s, ..ContactSample::default() }];
            run.impacts.sample(&Sample::of(time_s, &[], &[], &contacts)).expect("never fails");
        }
        run
    };
    let comparison = compare(&with_rebound(2e-6), &with_rebound(1e-6), END_S);
    assert_eq!(comparison.impulse[0], Some(0.0));
}
