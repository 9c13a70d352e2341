//! Differences between runs, measured where the answer is known.

use crate::support::synthetic::{lift_off, sample, touch_down};
use phalanx::scene::Bounds;
use phalanx::scene::words::SceneKind;
use phalanx::trace::{ContactSample, ContactSummary, FingerState, Outcome, Sample, Sink, Site};
use phalanx::validate::{IMPACT_S, Off, Recording, compare, verdicts};

const END_S: f64 = 10e-3;
/// The force that stays after an impact, and the impulse that comes with it.
const HOLD_N: f64 = 20.0;
const IMPACT_N_S: f64 = 0.1;
const TOUCH_S: f64 = 4.000_5e-3;

/// A made-up closing: angles as smooth as can be, one touch of the proximal phalanx; `shift_rad` on q11 from 5 ms on.
fn run(shift_rad: f64, touch_s: f64, impulse_n_s: f64, force_n: f64, steps: u32) -> Recording {
    let mut run = Recording::default();
    let mut last = Sample::default();
    let mut touched = false;
    for k in 0..=steps {
        let time_s = END_S * f64::from(k) / f64::from(steps);
        if !touched && time_s > touch_s {
            touched = true;
            run.event(&touch_down(touch_s, Site::Proximal, 1.0)).expect("kept");
        }
        let pressed = touched.then_some(ContactSample {
            gap_m: -1e-6,
            normal_n: force_n,
            impulse_n_s: impulse_n_s + force_n * (time_s - touch_s),
            ..ContactSample::default()
        });
        last = sample(time_s);
        last.fingers[0] = FingerState {
            q11_rad: (1e3 * time_s).sin() + if time_s >= 5e-3 { shift_rad } else { 0.0 },
            qd11_rad_s: 1e3 * (1e3 * time_s).cos(),
            q21_rad: 1.0,
            q22_rad: -2.0,
            qd21_rad_s: 0.0,
            qd22_rad_s: 0.0,
            ..last.fingers[0]
        };
        (last.contacts[0], last.contacts[1]) = (pressed.unwrap_or_default(), ContactSample::NONE);
        run.sample(&last).expect("kept");
    }
    let site = ContactSummary { first_s: Some(touch_s), touchdowns: 1, ..ContactSummary::default() };
    run.outcome = Outcome {
        last,
        contacts: vec![site, ContactSummary::default(), ContactSummary::default()],
        ..Outcome::default()
    };
    run
}

fn usual(steps: u32) -> Recording {
    run(0.0, TOUCH_S, IMPACT_N_S, HOLD_N, steps)
}

fn near(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} is not {expected}");
}

#[test]
fn a_run_does_not_differ_from_itself() {
    let run = usual(1000);
    let found = compare(&run, &run, END_S);
    assert_eq!((&found.path, &found.rate_rms_rad_s), (&vec![Off::default(); 3], &vec![0.0; 3]));
    assert_eq!(found.final_force, [Some(0.0), None], "there is nothing for the distal phalanx to press on");
    assert_eq!(found.contact_time_s, [Some(0.0), None]);
    assert_eq!(found.impulse, [Some(0.0), None]);
    assert!(verdicts(&found, &Bounds::over(SceneKind::Finger, END_S)).passed());
}

#[test]
fn coarse_samples_are_compared_with_what_lies_between_fine_ones() {
    // 300 does not divide 10,000: the coarse times lie between the fine ones.
    let found = compare(&usual(300), &usual(10_000), END_S);
    assert!(found.path_max() < 1e-13, "{}", found.path_max());
}

#[test]
fn a_shift_is_measured_where_it_is() {
    let shifted = run(3e-4, TOUCH_S, IMPACT_N_S, HOLD_N, 1000);
    let found = compare(&shifted, &usual(10_000), END_S);
    near(found.path[0].max, 3e-4, 1e-12);
    assert!(found.path[0].max_at_s >= 5e-3);
    near(found.path[0].end, 3e-4, 1e-12);
    near(found.path[0].rms, 3e-4 / 2f64.sqrt(), 3e-7);
    assert_eq!((found.path[1].max, found.path[2].max), (0.0, 0.0));
    // What comes later than the end of the comparison does not count.
    let found = compare(&shifted, &usual(10_000), 4.9e-3);
    assert!(found.path_max() < 1e-12);
}

#[test]
fn a_whole_turn_is_no_difference() {
    let mut turned = usual(1000);
    turned.samples.iter_mut().for_each(|sample| sample.finger_mut().q22_rad += std::f64::consts::TAU);
    assert!(compare(&turned, &usual(1000), END_S).path_max() < 1e-15);
}

#[test]
fn contact_is_compared_each_from_its_own_touch() {
    let late = 0.3e-6;
    let found = compare(&run(0.0, TOUCH_S + late, 1.02 * IMPACT_N_S, 1.001 * HOLD_N, 1000), &usual(10_000), END_S);
    near(found.contact_time_s[0].expect("both touch"), late, 1e-15);
    near(found.final_force[0].expect("both press"), 1e-3, 1e-9);
    let ours = IMPACT_N_S + HOLD_N * IMPACT_S;
    let theirs = 1.02 * IMPACT_N_S + 1.001 * HOLD_N * IMPACT_S;
    near(found.impulse[0].expect("both touch"), theirs / ours - 1.0, 1e-9);
}

#[test]
fn a_step_longer_than_the_impact_is_not_charged_for_it() {
    // Steps of 100 µs: the impact is inside one.
    let found = compare(&usual(100), &usual(10_000), END_S);
    assert!(found.impulse[0].expect("both touch") < 1e-9, "{:?}", found.impulse);
}

#[test]
fn a_touch_that_one_lacks_is_infinitely_far_off() {
    let mut never = usual(1000);
    never.outcome.contacts[0] = ContactSummary::default();
    never.impacts = Default::default();
    let found = compare(&never, &usual(1000), END_S);
    assert_eq!(found.contact_time_s[0], Some(f64::INFINITY));
    assert_eq!(found.impulse[0], Some(f64::INFINITY));
    assert!(!verdicts(&found, &Bounds::over(SceneKind::Finger, END_S)).passed());
    // Before both touch there is nothing to compare.
    let found = compare(&never, &usual(1000), 2e-3);
    assert_eq!((found.contact_time_s[0], found.impulse[0]), (None, None));
}

#[test]
fn figures_that_are_no_numbers_break_their_bound() {
    let mut broken = usual(1000);
    broken.samples[500].finger_mut().q21_rad = f64::NAN;
    broken.outcome.last.contact_mut(Site::Proximal).normal_n = f64::NAN;
    let found = compare(&broken, &usual(1000), END_S);
    assert_eq!((found.path_max(), found.final_force[0]), (f64::INFINITY, Some(f64::INFINITY)));
    assert!(!verdicts(&found, &Bounds::over(SceneKind::Finger, END_S)).passed());
}

#[test]
fn small_rebounds_are_not_judged() {
    let mut bouncing = usual(1000);
    let later = 8e-3;
    let lift_s = later - 1e-4;
    let given = IMPACT_N_S + HOLD_N * (lift_s - TOUCH_S);
    bouncing.event(&lift_off(lift_s, Site::Proximal, given)).expect("kept");
    let mut theirs = bouncing.clone();
    // Their second impulse is another, but a thousandth of the first.
    for (run, rebound) in [(&mut bouncing, 1e-6), (&mut theirs, 2e-6)] {
        run.event(&touch_down(later, Site::Proximal, 1e-3)).expect("kept");
        let at = |time_s: f64, impulse_n_s: f64| Sample {
            time_s,
            contacts: vec![ContactSample { impulse_n_s, ..ContactSample::default() }],
            ..Sample::default()
        };
        let before = run.outcome.last.contact(Site::Proximal).impulse_n_s;
        run.impacts.sample(&at(later + 1e-6, before + rebound)).expect("kept");
        run.impacts.sample(&at(later + 1e-4, before + rebound)).expect("kept");
    }
    let found = compare(&theirs, &bouncing, END_S);
    assert_eq!(found.impulse[0], Some(0.0));
}
