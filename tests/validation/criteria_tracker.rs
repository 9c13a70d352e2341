//! The dynamic criteria of synthetic closings whose results are known in closed form.

use crate::support::synthetic::{lift_off, posture, reload, touch_down};
use phalanx::criteria::{Class, Criteria, EPSILON_RAD, FinalAngles, Tracker};
use phalanx::trace::{Event, FingerContact, Sink};

const TARGET: FinalAngles = FinalAngles { q11_rad: 0.036, q21_rad: 1.134 };
const END_S: f64 = 20e-3;

/// A synthetic closing. q21 is at its final value.
struct Closing {
    /// q11 relative to its final value, and its rate, rad and rad/s.
    angle: fn(f64) -> (f64, f64),
    /// Normal forces of the proximal phalanx and the tip.
    forces_n: fn(f64) -> [f64; 2],
    events: Vec<Event>,
    /// Additional sample times, at jumps of the rate.
    times_s: Vec<f64>,
}

impl Closing {
    /// Returns the criteria for samples every `interval_s`.
    fn compute_criteria(&self, interval_s: f64) -> Criteria {
        let steps = (END_S / interval_s).round() as usize;
        let mut times: Vec<f64> = (0..=steps).map(|i| END_S * i as f64 / steps as f64).collect();
        times.extend(&self.times_s);
        times.sort_by(f64::total_cmp);
        times.dedup();
        let mut tracker = Tracker::new(TARGET);
        let mut events = self.events.iter().peekable();
        for time in times {
            while let Some(event) = events.next_if(|event| event.time_s <= time) {
                tracker.event(event).expect("never fails");
            }
            let (angle, rate) = (self.angle)(time);
            let sample = posture(time, (TARGET.q11_rad + angle, rate), (TARGET.q21_rad, 0.0), (self.forces_n)(time));
            tracker.sample(&sample).expect("never fails");
        }
        tracker.criteria(None).expect("a run")
    }
}

#[track_caller]
fn assert_near(value: Option<f64>, expected: f64, tolerance: f64) {
    let value = value.expect("a value");
    assert!((value - expected).abs() <= tolerance, "{value} is not {expected}");
}

/// A finger that arrives at 5 ms at 20 rad/s and stays. The proximal phalanx touches the object from 3 ms on.
fn arrival() -> Closing {
    Closing {
        angle: |t| {
            if t <= 5e-3 { (20.0 * (t - 5e-3), 20.0) } else { (0.0, 0.0) }
        },
        forces_n: |t| [if t > 3e-3 { 20.0 } else { 0.0 }, if t > 5e-3 { 8.0 } else { 0.0 }],
        events: vec![touch_down(3e-3, FingerContact::Proximal, 1.0), touch_down(5e-3, FingerContact::Distal, 1.0)],
        times_s: vec![3e-3 + 1e-9, 5e-3 + 1e-9],
    }
}

#[test]
fn a_finger_that_arrives_and_stays_does_not_rebound() {
    for interval in [1e-3, 1e-4, 1e-5] {
        let criteria = arrival().compute_criteria(interval);
        assert_near(criteria.t_geo_s, 5e-3 - EPSILON_RAD / 20.0, 1e-9);
        assert_near(criteria.tts_s, 5e-3, 2e-9);
        // The 0.17 ms through the ε band are part of the approach, not of a rebound.
        assert_eq!(criteria.rebound_percent, Some(0.0));
        assert_eq!(criteria.class, Class::Stable);
    }
}

#[test]
fn a_statically_unstable_grasp_is_unstable_for_any_dynamics() {
    let mut tracker = Tracker::new(TARGET);
    for i in 0..=20 {
        let time = 1e-3 * f64::from(i);
        let sample = posture(time, (TARGET.q11_rad, 0.0), (TARGET.q21_rad, 0.0), [20.0, 8.0]);
        tracker.sample(&sample).expect("never fails");
    }
    let criteria = tracker.criteria(Some([3.0, 0.0])).expect("a run");
    assert_eq!(criteria.t_geo_s, Some(0.0));
    assert_eq!(criteria.tts_s, Some(0.0));
    assert_eq!(criteria.rebound_percent, Some(0.0));
    assert_eq!(criteria.class, Class::Stable);
    let unstable = tracker.criteria(Some([-1.2, 3.0])).expect("a run");
    assert_eq!((unstable.class, unstable.statically_stable), (Class::Unstable, false));
    assert_eq!(
        unstable.verdict(),
        "unstable: the static force on the proximal phalanx is -1.2 N; it must not be negative"
    );
}

#[test]
fn a_finger_that_never_reaches_its_position_has_no_times() {
    let mut closing = arrival();
    closing.angle = |_| (-0.1, 0.0);
    let criteria = closing.compute_criteria(1e-4);
    assert_eq!((criteria.t_geo_s, criteria.tts_s, criteria.rebound_percent), (None, None, None));
    assert_eq!(criteria.class, Class::Unstable);
}

#[test]
fn a_finger_with_one_contact_is_unstable() {
    let mut closing = arrival();
    closing.forces_n = |t| [if t > 3e-3 { 20.0 } else { 0.0 }, 0.0];
    closing.events.pop();
    let criteria = closing.compute_criteria(1e-4);
    assert!(criteria.t_geo_s.is_some());
    assert_eq!((criteria.tts_s, criteria.rebound_percent), (None, None));
    assert_eq!(criteria.class, Class::Unstable);
}

/// A finger that arrives at 5 ms, rebounds on a parabola of 2 ms that leaves the band, and stays from 7 ms on.
fn bounce() -> Closing {
    Closing {
        angle: |t| {
            if t <= 5e-3 {
                (20.0 * (t - 5e-3), 20.0)
            } else if t <= 7e-3 {
                (1e4 * (t - 5e-3) * (t - 7e-3), 1e4 * (2.0 * t - 12e-3))
            } else {
                (0.0, 0.0)
            }
        },
        forces_n: |t| [20.0, if t > 7e-3 { 8.0 } else { 0.0 }],
        events: vec![
            touch_down(5e-3, FingerContact::Distal, 1.0),
            lift_off(5e-3 + 5e-10, FingerContact::Distal, 1e-3),
            touch_down(7e-3, FingerContact::Distal, 0.5),
        ],
        times_s: vec![5e-3 + 1e-9, 7e-3 + 1e-9],
    }
}

#[test]
fn a_bounce_is_a_rebound_until_the_second_touch_down() {
    for interval in [1e-3, 1e-4, 1e-5] {
        let criteria = bounce().compute_criteria(interval);
        let t_geo = 5e-3 - EPSILON_RAD / 20.0;
        assert_near(criteria.t_geo_s, t_geo, 1e-9);
        assert_near(criteria.tts_s, 7e-3, 2e-9);
        assert!((criteria.lost_s - 2e-3).abs() < 5e-9, "{}", criteria.lost_s);
        let (geo, tts) = (criteria.t_geo_s.expect("some"), criteria.tts_s.expect("some"));
        assert_near(criteria.rebound_percent, 100.0 * ((geo + END_S) / (tts + END_S) - 1.0).abs(), 1e-12);
        assert_eq!(criteria.class, Class::SemiUnstable);
    }
}

#[test]
fn leaving_the_band_with_both_contacts_closed_also_delays_stability() {
    // q11 deviates between 8 and 10 ms, and is out of the band while 1e4 x (2 ms − x) > ε.
    let mut closing = arrival();
    closing.angle = |t| {
        if t <= 5e-3 {
            (20.0 * (t - 5e-3), 20.0)
        } else if (8e-3..=10e-3).contains(&t) {
            (1e4 * (t - 8e-3) * (10e-3 - t), 1e4 * (18e-3 - 2.0 * t))
        } else {
            (0.0, 0.0)
        }
    };
    closing.times_s.extend([8e-3 - 1e-9, 10e-3 + 1e-9]);
    let half_width = (1e-6 - EPSILON_RAD / 1e4).sqrt();
    let criteria = closing.compute_criteria(1e-4);
    assert_near(criteria.tts_s, 9e-3 + half_width, 1e-9);
    assert!((criteria.lost_s - 2.0 * half_width).abs() < 1e-8, "{}", criteria.lost_s);
    assert!(criteria.rebound_percent.expect("some") > 5.0);
}

#[test]
fn a_contact_lost_at_the_end_makes_a_finger_unstable() {
    let mut closing = arrival();
    closing.events.push(lift_off(19.95e-3, FingerContact::Proximal, 0.3));
    closing.forces_n = |t| [if t > 3e-3 && t < 19.95e-3 { 20.0 } else { 0.0 }, if t > 5e-3 { 8.0 } else { 0.0 }];
    let criteria = closing.compute_criteria(1e-4);
    assert_eq!((criteria.tts_s, criteria.class), (None, Class::Unstable));
    assert_near(Some(criteria.lost_s), 0.05e-3, 1e-9);
}

#[test]
fn both_times_agree_when_the_contacts_close_before_the_band_is_reached() {
    // Both contacts are active from 3 ms on, and q11 approaches its position at 2 rad/s.
    let closing = Closing {
        angle: |t| if t <= 9e-3 { (2.0 * (t - 9e-3), 2.0) } else { (0.0, 0.0) },
        forces_n: |t| if t > 3e-3 { [20.0, 8.0] } else { [0.0; 2] },
        events: vec![touch_down(3e-3, FingerContact::Proximal, 1.0), touch_down(3e-3, FingerContact::Distal, 1.0)],
        times_s: vec![9e-3 + 1e-9],
    };
    let criteria = closing.compute_criteria(1e-4);
    assert_near(criteria.t_geo_s, 9e-3 - EPSILON_RAD / 2.0, 1e-9);
    assert_eq!(criteria.t_geo_s, criteria.tts_s);
    assert_eq!(criteria.rebound_percent, Some(0.0));
    assert_eq!(criteria.class, Class::Stable);
}

#[test]
fn a_force_clamped_to_zero_counts_as_a_lost_contact() {
    let mut closing = arrival();
    closing.forces_n = |t| {
        let clamped = (10e-3..=12e-3).contains(&t);
        [if t > 3e-3 { 20.0 } else { 0.0 }, if t > 5e-3 && !clamped { 8.0 } else { 0.0 }]
    };
    let criteria = closing.compute_criteria(1e-5);
    assert_near(criteria.tts_s, 12e-3, 2e-5);
    assert_near(Some(criteria.lost_s), 2e-3, 3e-5);
}

#[test]
fn a_loss_shorter_than_an_impact_is_no_rebound() {
    let mut closing = arrival();
    closing.events.push(lift_off(5.15e-3, FingerContact::Proximal, 0.3));
    closing.events.push(touch_down(5.15e-3 + 4e-7, FingerContact::Proximal, 0.01));
    let criteria = closing.compute_criteria(1e-4);
    assert_near(criteria.tts_s, 5.15e-3 + 4e-7, 1e-12);
    assert_near(Some(criteria.lost_s), 4e-7, 1e-12);
    assert_eq!(criteria.rebound_percent, Some(0.0));
    assert_eq!(criteria.class, Class::Stable);
}

#[test]
fn a_late_arrival_is_semi_unstable() {
    let mut closing = arrival();
    closing.angle = |t| {
        if t <= 16e-3 { (20.0 * (t - 16e-3), 20.0) } else { (0.0, 0.0) }
    };
    closing.forces_n = |t| [if t > 3e-3 { 20.0 } else { 0.0 }, if t > 16e-3 { 8.0 } else { 0.0 }];
    closing.events[1] = touch_down(16e-3, FingerContact::Distal, 1.0);
    closing.times_s.push(16e-3 + 1e-9);
    assert_eq!(closing.compute_criteria(1e-4).class, Class::SemiUnstable);
}

#[test]
fn an_unloaded_contact_is_not_stable_until_reloaded() {
    let mut closing = arrival();
    closing.events.push(lift_off(10.05e-3, FingerContact::Distal, 0.3));
    closing.events.push(reload(11.05e-3, FingerContact::Distal));
    closing.forces_n = |t| {
        let released = (10.05e-3..=11.05e-3).contains(&t);
        [if t > 3e-3 { 20.0 } else { 0.0 }, if t > 5e-3 && !released { 8.0 } else { 0.0 }]
    };
    let criteria = closing.compute_criteria(1e-4);
    assert_near(criteria.tts_s, 11.05e-3, 1e-12);
    assert_near(Some(criteria.lost_s), 1e-3, 1e-9);
}
