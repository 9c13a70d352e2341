//! The dynamic criteria of synthetic closings whose results are known in closed form.

use crate::support::synthetic::{lift_off, posture, reload, touch_down};
use phalanx::criteria::FinalAngles;
use phalanx::criteria::{Class, EPSILON_RAD, RESOLUTION_S, Tracker};
use phalanx::trace::FingerContact::{Distal, Proximal};
use phalanx::trace::{Event, Sink};

const TARGET: FinalAngles = FinalAngles { q11_rad: 0.036, q21_rad: 1.134 };
const END_S: f64 = 20e-3;

/// A synthetic closing with its expected criteria. q21 is at its final value.
struct Closing {
    name: &'static str,
    /// q11 relative to its final value, and its rate, rad and rad/s.
    angle: fn(f64) -> (f64, f64),
    /// Whether the proximal phalanx and the tip have a force.
    is_active: fn(f64) -> [bool; 2],
    events: Vec<Event>,
    /// Intervals of the samples.
    intervals_s: &'static [f64],
    t_geo_s: Option<f64>,
    /// Time to stability with its tolerance.
    tts_s: Option<(f64, f64)>,
    /// Lost time with its tolerance.
    lost_s: (f64, f64),
    class: Class,
}

/// An angle that approaches its final value at a constant rate.
fn approach(time_s: f64, arrival_s: f64, rate_rad_s: f64) -> (f64, f64) {
    if time_s <= arrival_s { (rate_rad_s * (time_s - arrival_s), rate_rad_s) } else { (0.0, 0.0) }
}

/// A finger that arrives at 5 ms at 20 rad/s and stays. The proximal phalanx touches the object from 3 ms on. The 0.17 ms
/// through the ε band are part of the approach, not of a rebound.
fn arrival() -> Closing {
    Closing {
        name: "arrival",
        angle: |t| approach(t, 5e-3, 20.0),
        is_active: |t| [t > 3e-3, t > 5e-3],
        events: vec![touch_down(3e-3, Proximal, 1.0), touch_down(5e-3, Distal, 1.0)],
        intervals_s: &[1e-3, 1e-4, 1e-5],
        t_geo_s: Some(5e-3 - EPSILON_RAD / 20.0),
        tts_s: Some((5e-3, 2e-9)),
        lost_s: (0.0, 0.0),
        class: Class::Stable,
    }
}

impl Closing {
    fn with_events(mut self, events: &[Event]) -> Closing {
        self.events.extend_from_slice(events);
        self
    }

    /// Returns a tracker of the run with samples every `interval_s`, and at all jumps.
    fn track(&self, interval_s: f64) -> Tracker {
        let steps = (END_S / interval_s).round() as usize;
        let mut times: Vec<f64> = (0..=steps).map(|i| END_S * i as f64 / steps as f64).collect();
        times.extend([3e-3, 5e-3, 7e-3, 9e-3, 16e-3].map(|jump_s| jump_s + 1e-9));
        times.extend([8e-3 - 1e-9, 10e-3 + 1e-9]);
        times.sort_by(f64::total_cmp);
        let mut tracker = Tracker::new(TARGET);
        let mut events = self.events.iter().peekable();
        for time in times {
            while let Some(event) = events.next_if(|event| event.time_s <= time) {
                tracker.event(event).expect("never fails");
            }
            let ((angle, rate), [proximal, distal]) = ((self.angle)(time), (self.is_active)(time));
            let forces_n = [if proximal { 20.0 } else { 0.0 }, if distal { 8.0 } else { 0.0 }];
            let sample = posture(time, (TARGET.q11_rad + angle, rate), (TARGET.q21_rad, 0.0), forces_n);
            tracker.sample(&sample).expect("never fails");
        }
        tracker
    }
}

#[test]
fn criteria_of_closings_have_their_closed_forms() {
    use Class::{SemiUnstable, Unstable};
    let half_width = (1e-6 - EPSILON_RAD / 1e4).sqrt();
    let slow_s = 9e-3 - EPSILON_RAD / 2.0;
    for closing in [
        arrival(),
        Closing {
            name: "in position from the start",
            angle: |_| (0.0, 0.0),
            is_active: |_| [true; 2],
            events: Vec::new(),
            t_geo_s: Some(0.0),
            tts_s: Some((0.0, 0.0)),
            ..arrival()
        },
        Closing {
            name: "loses a contact at the end",
            is_active: |t| [t > 3e-3 && t < 19.95e-3, t > 5e-3],
            tts_s: None,
            lost_s: (0.05e-3, 1e-9),
            class: Unstable,
            ..arrival().with_events(&[lift_off(19.95e-3, Proximal, 0.3)])
        },
        // A parabola of 2 ms that leaves the band.
        Closing {
            name: "bounce",
            angle: |t| match t <= 5e-3 || t > 7e-3 {
                true => approach(t, 5e-3, 20.0),
                false => (1e4 * (t - 5e-3) * (t - 7e-3), 1e4 * (2.0 * t - 12e-3)),
            },
            is_active: |t| [true, t > 7e-3],
            events: vec![
                touch_down(5e-3, Distal, 1.0),
                lift_off(5e-3 + 5e-10, Distal, 1e-3),
                touch_down(7e-3, Distal, 0.5),
            ],
            tts_s: Some((7e-3, 2e-9)),
            lost_s: (2e-3, 5e-9),
            class: SemiUnstable,
            ..arrival()
        },
        // q11 deviates between 8 and 10 ms, and is out of the band while 1e4 x (2 ms − x) > ε.
        Closing {
            name: "leaves the band",
            angle: |t| match (8e-3..=10e-3).contains(&t) {
                true => (1e4 * (t - 8e-3) * (10e-3 - t), 1e4 * (18e-3 - 2.0 * t)),
                false => approach(t, 5e-3, 20.0),
            },
            tts_s: Some((9e-3 + half_width, 1e-9)),
            lost_s: (2.0 * half_width, 1e-8),
            class: SemiUnstable,
            ..arrival()
        },
        Closing {
            name: "reaches the band last",
            angle: |t| approach(t, 9e-3, 2.0),
            is_active: |t| [t > 3e-3; 2],
            events: [Proximal, Distal].map(|contact| touch_down(3e-3, contact, 1.0)).to_vec(),
            t_geo_s: Some(slow_s),
            tts_s: Some((slow_s, 1e-9)),
            ..arrival()
        },
        // A force clamped to zero counts as a lost contact.
        Closing {
            name: "clamped force",
            is_active: |t| [t > 3e-3, t > 5e-3 && !(10e-3..=12e-3).contains(&t)],
            intervals_s: &[1e-5],
            tts_s: Some((12e-3, 2e-5)),
            lost_s: (2e-3, 3e-5),
            class: SemiUnstable,
            ..arrival()
        },
        // A loss shorter than an impact is no rebound.
        Closing {
            name: "short loss",
            intervals_s: &[1e-4],
            tts_s: Some((5.15e-3 + 4e-7, 1e-12)),
            lost_s: (4e-7, 1e-12),
            ..arrival().with_events(&[lift_off(5.15e-3, Proximal, 0.3), touch_down(5.15e-3 + 4e-7, Proximal, 0.01)])
        },
        Closing {
            name: "late",
            angle: |t| approach(t, 16e-3, 20.0),
            is_active: |t| [t > 3e-3, t > 16e-3],
            events: vec![touch_down(3e-3, Proximal, 1.0), touch_down(16e-3, Distal, 1.0)],
            t_geo_s: Some(16e-3 - EPSILON_RAD / 20.0),
            tts_s: Some((16e-3, 2e-9)),
            class: SemiUnstable,
            ..arrival()
        },
        // An unloaded contact is not stable until reloaded.
        Closing {
            name: "unloaded",
            intervals_s: &[1e-4],
            is_active: |t| [t > 3e-3, t > 5e-3 && !(10.05e-3..=11.05e-3).contains(&t)],
            tts_s: Some((11.05e-3, 1e-12)),
            lost_s: (1e-3, 1e-9),
            class: SemiUnstable,
            ..arrival().with_events(&[lift_off(10.05e-3, Distal, 0.3), reload(11.05e-3, Distal)])
        },
        Closing {
            name: "never in position",
            angle: |_| (-0.1, 0.0),
            t_geo_s: None,
            tts_s: None,
            class: Unstable,
            ..arrival()
        },
        Closing {
            name: "one contact",
            is_active: |t| [t > 3e-3, false],
            events: vec![touch_down(3e-3, Proximal, 1.0)],
            tts_s: None,
            class: Unstable,
            ..arrival()
        },
    ] {
        for interval_s in closing.intervals_s {
            let criteria = closing.track(*interval_s).criteria(None).expect("a run");
            let (t_geo_s, tts_s) = (criteria.t_geo_s, criteria.tts_s);
            let context = format!("{}: {criteria:?}", closing.name);
            assert!(is_near(t_geo_s, closing.t_geo_s.map(|t_geo_s| (t_geo_s, 1e-9))), "{context}");
            assert!(is_near(tts_s, closing.tts_s), "{context}");
            assert!(is_near(Some(criteria.lost_s), Some(closing.lost_s)), "{context}");
            assert_eq!(criteria.class, closing.class, "{context}");
            let rebound = t_geo_s.zip(tts_s).map(|(geo_s, tts_s)| match closing.lost_s.0 >= RESOLUTION_S {
                true => (100.0 * ((geo_s + END_S) / (tts_s + END_S) - 1.0).abs(), 1e-12),
                false => (0.0, 0.0),
            });
            assert!(is_near(criteria.rebound_percent, rebound), "{context}");
            assert!(closing.name != "reaches the band last" || tts_s == t_geo_s, "{context}");
        }
    }
}

/// Whether two values agree within a tolerance, or neither exists.
fn is_near(value: Option<f64>, expected: Option<(f64, f64)>) -> bool {
    match (value, expected) {
        (Some(value), Some((expected, tolerance))) => (value - expected).abs() <= tolerance,
        (value, expected) => value.is_none() && expected.is_none(),
    }
}

#[test]
fn a_statically_unstable_grasp_is_unstable_for_any_dynamics() {
    let tracker = arrival().track(1e-3);
    assert_eq!(tracker.criteria(Some([3.0, 0.0])).expect("a run").class, Class::Stable);
    let unstable = tracker.criteria(Some([-1.2, 3.0])).expect("a run");
    assert_eq!((unstable.class, unstable.statically_stable), (Class::Unstable, false));
    let verdict = "unstable: the static force on the proximal phalanx is -1.2 N; it must not be negative";
    assert_eq!(unstable.verdict(), verdict);
}
